"""Hermite interpolation: cubics with given values and slopes at both ends of an interval, quintics with bends too."""

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


def quintic_hermite(width: np.ndarray, values: np.ndarray, slopes: np.ndarray, bends: np.ndarray) -> np.ndarray:
    """Coefficients (6, m, k), highest power first, of the quintics with given ends.

    Args:
        width: (m, 1) of the intervals.
        values: (2, m, k) at their starts and at their ends.
        slopes: (2, m, k) derivatives there.
        bends: (2, m, k) second derivatives there.
    """
    h, rise = width, values[1] - values[0]
    cubic = 20.0 * rise - (8.0 * slopes[1] + 12.0 * slopes[0]) * h - (3.0 * bends[0] - bends[1]) * h**2
    quartic = -30.0 * rise + (14.0 * slopes[1] + 16.0 * slopes[0]) * h + (3.0 * bends[0] - 2.0 * bends[1]) * h**2
    fifth = 12.0 * rise - 6.0 * (slopes[1] + slopes[0]) * h + (bends[1] - bends[0]) * h**2
    return np.stack([fifth / (2 * h**5), quartic / (2 * h**4), cubic / (2 * h**3), bends[0] / 2, slopes[0], values[0]])
