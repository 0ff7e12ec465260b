"""A robot as data: descriptions in URDF, the catalogue, limits."""
