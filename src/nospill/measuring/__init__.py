"""Heights of liquids from films of transparent vessels; the only package that imports OpenCV."""
