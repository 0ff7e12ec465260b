"""Geometric paths of the tray's origin and its yaw, as piecewise polynomials of the path parameter s in [0, 1]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class Path:
    """r(s) and theta_z(s) of the tray frame in the robot's base frame.

    Attributes:
        breaks: (m + 1,) increasing, from 0 to 1.
        coefficients: (degree + 1, m, 4) for x, y, z (m) and yaw (rad); highest power first, in powers of (s - breaks[i]).
            All four are at least three times continuously differentiable inside (C3), so that jerk-limited s gives continuous acceleration.
    """

    breaks: np.ndarray
    coefficients: np.ndarray
