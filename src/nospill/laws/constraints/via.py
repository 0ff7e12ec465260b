"""The tray's centre passes the places on its way."""

from __future__ import annotations

import casadi as ca

from nospill.core.frames import SX
from nospill.laws.constraints.base import Budget, Cone, Constraint, EvaluationPoint, Role
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene

_WIDENING = 2.0
"""Growth of the funnel over the way along the path. With 2 no motion that passes the place is shut out: where it is at
the distance d from the place, s may be where the path is as far from it, so that the offset is at most 2 d."""
_FLAT = 0.05
"""Part of the path around the place up to which the funnel grows more slowly, so that the nodes next to it count."""


class PassedPlace(Constraint):
    """|p - r(s)|^2 <= radius^2 + (2 l u)^2 u^2 / (u^2 + 0.05^2), u = s - s_k: a funnel about the path's place s_k.

    l is the length of the path. The path passes the place itself, or nearly; at s = s_k the tray is therefore within
    the radius. What is certified is the least distance from the place as the joints carry the tray (`judge.traces`).
    """

    name = "via"
    unit = "m"
    role = Role.TRAY
    evaluated_at = EvaluationPoint.PASSING
    in_words = "place {subject} on the way"
    description = "Least distance of the tray's centre from each place that it has to pass."

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """The places, by their names."""
        return tuple(item.name for item in scene.motion.via)

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One cone for each place."""
        if not sample.structure.vias:
            return ()
        assert sample.offset is not None and sample.path_parameter is not None
        budgets, numbers = list[tuple[Budget, ...]](), sample.numbers.via
        for index in range(sample.structure.vias):
            beyond, radius = (sample.path_parameter - numbers.parameter[index]) ** 2, numbers.radius[index]
            widened = (_WIDENING * numbers.way[index] * beyond) ** 2 / (beyond + _FLAT**2)
            # over its own capacity, which is a hundred times the radius far from the place
            budgets.append((Cone(sample.offset / ca.sqrt(radius**2 + widened), SX(1), SX(1)),))
        return tuple(budgets)
