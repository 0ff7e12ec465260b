"""Bodies keep apart: arm, tray and cargo from obstacles, and from each other."""

from __future__ import annotations

from nospill.laws.constraints.base import Budget, Constraint, EvaluationPoint, Role
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene


class Clearance(Constraint):
    """distance >= clearance, for every pair of bodies.

    The judge finds the distances of bodies itself (`judge.clearance`). The optimiser has no row of it: along a given
    path a level tray leaves an arm of six joints no choice but that of its branch, which is made before.
    """

    name = "clearance"
    unit = "m"
    role = Role.CLEARANCE
    evaluated_at = EvaluationPoint.JOINT
    in_words = "clearance of {subject}"
    description = "Distance of two bodies above its limit at all times: the obstacle's `clearance`, or contact."
    least_size = 0.1  # m; a pair farther apart than this is of no concern

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """None in the optimiser."""
        return ()

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """None in the optimiser."""
        return ()
