"""Tip: the pressing force must act inside the footprint less its reserve."""

from __future__ import annotations

import casadi as ca

from nospill.laws.constraints.base import (
    Budget,
    Cone,
    Constraint,
    EvaluationPoint,
    ObjectKey,
    Role,
    loose,
    loose_names,
)
from nospill.laws.sample import ObjectSample, Sample
from nospill.scene.scene import Scene


class Tip(Constraint):
    """Centre of pressure (-M_y, M_x)/N inside the footprint, each length of it less `footprint_reserve`.

    The walls of a carrier take the horizontal force of what stands in it, at any height up to their own, but no moment:
    they may be loose. So the moment counts about the height `held_at` [statics]: M - held_at e_z x f.

    With the deliverable wrench M = h_G e_z x f, so this is |f_T| <= (R/h_G) N for a disc [D3].
    """

    name = "tip"
    unit = "1"
    role = Role.CONTACT
    evaluated_at = EvaluationPoint.OBJECT
    relative = True
    description = (
        "Distance of the centre of pressure from the middle of the footprint, as a fraction of the footprint less its "
        "reserve."
    )
    backoff = 4e-3
    restart_backoff = 6e-3
    judge_resolution = 1e-3
    limit_key = ObjectKey("centre_of_mass")

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every object that is not fixed."""
        return loose_names(scene)

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One cone for a disc, one band per side for a rectangle."""
        return tuple(_budgets(item) for item in loose(sample))


def _budgets(item: ObjectSample) -> tuple[Budget, ...]:
    force, moment, held_at = item.wrench.force, item.wrench.moment, item.numbers.held_at
    pressing = force[2]
    weight, half = item.numbers.weight, (1.0 - item.numbers.footprint_reserve) * item.numbers.half_lengths
    offset = ca.vertcat(held_at * force[0] - moment[1], held_at * force[1] + moment[0])
    bounds = item.structure.footprint.bounds(offset, half)
    return tuple(Cone(vector, bound * pressing, bound * weight) for vector, bound in bounds)
