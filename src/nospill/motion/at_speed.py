"""A motion at a part of its speed, as a controller's override plays it: the same way, in a time that runs slower."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nospill.motion.interpolation import JointMotion
from nospill.motion.trajectory import Trajectory


def at_speed(trajectory: Trajectory, speed: float) -> Trajectory:
    """The record of a motion played at a part of its speed: t/v, rates times v, accelerations times v^2.

    The columns of the liquids stay as they are, and do not belong to it.
    """
    rates = {name: getattr(trajectory, name) * speed for name in ("s_rate", "tilt_rate", "joint_speed")}
    second = ("s_acceleration", "tilt_acceleration", "joint_acceleration")
    return replace(
        trajectory,
        t=trajectory.t / speed,
        **rates,
        **{name: getattr(trajectory, name) * speed**2 for name in second},
    )


@dataclass(frozen=True, slots=True)
class SlowedMotion:
    """What joints do, at a part of its speed.

    Attributes:
        motion: at its own speed.
        speed: the part.
    """

    motion: JointMotion
    speed: float

    def __call__(self, t: np.ndarray, order: int = 0, /) -> np.ndarray:
        """Return the derivative of this order at times `t` of the slow motion."""
        slowed: np.ndarray = self.motion(t * self.speed, order) * self.speed**order
        return slowed
