"""Slosh height: the surface must not rise above its limit anywhere round the wall."""

from __future__ import annotations

from nospill.laws.constraints.base import Budget, Cone, Constraint, EvaluationPoint, ObjectKey, Role, open_names
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene


class SloshHeight(Constraint):
    """Crest above the rest level <= max_slosh_height, which the reader keeps at or below the freeboard."""

    name = "slosh height"
    unit = "m"
    role = Role.LIQUID
    evaluated_at = EvaluationPoint.OBJECT
    in_words = "liquid of {subject}"
    description = "Highest point of the liquid's surface at the wall above its rest level."
    backoff = 1.5e-3
    restart_backoff = 2.3e-3
    judge_resolution = 2e-4
    integration_error = 2e-7
    limit_key = ObjectKey("max_slosh_height")

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every object with liquid and no lid."""
        return open_names(scene)

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One cone for a circular wall, two bands for a box, a band for every place of the wall of one that turns."""
        return tuple(
            tuple(
                Cone(demand, item.numbers.max_slosh_height, item.numbers.max_slosh_height)
                for demand in item.wall_vectors
            )
            for item in sample.objects
            if item.structure.open
        )
