"""The same motion at other speeds, as a controller's override plays it: largest uses of the limits on objects.

Slower is not safer. A tray that leans against its acceleration leans too much when it is played slowly, and a liquid
that comes to rest at the end of a motion does not after the same motion in another time.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from operator import itemgetter

import numpy as np

from nospill.judge.replay import replay
from nospill.judge.traces import constraint_traces
from nospill.laws.constraints.base import OF_OBJECTS, Role
from nospill.laws.like_objects import hull_objects
from nospill.motion.at_speed import SlowedMotion, at_speed
from nospill.motion.interpolation import JointMotion
from nospill.motion.trajectory import Trajectory
from nospill.scene.scene import Scene

SPEEDS = tuple(round(float(speed), 3) for speed in np.geomspace(0.1, 0.95, 12))
"""Parts of the planned speed that are looked at; a figure that needs more asks for its own."""

_RATE = 500.0
"""Hz, of the grid: uses agree within 0.1 % with those at the judge's rate."""


@dataclass(frozen=True, slots=True)
class SpeedUse:
    """What a motion uses of its limits on objects at another speed.

    Attributes:
        speed: part of the planned speed.
        liquid: largest use of a limit on a liquid (height, trough, residual), as `limit_use`; 0 without liquids.
        contact: largest use of a limit on a contact (lift, slip, tip, twist).
        worst: constraint and object that use most, "slip | c1".
    """

    speed: float
    liquid: float
    contact: float
    worst: str


def uses_at(trajectory: Trajectory, scene: Scene, speeds: Iterable[float] = SPEEDS) -> tuple[SpeedUse, ...]:
    """Largest uses of a motion, without its holds, at some speeds: of like objects those of the outer ones.

    Raises:
        ModelError: the liquids cannot be integrated at one of them.
    """
    scene, motion = replace(scene, cargo=hull_objects(scene)), trajectory.motion
    return tuple(_use(trajectory, scene, motion, speed) for speed in speeds)


def _use(trajectory: Trajectory, scene: Scene, motion: JointMotion, speed: float) -> SpeedUse:
    slower = at_speed(trajectory, speed)
    played = replay(slower, scene, motion=SlowedMotion(motion, speed), rate=_RATE)
    traces = constraint_traces(slower, scene, played, points=OF_OBJECTS)
    uses = [(float(np.max(trace.use)), trace) for trace in traces]
    _, worst = max(uses, key=itemgetter(0))

    def largest(role: Role) -> float:
        return max((use for use, trace in uses if trace.known is not None and trace.known.role is role), default=0.0)

    return SpeedUse(speed, largest(Role.LIQUID), largest(Role.CONTACT), f"{worst.constraint} | {worst.subject}")
