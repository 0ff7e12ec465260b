"""Lift: the tray must press every object, a carrier what stands in it."""

from __future__ import annotations

from nospill.core.frames import SX
from nospill.laws.constraints.base import Budget, Constraint, EvaluationPoint, Range, Role, loose, loose_names
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene


class Lift(Constraint):
    """N >= 0, printed as N over the object's weight [D3, waiter's constraints]."""

    name = "lift"
    unit = "weight"
    role = Role.CONTACT
    evaluated_at = EvaluationPoint.OBJECT
    description = (
        "The contact force presses the object onto the tray, or into its carrier; printed as a multiple of its weight."
    )
    judge_resolution = 2e-4
    least_size = 1.0

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every object that is not fixed."""
        return loose_names(scene)

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """N/(m g) >= 0 per object."""
        return tuple((Range(item.wrench.force[2] / item.numbers.weight, SX(0), None, SX(1)),) for item in loose(sample))
