"""Trough: where a liquid is shallow, its surface must not reach the bottom of the cup."""

from __future__ import annotations

from nospill.laws.constraints.base import Budget, Cone, Constraint, EvaluationPoint, Role
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene


class Trough(Constraint):
    """Trough below the rest level <= depth of the liquid; the surface is as deep on one side as it is high opposite.

    A bottom that falls dry leaves a film that runs instead of the modes of a full cup. Where max_slosh_height is at
    most the depth, the slosh height says as much.
    """

    name = "trough"
    unit = "m"
    role = Role.LIQUID
    evaluated_at = EvaluationPoint.OBJECT
    description = (
        "Lowest point of a shallow liquid's surface at the wall below its rest level, against its depth; where "
        "max_slosh_height is larger than that."
    )
    backoff = 1.5e-3
    restart_backoff = 2.3e-3
    judge_resolution = 2e-4
    integration_error = 2e-7

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every object whose surface may rise by more than its liquid is deep."""
        return tuple(cargo.name for cargo in scene.cargo if cargo.filling is not None and cargo.filling.shallow)

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """As for the slosh height: one cone for a circular wall, two bands for a box."""
        return tuple(
            tuple(Cone(demand, item.numbers.liquid_depth, item.numbers.liquid_depth) for demand in item.wall_vectors)
            for item in sample.objects
            if item.structure.shallow
        )
