"""Who plays a motion file, and how it moves between the points: one table."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nospill.errors import ScenarioError
from nospill.motion.interpolation import (
    CUBIC_HERMITE,
    CUBIC_SPLINE,
    QUINTIC_HERMITE,
    QUINTIC_SPLINE,
    Interpolation,
    JointSamples,
    linear_at,
)

_SAME = 1.01
"""A period may be longer by a hundredth: stamps are rounded."""


@dataclass(frozen=True, slots=True)
class Receiver:
    """One way to play points.

    Attributes:
        name: key in the table.
        title: what it is, in one line.
        interpolation: (points, samples a second that the controller asks its drives for, Hz) -> what it makes of them.
        period: s; longest distance of points that it takes, None for any.
    """

    name: str
    title: str
    interpolation: Callable[[JointSamples, float], Interpolation]
    period: float | None = None


def _as_jtc(samples: JointSamples, rate: float) -> Interpolation:
    if samples.speed is None:
        return linear_at(rate)
    return CUBIC_HERMITE if samples.acceleration is None else QUINTIC_HERMITE


RECEIVERS: dict[str, Receiver] = {
    receiver.name: receiver
    for receiver in (
        Receiver(
            "jtc",
            "ROS 2 joint_trajectory_controller with splines: quintic through positions, speeds and accelerations, "
            "cubic without accelerations, straight lines without speeds",
            _as_jtc,
        ),
        Receiver("linear", "straight lines between the points", lambda _, rate: linear_at(rate)),
        Receiver("cubic", "one cubic spline through the positions", lambda *_: CUBIC_SPLINE),
        Receiver("quintic", "one quintic spline through the positions", lambda *_: QUINTIC_SPLINE),
        Receiver(
            "servoj", "Universal Robots' servoj, a point every 8 ms or less", lambda *_: QUINTIC_SPLINE, period=8e-3
        ),
        Receiver("fci", "Franka's control interface, a point every 1 ms", lambda *_: QUINTIC_SPLINE, period=1e-3),
    )
}
"""Every receiver by its name."""


def receiver_named(name: str) -> Receiver:
    """The receiver of a name.

    Raises:
        ScenarioError: there is none.
    """
    if name not in RECEIVERS:
        raise ScenarioError(f'as "{name}" is no receiver; there are: {", ".join(RECEIVERS)}')
    return RECEIVERS[name]


def usual_receiver(samples: JointSamples) -> Receiver:
    """The receiver where none is named: points with speeds are played by splines, positions alone by one spline."""
    return RECEIVERS["jtc" if samples.speed is not None else "quintic"]


def interpolation_of(receiver: Receiver, samples: JointSamples, rate: float, origin: str) -> Interpolation:
    """What a receiver makes of points.

    Raises:
        ScenarioError: they are too far apart for it.
    """
    widest = float(np.max(np.diff(samples.t)))
    if receiver.period is not None and widest > _SAME * receiver.period:
        raise ScenarioError(
            f"{origin}: {receiver.name} plays a point every {1e3 * receiver.period:g} ms or less, and points are up to "
            f"{1e3 * widest:.3g} ms apart; say as what else they are played (--as jtc)"
        )
    return receiver.interpolation(samples, rate)
