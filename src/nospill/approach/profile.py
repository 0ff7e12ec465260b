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
        curve: ruckig's trajectory.
    """

    start: np.ndarray
    end: np.ndarray
    duration: float
    curve: Any

    def at(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return position, speed and acceleration, (m, n) each, at times (m,) in s; at rest outside 0 to `duration`.

        The ends are met exactly: what rounding leaves there is taken out.
        """
        shape = (len(t), len(self.start))
        position, speed, acceleration = (np.zeros(shape) for _ in range(3))
        for row, instant in enumerate(np.clip(t, 0.0, self.duration)):
            position[row], speed[row], acceleration[row] = self.curve.at_time(float(instant))
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
    """Return the fastest motion in which all joints keep pace, so that the way is a straight line in joint space.

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
    count = len(start)
    wanted = library.InputParameter(count)
    wanted.current_position, wanted.target_position = start.tolist(), end.tolist()
    wanted.max_velocity = max_speed.tolist()
    wanted.max_acceleration, wanted.max_jerk = max_acceleration.tolist(), max_jerk.tolist()
    wanted.synchronization = library.Synchronization.Phase
    curve = library.Trajectory(count)
    try:
        outcome = library.Ruckig(count).calculate(wanted, curve)
    except library.RuckigError as error:
        raise ModelError(f"approach: ruckig refuses it ({' '.join(str(error).split())[:200]})") from error
    if outcome not in (library.Result.Working, library.Result.Finished):
        raise ModelError(f"approach: ruckig finds no motion ({outcome})")
    return Profile(start, end, float(curve.duration), curve)
