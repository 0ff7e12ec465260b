"""Twist: friction must hold every object against turning on the spot."""

from __future__ import annotations

from nospill.laws.constraints.base import (
    Budget,
    Cone,
    Constraint,
    EvaluationPoint,
    ObjectKey,
    Role,
    standing,
    standing_names,
)
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene


class Twist(Constraint):
    """|M_z| <= mu N r, r the mean lever arm of friction: 2R/3 for a disc [D3, absolute value added]."""

    name = "twist"
    unit = "1"
    role = Role.CONTACT
    evaluated_at = EvaluationPoint.OBJECT
    relative = True
    description = "Moment about the object's vertical axis against what friction gives under uniform pressure."
    backoff = 3e-3
    restart_backoff = 5e-3
    judge_resolution = 1.5e-3
    limit_key = ObjectKey("friction")

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every object that friction holds on the tray itself."""
        return standing_names(scene)

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One band per object."""
        bands = []
        for item in standing(sample):
            lever = item.numbers.planned_friction * item.numbers.twist_radius
            bands.append((Cone(item.wrench.moment[2], lever * item.wrench.force[2], lever * item.numbers.weight),))
        return tuple(bands)
