"""Jerk of the path parameter and of the tilt angles, the smoothness the planner may use."""

from __future__ import annotations

from nospill.laws.constraints.base import Budget, Constraint, EvaluationPoint, MotionKey, Range, Role
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene


class PathJerk(Constraint):
    """|s'''| <= path_jerk_limit [D3, Eq. 6]."""

    name = "path jerk"
    unit = "1/s^3"
    role = Role.TRAY
    evaluated_at = EvaluationPoint.CONTROL
    in_words = "path jerk"
    description = "Third time derivative of the path parameter."
    limit_key = MotionKey("path_jerk_limit", "path_jerk", largest=1e6)

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """The path."""
        return ("path",)

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One range."""
        assert sample.jerks is not None
        limit = sample.numbers.path_jerk_limit
        return ((Range(sample.jerks[0], -limit, limit, limit),),)


class TiltJerk(Constraint):
    """|theta_x'''|, |theta_y'''| <= tilt_jerk_limit [D3, Eq. 11]."""

    name = "tilt jerk"
    unit = "rad/s^3"
    role = Role.TRAY
    evaluated_at = EvaluationPoint.CONTROL
    in_words = "tilt jerk {subject}"
    description = "Third time derivative of each tilt angle."
    limit_key = MotionKey("tilt_jerk_limit", "angular_jerk", largest=1e6)

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Both tilt angles, where free."""
        return ("theta_x", "theta_y") if scene.motion.tilt_free else ()

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One range per angle."""
        if not sample.structure.tilt_free:
            return ()
        assert sample.jerks is not None
        limit = sample.numbers.tilt_jerk_limit
        return tuple((Range(sample.jerks[1 + i], -limit, limit, limit),) for i in range(2))
