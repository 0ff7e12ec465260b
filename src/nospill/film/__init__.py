"""A judged motion as a film, drawn without OpenGL."""
