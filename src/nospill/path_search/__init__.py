"""A collision-free path from start to goal, the branch of the arm along it and the yaw of its base."""
