"""Slip: friction must hold every object in place."""

from __future__ import annotations

import casadi as ca

from nospill.constraints.base import Budget, Cone, Constraint, Place, object_names
from nospill.sample import Sample
from nospill.scene import Scene


class Slip(Constraint):
    """|f_T| <= mu N [D3]; at full fidelity sliding and twisting share the budget.

    Full: the friction a footprint under uniform pressure can give against force and moment together is taken as the
    ellipsoid |(f_x, f_y, M_z/r)| <= mu N with r the mean lever arm of friction. It is exact for pure sliding and pure
    turning; in between it promises up to 6.5 % too much for a disc and 12 % for a rectangle of sides 4:1.
    """

    name = "slip"
    unit = "1"
    place = Place.OBJECT
    relative = True
    description = (
        "Tangential contact force (at full fidelity with the yaw moment) against planned friction times pressing force."
    )

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every object."""
        return object_names(scene)

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One friction cone per object."""
        cones = []
        for item in sample.objects:
            demand = item.wrench.force[:2]
            if sample.structure.fidelity == "full":
                demand = ca.vertcat(demand, item.wrench.moment[2] / item.numbers.twist_radius)
            friction = item.numbers.friction
            cones.append((Cone(demand, friction * item.wrench.force[2], friction * item.numbers.weight),))
        return tuple(cones)
