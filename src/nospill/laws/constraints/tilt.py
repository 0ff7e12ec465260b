"""Tray tilt stays inside the freedom the scenario gives."""

from __future__ import annotations

import math

from nospill.laws.constraints.base import Budget, Constraint, EvaluationPoint, MotionKey, Range, Role
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene

TILT_ANGLES = ("theta_x", "theta_y")
"""Names of the two, as subjects of rows."""


class Tilt(Constraint):
    """|theta_x|, |theta_y| <= max_tilt where the tilt is free."""

    name = "tilt"
    unit = "rad"
    role = Role.TRAY
    evaluated_at = EvaluationPoint.CONTROL
    in_words = "tilt {subject}"
    description = "Each of the tray's two tilt angles against max_tilt."
    limit_key = MotionKey("max_tilt", "angle", largest=math.radians(59.9))

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Both tilt angles, where free."""
        return TILT_ANGLES if scene.motion.tilt_free else ()

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One range per angle."""
        if not sample.structure.tilt_free:
            return ()
        tilt, limit = sample.tilt, sample.numbers.max_tilt
        assert tilt is not None
        return tuple((Range(tilt[i], -limit, limit, limit),) for i in range(2))
