"""A motion from rest to rest, straight in joint space, as fast as limits of speed, acceleration and jerk allow.

The library ruckig finds it [Berscheid and Kroeger, Jerk-limited Real-time Trajectory Generation with Arbitrary Target
States, RSS 2021]; it comes with the extra `approach`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nospill.errors import MissingExtraError, ModelError


@dataclass(frozen=True, slots=True)
class Profile:
    """A motion of n joints from rest to rest.

    Attributes:
        start: (n,) rad.
        end: (n,) rad.
        duration: s; zero where both are the same.
        curve: ruckig's trajectory of the joint that goes farthest, from 0 to its way, rad.
    """

    start: np.ndarray
    end: np.ndarray
    duration: float
    curve: Any

    def at(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return position, speed and acceleration, (m, n) each, at times (m,) in s; at rest outside 0 to `duration`.

        The ends are met exactly: what rounding leaves there is taken out.
        """
        travelled = np.array([self.curve.at_time(float(instant)) for instant in np.clip(t, 0.0, self.duration)])
        part, _ = _parts(self.end - self.start)
        position, speed, acceleration = (order * part for order in travelled.reshape(-1, 3, 1).swapaxes(0, 1))
        position += self.start
        for outside, rest in ((t <= 0.0, self.start), (t >= self.duration, self.end)):
            position[outside], speed[outside], acceleration[outside] = rest, 0.0, 0.0
        return position, speed, acceleration


def require_ruckig() -> Any:
    """Return the library.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        import ruckig
    except ImportError as error:
        raise MissingExtraError(
            "an approach needs the library ruckig; install it with pip install 'nospill[approach]'"
        ) from error
    return ruckig


def jerk_limited(
    start: np.ndarray, end: np.ndarray, *, max_speed: np.ndarray, max_acceleration: np.ndarray, max_jerk: np.ndarray
) -> Profile:
    """Return the fastest motion along the straight line in joint space.

    All joints are parts of one motion, that of the joint which goes farthest, under the limits that all of them leave
    it. Ruckig's own synchronisation in phase is none where the joint that needs longest is not the one which limits the
    acceleration or the jerk: it then lets every joint run by itself, off the line.

    Args:
        start: (n,) joint positions, rad.
        end: likewise.
        max_speed: (n,) limits above zero, rad/s.
        max_acceleration: likewise, rad/s^2.
        max_jerk: likewise, rad/s^3.

    Raises:
        MissingExtraError: ruckig is not installed.
        ModelError: ruckig finds none (its reason is in the message).
    """
    library = require_ruckig()
    part, longest = _parts(end - start)
    moving = part != 0.0
    with np.errstate(over="ignore"):  # a joint that hardly moves limits nothing
        least = [
            float(np.min(limit[moving] / np.abs(part[moving])) if longest > 0.0 else np.min(limit))
            for limit in (max_speed, max_acceleration, max_jerk)
        ]
    wanted = library.InputParameter(1)
    wanted.current_position, wanted.target_position = [0.0], [longest]
    wanted.max_velocity, wanted.max_acceleration, wanted.max_jerk = ([limit] for limit in least)
    curve = library.Trajectory(1)
    try:
        outcome = library.Ruckig(1).calculate(wanted, curve)
    except library.RuckigError as error:
        raise ModelError(f"approach: ruckig refuses it ({' '.join(str(error).split())[:200]})") from error
    if outcome not in (library.Result.Working, library.Result.Finished):
        raise ModelError(f"approach: ruckig finds no motion ({outcome})")
    return Profile(start, end, float(curve.duration), curve)


def _parts(way: np.ndarray) -> tuple[np.ndarray, float]:
    """(n,) how far each joint goes per way of the one that goes farthest, and that way, rad."""
    longest = float(np.max(np.abs(way)))
    return (way / longest if longest > 0.0 else np.zeros_like(way)), longest
