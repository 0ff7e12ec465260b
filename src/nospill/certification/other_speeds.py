"""The same motion at other speeds, as a controller's override plays it: largest uses of the limits on objects.

Slower is not safer. A tray that leans against its acceleration leans too much when it is played slowly, and a liquid
that comes to rest at the end of a motion does not after the same motion in another time. To spill, slide or tip is one
thing; to swing higher than a scenario wishes, below the rim, is another.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from operator import itemgetter

import numpy as np

from nospill.certification.replay import replay
from nospill.certification.rims import rims_below
from nospill.certification.traces import constraint_traces
from nospill.certification.verdict import Trace
from nospill.laws.constraints import constraints_of
from nospill.laws.constraints.base import OF_OBJECTS, Role
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
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
        worst_contact: likewise, of contacts alone.
        height: crest, in the motion or after it, of the liquid that comes nearest to its rim, m; 0 without liquids.
        below_rim: how far below its rim that liquid stays, upright, m, negative over it; None without liquids.
    """

    speed: float
    liquid: float
    contact: float
    worst: str
    worst_contact: str = ""
    height: float = 0.0
    below_rim: float | None = None

    @property
    def spills(self) -> bool:
        """Whether a liquid comes over its rim."""
        return self.below_rim is not None and self.below_rim < 0.0

    @property
    def safe(self) -> bool:
        """Whether nothing spills, slides, tips or lifts off; liquids may swing higher than is wished."""
        return self.contact <= 1.0 and not self.spills

    @property
    def rim_use(self) -> float:
        """The crest as a part of the way to the rim; 0 without liquids."""
        return 0.0 if self.below_rim is None else self.height / max(self.height + self.below_rim, 1e-9)


def uses_at(trajectory: Trajectory, scene: Scene, speeds: Iterable[float] = SPEEDS) -> tuple[SpeedUse, ...]:
    """Largest uses of a motion, without its holds, at some speeds: of like objects those of the outer ones.

    None without objects, or where none of them has a limit.

    Raises:
        ModelError: the liquids cannot be integrated at one of them.
    """
    scene, motion = replace(scene, cargo=hull_objects(scene)), trajectory.motion
    limited = any(item.evaluated_at in OF_OBJECTS and item.subjects(scene) for item in constraints_of(scene))
    return tuple(_use(trajectory, scene, motion, speed) for speed in speeds) if limited else ()


def object_traces(record: Trajectory, scene: Scene, motion: JointMotion) -> tuple[Trace, ...]:
    """Traces of the limits on objects along a motion, on the coarse grid.

    Args:
        record: the motion as samples.
        scene: of which objects.
        motion: what the joints do.

    Raises:
        ModelError: the liquids cannot be integrated.
    """
    played = replay(record, scene, motion=motion, rate=_RATE)
    return constraint_traces(record, scene, played, points=OF_OBJECTS)


def _use(trajectory: Trajectory, scene: Scene, motion: JointMotion, speed: float) -> SpeedUse:
    traces = object_traces(at_speed(trajectory, speed), scene, SlowedMotion(motion, speed))
    uses = [(float(np.max(trace.use)), trace) for trace in traces]

    def largest(role: Role) -> tuple[float, Trace] | None:
        own = [item for item in uses if item[1].known is not None and item[1].known.role is role]
        return max(own, key=itemgetter(0), default=None)

    crests: dict[str, float] = {}
    for trace in traces:
        if trace.constraint in (SloshHeight.name, ResidualHeight.name):
            crests[trace.subject] = max(float(np.max(np.abs(trace.value))), crests.get(trace.subject, 0.0))
    nearest = next(iter(rims_below(scene, crests)), None)
    liquid, contact = largest(Role.LIQUID), largest(Role.CONTACT)
    return SpeedUse(
        speed,
        liquid=0.0 if liquid is None else liquid[0],
        contact=0.0 if contact is None else contact[0],
        worst=_subject_text(max(uses, key=itemgetter(0))[1]),
        worst_contact="" if contact is None else _subject_text(contact[1]),
        height=0.0 if nearest is None else crests[nearest.subject],
        below_rim=None if nearest is None else nearest.edge.below_rim,
    )


def _subject_text(trace: Trace) -> str:
    return f"{trace.constraint} | {trace.subject}"
