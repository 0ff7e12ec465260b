"""Apparent gravity: it must press the liquid into its cup, or the slosh model says nothing."""

from __future__ import annotations

import casadi as ca

from nospill.core.frames import SX
from nospill.laws.constraints.base import Budget, Constraint, EvaluationPoint, Range, Role, liquid_names
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene

LEAST_APPARENT_GRAVITY = 0.3
"""Of gravity. The surface's restoring force is proportional to it, and the quasi-static height to its inverse: near
weightlessness small lateral accelerations throw the liquid out, which no linear free surface describes."""


class ApparentGravity(Constraint):
    """a_z at the resting surface, along the cup's axis, >= 0.3 g at full fidelity.

    a is the specific force R^T (p'' + g e_z) with the Euler and centrifugal terms of the surface's middle.
    """

    name = "apparent gravity"
    unit = "gravity"
    role = Role.LIQUID
    evaluated_at = EvaluationPoint.OBJECT
    description = "Apparent gravity along the cup's axis, as a multiple of gravity; below 0.3 the liquid model is void."
    judge_resolution = 2e-4
    least_size = 1.0

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every object with liquid, at full fidelity."""
        return liquid_names(scene) if scene.fidelity == "full" else ()

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One range per liquid."""
        if sample.structure.fidelity != "full":
            return ()
        budgets = []
        for item in sample.objects:
            if item.structure.liquid:
                added, gravity = SX(item.numbers.added_gravity), sample.numbers.gravity
                gravity = gravity + added if added.numel() else gravity
                surface = item.motion.at(ca.vertcat(0, 0, item.numbers.liquid_height)).specific_force
                budgets.append((Range(surface[2] / gravity, SX(LEAST_APPARENT_GRAVITY), None, SX(1)),))
        return tuple(budgets)
