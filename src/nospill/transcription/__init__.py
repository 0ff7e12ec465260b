"""From a scene to a nonlinear programme, its solution, and back to samples."""
