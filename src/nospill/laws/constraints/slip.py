"""Slip: friction must hold every object in place."""

from __future__ import annotations

import casadi as ca

from nospill.core.frames import SX
from nospill.laws.constraints.base import (
    Budget,
    Cone,
    Constraint,
    EvaluationPoint,
    ObjectKey,
    Role,
    standing,
    standing_names,
)
from nospill.laws.sample import ObjectSample, Sample
from nospill.scene.scene import Scene

_SMOOTH = 1e-3
"""Part of the object's weight below which the eccentricity of the pressure is rounded off."""
_EDGE, _ROUNDED = 0.03, 0.01
"""Parts of the footprint: nearer to its edge than the first, the lever gets no shorter; the second rounds this off. At
a distance of 5 %, the usual reserve, the lever is 5 % too long, half of what the bound gives away there."""


class Slip(Constraint):
    """|f_T| <= mu N [D3]; at full fidelity sliding and turning share the budget.

    Full: |(f_x, f_y, T/r)| <= mu N with T the moment about the centre of pressure and r = (1 - e) times the footprint's
    radius of gyration about its weaker axis (within 5 % of the edge a smooth maximum, see
    docs/physics/contact.md), e the distance of the centre of pressure from the middle as a part of the
    footprint. An object near tipping stands on a patch at its edge, about which friction has hardly a lever. Under
    pressure that is linear where it presses and nowhere negative, this lies inside the exact limit curve and touches it
    at pure sliding. In the middle it gives three quarters of the moment of pure turning for a disc. There, the mean
    lever arm in place of r (exact for pure turning) would promise up to 6.5 % too much, 12 % for sides of 4:1.
    """

    name = "slip"
    unit = "1"
    role = Role.CONTACT
    evaluated_at = EvaluationPoint.OBJECT
    in_words = "friction of {subject}"
    relative = True
    description = (
        "Tangential contact force (at full fidelity with the moment about the centre of pressure) against planned "
        "friction times pressing force."
    )
    backoff = 4.5e-3
    restart_backoff = 8e-3
    judge_resolution = 1.5e-3
    limit_key = ObjectKey("friction")

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every object that friction holds on the tray itself."""
        return standing_names(scene)

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One friction cone per object."""
        cones = []
        for item in standing(sample):
            demand = item.wrench.force[:2]
            if sample.structure.fidelity == "full":
                demand = ca.vertcat(demand, _turning(item))
            friction = item.numbers.planned_friction
            cones.append((Cone(demand, friction * item.wrench.force[2], friction * item.numbers.weight),))
        return tuple(cones)


def _turning(item: ObjectSample) -> SX:
    """T/r, N: moment about the centre of pressure, over the lever that friction has about it.

    T = M_z - c_x f_y + c_y f_x = (M . f)/N with the centre of pressure c = (-M_y, M_x)/N.
    """
    force, moment, numbers = item.wrench.force, item.wrench.moment, item.numbers
    little = _SMOOTH * numbers.weight
    offset = ca.vertcat(-moment[1], moment[0])
    off_centre = item.structure.footprint.eccentricity(offset, numbers.half_lengths, little)
    pressing = force[2] - off_centre  # N (1 - e)
    # Above zero, and in proportion to the forces, also where the object tips or lifts: solvers come through there.
    least = _EDGE * ca.sqrt(force[2] ** 2 + off_centre**2)
    pressing = 0.5 * (pressing + least + ca.sqrt((pressing - least) ** 2 + (_ROUNDED * force[2]) ** 2 + little**2))
    return ca.dot(moment, force) / (numbers.grip_radius * pressing)
