"""Speed and acceleration of the tray's centre stay below their limits, where there are any."""

from __future__ import annotations

from nospill.laws.constraints.base import Budget, Cone, Constraint, EvaluationPoint, MotionKey, Role
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene


class TraySpeed(Constraint):
    """|p'| <= max_speed, for the tray's centre p in base axes."""

    name = "tray speed"
    unit = "m/s"
    role = Role.TRAY
    evaluated_at = EvaluationPoint.TRAY
    in_words = "speed of the tray"
    description = "Speed of the tray's centre, where it is limited."
    limit_key = MotionKey("max_speed", "speed", largest=100.0)

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """The tray, where its speed is limited."""
        return () if scene.motion.max_speed is None else ("tray",)

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One cone."""
        if "max_speed" not in sample.structure.motion_limits:
            return ()
        assert sample.tray_velocity is not None
        limit = sample.numbers.max_tray_speed
        return ((Cone(sample.tray_velocity, limit, limit),),)


class TrayAcceleration(Constraint):
    """|p''| <= max_acceleration, gravity not counted."""

    name = "tray acceleration"
    unit = "m/s^2"
    role = Role.TRAY
    evaluated_at = EvaluationPoint.TRAY
    in_words = "acceleration of the tray"
    description = "Acceleration of the tray's centre without gravity, where it is limited."
    backoff = 8e-3
    judge_resolution = 1.5e-3
    limit_key = MotionKey("max_acceleration", "acceleration", largest=1000.0)

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """The tray, where its acceleration is limited."""
        return () if scene.motion.max_acceleration is None else ("tray",)

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One cone."""
        if "max_acceleration" not in sample.structure.motion_limits:
            return ()
        assert sample.tray_acceleration is not None
        limit = sample.numbers.max_tray_acceleration
        return ((Cone(sample.tray_acceleration, limit, limit),),)
