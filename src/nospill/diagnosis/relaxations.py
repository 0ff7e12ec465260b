"""Relaxations of a constraint: the keys of a scenario that widen its limit, from `Constraint.limit_key`."""

from __future__ import annotations

from dataclasses import replace

from nospill.diagnosis.joint_relaxations import lighter_load, relaxed_joint_limit
from nospill.diagnosis.object_relaxations import relaxed_centre_of_mass, relaxed_friction, relaxed_slosh_height
from nospill.diagnosis.relaxation import Relaxation, Sensitivities, instead_text
from nospill.errors import Change
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.base import JointKey, MotionKey, ObjectKey
from nospill.scene.scene import Scene

_SMALLEST = 1e-3
"""A key that allows no larger share than this is no help."""

_OF_OBJECTS = {
    "friction": relaxed_friction,
    "max_slosh_height": relaxed_slosh_height,
    "centre_of_mass": relaxed_centre_of_mass,
}
"""By `ObjectKey.key`."""


def relaxations_of(scene: Scene, constraint: str, subject: str, sensitivities: Sensitivities) -> list[Relaxation]:
    """Relaxations of a constraint; none where no key relaxes it alone.

    Args:
        scene: the task.
        constraint: name of the constraint that holds the motion back.
        subject: subject that does most.
        sensitivities: of every subject of every constraint.
    """
    limit = BY_NAME[constraint].limit_key if constraint in BY_NAME else None
    match limit:
        case ObjectKey():
            relaxations = _OF_OBJECTS[limit.key](scene, constraint, subject, sensitivities)
        case JointKey():
            relaxations = relaxed_joint_limit(scene, limit, constraint, subject, sensitivities)
            if limit.falls_with_load:
                relaxations += lighter_load(scene, constraint, subject)
        case MotionKey():
            relaxations = _rule_relaxations(scene, limit, constraint, subject)
        case None:
            relaxations = []
    return [relaxation for relaxation in relaxations if relaxation.most > _SMALLEST]


def _rule_relaxations(scene: Scene, limit: MotionKey, constraint: str, subject: str) -> list[Relaxation]:
    """A rule of the motion, wider."""
    key = limit.key
    now = float(getattr(scene.motion, key))

    def change(share: float) -> Change:
        value = now * (1.0 + share)
        return Change.of_limit(
            constraint, subject, f"{limit.table}.{key}", value, instead_text(key, value, now, limit.dimension)
        )

    def milder(share: float) -> Scene:
        return replace(scene, motion=replace(scene.motion, **{key: now * (1.0 + share)}))

    return [Relaxation(constraint, subject, limit.largest / now - 1.0, change, milder)]
