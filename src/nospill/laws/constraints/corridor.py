"""The tray's centre stays inside the corridor about its path."""

from __future__ import annotations

from nospill.laws.constraints.base import Budget, Cone, Constraint, EvaluationPoint, MotionKey, Role
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene


class Corridor(Constraint):
    """|p - r(s)| <= corridor: so the distance from the path, which is no more, is within it too."""

    name = "corridor"
    unit = "m"
    role = Role.TRAY
    evaluated_at = EvaluationPoint.JOINT
    in_words = "corridor"
    description = "Distance of the tray's centre from its path, where it may leave it."
    limit_key = MotionKey("corridor", "length", largest=2.0, table="path")

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """The tray, where it may leave its path."""
        return ("tray",) if scene.motion.corridor is not None else ()

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One cone."""
        if not sample.structure.offset_free:
            return ()
        assert sample.offset is not None
        width = sample.numbers.corridor
        return ((Cone(sample.offset, width, width),),)
