"""Deviation of a recorded tray from its path, where the path leaves it free."""

from __future__ import annotations

import numpy as np

from nospill.core.attitudes import matrices, yaw_of
from nospill.motion.trajectory import Trajectory
from nospill.scene.scene import Scene


def recorded_freedom(trajectory: Trajectory, scene: Scene) -> list[np.ndarray]:
    """What is free of the tray, part by part; all of it is zero on a given path.

    Returns:
        Where they are free: tilt (m, 2), rad; offset from the path at the recorded s, base axes (m, 3), m; yaw against
        that of the path there (m, 1), rad.
    """
    rules, pose = scene.motion, scene.path.at(trajectory.s)
    parts = [trajectory.tilt] if rules.tilt_free else []
    if rules.corridor is not None:
        parts.append(trajectory.tray_position - pose[:, :3])
    if rules.yaw_free:
        yaw = yaw_of(matrices(trajectory.tray_quaternion))
        parts.append(np.unwrap(yaw - pose[:, 3])[:, None])
    return parts
