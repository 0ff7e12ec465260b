"""Jerk of the path parameter and of its free deviations, the smoothness the planner may use."""

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


class OffsetJerk(Constraint):
    """|d'''| <= offset_jerk_limit, for the offset d from the path along each axis of the base."""

    name = "offset jerk"
    unit = "m/s^3"
    role = Role.TRAY
    evaluated_at = EvaluationPoint.CONTROL
    in_words = "jerk of the offset from the path along {subject}"
    description = "Third time derivative of the tray's offset from its path, along each axis of the base."

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """The axes, where the tray may leave its path."""
        return ("x", "y", "z") if scene.motion.corridor is not None else ()

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One range per axis."""
        freedom, limit = sample.structure.freedom, sample.numbers.offset_jerk_limit
        if not freedom.offset:
            return ()
        assert sample.jerks is not None
        return tuple((Range(sample.jerks[index], -limit, limit, limit),) for index in freedom.offset_chains)


class YawJerk(Constraint):
    """|yaw'''| <= tilt_jerk_limit, for the yaw relative to the path's."""

    name = "yaw jerk"
    unit = "rad/s^3"
    role = Role.TRAY
    evaluated_at = EvaluationPoint.CONTROL
    in_words = "yaw jerk"
    description = "Third time derivative of the tray's yaw relative to the path's, where it is free."
    limit_key = MotionKey("tilt_jerk_limit", "angular_jerk", largest=1e6)

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """The yaw, where free."""
        return ("yaw",) if scene.motion.yaw_free else ()

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One range."""
        freedom, limit = sample.structure.freedom, sample.numbers.tilt_jerk_limit
        if not freedom.yaw:
            return ()
        assert sample.jerks is not None
        return tuple((Range(sample.jerks[index], -limit, limit, limit),) for index in freedom.turn_chains)
