"""The 3-D model of a scene in motion: bodies, meshes, liquid surfaces, cameras."""
