"""Slip: friction must hold every object in place."""

from __future__ import annotations

import casadi as ca

from nospill.constraints.base import Budget, Cone, Constraint, Place, object_names
from nospill.sample import Sample
from nospill.scene import Scene


class Slip(Constraint):
    """|f_T| <= mu N [D3]; at full fidelity sliding and twisting share the budget.

    Full: against force and moment together a footprint under uniform pressure is given the ellipsoid
    |(f_x, f_y, M_z/r)| <= mu N with r its radius of gyration about the weaker axis. It lies inside the exact limit
    curve, touches it at pure sliding, and gives three quarters of the moment of pure turning for a disc. The mean lever
    arm in its place (exact for pure turning) would promise up to 6.5 % too much in between, 12 % for sides of 4:1.
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
                demand = ca.vertcat(demand, item.wrench.moment[2] / item.numbers.grip_radius)
            friction = item.numbers.friction
            cones.append((Cone(demand, friction * item.wrench.force[2], friction * item.numbers.weight),))
        return tuple(cones)
