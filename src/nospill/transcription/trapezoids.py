"""Motions of a usual controller: a trapezoid of speed along the path on a level tray.

A part of the time the tray speeds up, for the same time it slows down at the end, between it goes at constant speed.
The acceleration is itself a trapezoid of thirds, so that the jerk is limited.
"""

from __future__ import annotations

import numpy as np

from nospill.motion.trajectory import Trajectory
from nospill.paths.path import Path
from nospill.robots.joint_paths.search import JointPath
from nospill.scene.scene import Scene
from nospill.transcription.export_samples import export_samples
from nospill.transcription.starting_motions import motion_along

PIECES = 27
"""Equal parts of the time; the jerk is constant in each."""
THIRD = 3
"""Parts of the time in each third of a ramp: with three the tray speeds up for a third of the time."""
_INTERVALS = 10
"""In each part."""


def trapezoid_trajectory(scene: Scene, way: JointPath, duration: float, ramp: int = THIRD) -> Trajectory:
    """The trapezoid of a duration in s, as the samples of a file.

    Args:
        scene: with a level tray.
        way: of the joints along its path.
        duration: s.
        ramp: parts of the time in each third of speeding up and of slowing down, 1 to 4.

    Raises:
        ModelError: the joints cannot follow.
    """
    place, speed, acceleration = profile(_INTERVALS * PIECES, ramp)
    chain = path_parameter_rates(scene.path, place, speed / duration, acceleration / duration**2)
    return export_samples(scene, motion_along(scene, way, [chain], duration))


def profile(intervals: int, ramp: int = THIRD) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Part of the way, speed and acceleration (n + 1,) over a unit of time, at so many equal intervals."""
    step = 1.0 / intervals
    up, still = [1.0] * ramp, [0.0] * ramp
    down = [-1.0] * ramp
    signs = [*up, *still, *down, *[0.0] * (PIECES - 6 * ramp), *down, *still, *up]
    jerk = np.repeat(np.array(signs), intervals // PIECES)
    acceleration = np.concatenate([[0.0], np.cumsum(jerk) * step])
    speed = np.concatenate([[0.0], np.cumsum(acceleration[:-1] * step + jerk * step**2 / 2)])
    place = np.concatenate([[0.0], np.cumsum(speed[:-1] * step + acceleration[:-1] * step**2 / 2 + jerk * step**3 / 6)])
    whole = place[-1]
    return place / whole, speed / whole, acceleration / whole


def path_parameter_rates(path: Path, place: np.ndarray, speed: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    """Path parameter, its rate and its acceleration (n, 3) for parts of the path's length and their rates.

    Where the path only turns, its parameter counts in place of its length.
    """
    s = np.linspace(0.0, 1.0, 4001)
    first, second = (path.derivative(s, order)[:, :3] for order in (1, 2))
    slope = np.linalg.norm(first, axis=1)
    if np.min(slope) < 1e-6:
        return np.column_stack([place, speed, acceleration])
    length = np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(s))])
    bend = np.sum(first * second, axis=1) / slope
    at = np.interp(place * length[-1], length, s)
    slope_at, change = np.interp(at, s, slope), np.interp(at, s, bend)
    rate = speed * length[-1] / slope_at
    return np.column_stack([at, rate, (acceleration * length[-1] - change * rate**2) / slope_at])
