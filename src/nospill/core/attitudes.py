"""Attitudes as quaternions and matrices of numbers; the same as expressions is in `frames`.

A quaternion is x, y, z, w with w the cosine of half the turn; R(q) and R(-q) are one attitude.
"""

from __future__ import annotations

import numpy as np


def tray_quaternions(yaw: np.ndarray, theta_y: np.ndarray, theta_x: np.ndarray) -> np.ndarray:
    """Unit quaternions (m, 4) of R = Rz(yaw) Ry(theta_y) Rx(theta_x), angles (m,) in rad; steady where these are."""
    (sz, sy, sx), (cz, cy, cx) = ([wave(angle / 2) for angle in (yaw, theta_y, theta_x)] for wave in (np.sin, np.cos))
    return np.column_stack(
        [
            cz * cy * sx - sz * sy * cx,
            cz * sy * cx + sz * cy * sx,
            sz * cy * cx - cz * sy * sx,
            cz * cy * cx + sz * sy * sx,
        ]
    )


def matrices(quaternions: np.ndarray) -> np.ndarray:
    """R (m, 3, 3) of quaternions (m, 4) of any length but zero, which gives no numbers."""
    with np.errstate(invalid="ignore", divide="ignore"):
        x, y, z, w = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def angles_between(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Angle (m,), rad, of the turn from one of the rotations (m, 3, 3) to the other.

    |R_1 - R_2| = 2 sqrt(2) sin(angle / 2) in the Frobenius norm, which loses no digits where the angle is small.
    """
    distance = np.linalg.norm(first - second, axis=(1, 2))
    return 2.0 * np.arcsin(np.minimum(distance / np.sqrt(8.0), 1.0))


def yaw_of(rotations: np.ndarray) -> np.ndarray:
    """Yaw (m,), rad, of R = Rz(yaw) Ry(theta_y) Rx(theta_x) (m, 3, 3), |theta_y| below a quarter turn."""
    return np.arctan2(rotations[:, 1, 0], rotations[:, 0, 0])
