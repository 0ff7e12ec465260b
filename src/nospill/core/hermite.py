"""Cubic Hermite interpolation: the cubic with given values and slopes at both ends of an interval, and its slope."""

from __future__ import annotations

import numpy as np


def cubic_hermite(
    u: np.ndarray | float, width: np.ndarray | float, values: np.ndarray, slopes: np.ndarray
) -> np.ndarray:
    """Value of the cubic within an interval.

    Args:
        u: place in the interval, 0 to 1; broadcasts against one end's values.
        width: of the interval, likewise.
        values: (2, ...) at its start and at its end.
        slopes: (2, ...) derivatives there.
    """
    rise = u * u * (3.0 - 2.0 * u)
    bend = (1.0 - u) * (width * slopes[0]) - u * (width * slopes[1])
    return values[0] + rise * (values[1] - values[0]) + u * (1.0 - u) * bend


def cubic_hermite_slope(
    u: np.ndarray | float, width: np.ndarray | float, values: np.ndarray, slopes: np.ndarray
) -> np.ndarray:
    """Slope of the same cubic; arguments as of `cubic_hermite`."""
    bend = (1.0 - u) * (1.0 - 3.0 * u) * slopes[0] + u * (3.0 * u - 2.0) * slopes[1]
    return 6.0 * u * (1.0 - u) * (values[1] - values[0]) / width + bend
