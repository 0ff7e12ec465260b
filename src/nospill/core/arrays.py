"""Arrays of frozen records."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def read_only(values: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return a copy as an array of floats that cannot be written to."""
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array


def parallel_axis(arm: np.ndarray) -> np.ndarray:
    """Return the inertia (3, 3) of a unit point mass at `arm` (3,), m, about the origin, kg m^2."""
    return float(arm @ arm) * np.eye(3) - np.outer(arm, arm)


def cross(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the cross products (..., 3) of two stacks of vectors, several times as fast as numpy's on short stacks."""
    x, y, z = (first[..., axis] for axis in range(3))
    u, v, w = (second[..., axis] for axis in range(3))
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=-1)
