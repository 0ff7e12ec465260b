"""What knows nothing of the task: units, files, rotations, piecewise polynomials, paths, batches of evaluations."""
