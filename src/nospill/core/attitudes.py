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


def tilt_of(rotations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """theta_x and theta_y (m,), rad, of R = Rz(yaw) Ry(theta_y) Rx(theta_x) (m, 3, 3).

    The last row of R is -sin theta_y, cos theta_y sin theta_x, cos theta_y cos theta_x.
    """
    last = rotations[:, 2]
    return np.arctan2(last[:, 1], last[:, 2]), np.arcsin(np.clip(-last[:, 0], -1.0, 1.0))


def quaternions(rotations: np.ndarray) -> np.ndarray:
    """Unit quaternions (m, 4) of rotations (m, 3, 3), steady where these are.

    Row and column k of the matrix of products 4 q q^T follow from R; that of the largest entry is taken
    [S. W. Shepperd, Quaternion from rotation matrix, 1978].
    """
    r, trace = rotations, np.trace(rotations, axis1=1, axis2=2)
    products = np.empty((len(r), 4, 4))
    for i in range(3):
        for k in range(3):
            products[:, i, k] = r[:, i, k] + r[:, k, i] if i != k else 1.0 + 2.0 * r[:, i, i] - trace
        j, k = (i + 1) % 3, (i + 2) % 3
        products[:, i, 3] = products[:, 3, i] = r[:, k, j] - r[:, j, k]
    products[:, 3, 3] = 1.0 + trace
    largest = np.argmax(np.diagonal(products, axis1=1, axis2=2), axis=1)
    found = products[np.arange(len(r)), largest]
    found /= np.linalg.norm(found, axis=1, keepdims=True)
    turned = np.sum(found[1:] * found[:-1], axis=1) < 0.0
    found[1:][np.cumsum(turned) % 2 == 1] *= -1.0
    return found
