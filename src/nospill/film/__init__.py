"""A judged motion as pictures: meshes, surfaces of the liquids, colours, cameras; a film drawn without OpenGL."""
