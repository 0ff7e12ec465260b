"""The tray's centre stays inside the corridor about its path."""

from __future__ import annotations

import casadi as ca

from nospill.core.frames import SX
from nospill.laws.constraints.base import Budget, Cone, Constraint, EvaluationPoint, MotionKey, Role
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene


class Corridor(Constraint):
    """|p - r(s)| <= w(s): so the tray's centre is in the ball of that radius about a point of the path.

    The width w is `corridor`; where shares of it are given at even steps of s, it goes from each to the next by
    3 u^2 - 2 u^3, which has a slope everywhere and goes beyond neither.
    """

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
        if sample.structure.corridor_steps:
            assert sample.path_parameter is not None
            width = width * share_at(sample.numbers.corridor_shares, sample.path_parameter)
        return ((Cone(sample.offset, width, width),),)


def share_at(shares: SX, s: SX) -> SX:
    """The share of the corridor's width at a path parameter, from those (k, 1) at even steps of it."""
    found, steps = shares[0], shares.numel() - 1
    for step in range(steps):
        along = ca.fmin(ca.fmax(steps * s - step, 0), 1)
        found = found + (shares[step + 1] - shares[step]) * along**2 * (3 - 2 * along)
    return found
