"""The motion of a usual controller: a trapezoid of speed along the path on a level tray, as fast as certified.

A third of the time the tray speeds up, a third it goes at constant speed, a third it slows down. The acceleration is
itself a trapezoid of thirds, so that the jerk is limited. Speed, acceleration and jerk along the path are constant
limits, and one number, the duration, moves them all.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nospill.core.paths import Path
from nospill.errors import ModelError
from nospill.judge.certificate import certify
from nospill.motion.trajectory import Trajectory
from nospill.robots.joint_paths.search import JointPath, joint_paths, preferred_path
from nospill.scene.scene import Scene
from nospill.transcription.export_samples import export_samples
from nospill.transcription.starting_motions import motion_along

_JERKS = (1, 1, 1, 0, 0, 0, -1, -1, -1, *[0] * 9, -1, -1, -1, 0, 0, 0, 1, 1, 1)
"""Sign of the jerk in every 27th of the time."""
_INTERVALS = 10
"""In each of these."""
_SLOWEST = 16.0
"""How many times as long as the shortest duration asked about is tried at most."""
_GROWTH = 1.04
"""From one duration to the next that is tried, until one is certified; then it is found by bisection."""
_EXACT = 1e-3
"""Part of the duration to which it is found."""


def trapezoid_motion(scene: Scene, least: float) -> Trajectory | None:
    """The fastest trapezoid that the judge certifies, with a level tray; None where there is none.

    Liquids that swing on make the verdict change back and forth with the duration, so that it is looked for in small
    steps from the shortest on, and by bisection in the step in which the verdict changes first.

    Args:
        scene: the task. Liquids need not come to rest at the end, only stay below their residual height: a profile
            without regard to them cannot do more.
        least: s, duration from which on it is tried.

    Raises:
        ScenarioError: the arm cannot follow the path.
    """
    level = replace(scene, motion=replace(scene.motion, tilt_free=False, end="residual"))
    ways = joint_paths(level.robot, level.path, tool=level.tray.tool)
    way = preferred_path(ways, level.robot, level.start_near)

    def tried(duration: float) -> Trajectory | None:
        try:
            found = played(level, way, duration)
            return found if certify(found, level).ok else None
        except ModelError:
            return None  # too fast for the liquids to be integrated, or for the joints

    low, high, best = least, least, tried(least)
    while best is None and high < _SLOWEST * least:
        low, high = high, _GROWTH * high
        best = tried(high)
    while best is not None and high - low > _EXACT * high:
        middle = 0.5 * (low + high)
        found = tried(middle)
        low, high, best = (middle, high, best) if found is None else (low, middle, found)
    return best


def played(scene: Scene, way: JointPath, duration: float) -> Trajectory:
    """The trapezoid of a duration in s, as the samples of a file.

    Raises:
        ModelError: the joints cannot follow.
    """
    place, speed, acceleration = profile(_INTERVALS * len(_JERKS))
    chain = along(scene.path, place, speed / duration, acceleration / duration**2)
    return export_samples(scene, motion_along(scene, way, [chain], duration))


def profile(intervals: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Part of the way, speed and acceleration (n + 1,) over a unit of time, at so many equal intervals."""
    step = 1.0 / intervals
    jerk = np.repeat(np.array(_JERKS, dtype=float), intervals // len(_JERKS))
    acceleration = np.concatenate([[0.0], np.cumsum(jerk) * step])
    speed = np.concatenate([[0.0], np.cumsum(acceleration[:-1] * step + jerk * step**2 / 2)])
    place = np.concatenate([[0.0], np.cumsum(speed[:-1] * step + acceleration[:-1] * step**2 / 2 + jerk * step**3 / 6)])
    whole = place[-1]
    return place / whole, speed / whole, acceleration / whole


def along(path: Path, place: np.ndarray, speed: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
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
    own, change = np.interp(at, s, slope), np.interp(at, s, bend)
    rate = speed * length[-1] / own
    return np.column_stack([at, rate, (acceleration * length[-1] - change * rate**2) / own])
