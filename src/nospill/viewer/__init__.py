"""The viewer: a plan as it moves, live in the browser or as one file.

Frames: world is the robot's base, z up, lengths in m. Quaternions go to viser as (w, x, y, z); `Trajectory` keeps
(x, y, z, w), so whoever reads one there turns it round first. What is shown was recomputed by the judge from the
exported joints, nothing comes from the optimiser.
"""
