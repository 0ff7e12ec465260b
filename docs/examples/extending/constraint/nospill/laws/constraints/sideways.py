"""Sideways acceleration: what a fragile object, or a guest looking at it, can bear."""

from __future__ import annotations

from nospill.core.frames import SX
from nospill.laws.constraints.base import Budget, Cone, Constraint, EvaluationPoint, Role, standing, standing_names
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene

LIMIT = 3.0
"""m/s^2."""


class Sideways(Constraint):
    """|(b_x, b_y)| <= LIMIT, with b the specific force at the object's bottom, object axes."""

    name = "sideways"
    unit = "m/s^2"
    role = Role.CONTACT
    evaluated_at = EvaluationPoint.OBJECT
    description = "Apparent acceleration of an object along the tray."

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every object that stands on the tray itself."""
        return standing_names(scene)

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One cone an object; its capacity is constant, so the size of the capacity is the capacity."""
        limit = SX(LIMIT)
        return tuple((Cone(item.motion.specific_force[:2], limit, limit),) for item in standing(sample))
