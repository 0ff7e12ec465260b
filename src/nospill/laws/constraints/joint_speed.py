"""Joint speeds stay below their limits."""

from __future__ import annotations

from nospill.laws.constraints.base import Budget, Constraint, EvaluationPoint, JointKey, Range, Role
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene


class JointSpeed(Constraint):
    """|qd| <= max_speed."""

    name = "joint speed"
    unit = "rad/s"
    role = Role.JOINT
    evaluated_at = EvaluationPoint.JOINT
    in_words = "speed of {subject}"
    description = "Joint speed inside the robot's limits."
    limit_key = JointKey("speed", "max_speed", "angular_speed")

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every joint."""
        return scene.robot.joints

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One range per joint."""
        qd, limit = sample.joint_speed, sample.numbers.max_speed
        assert qd is not None
        return tuple((Range(qd[i], -limit[i], limit[i], limit[i]),) for i in range(qd.numel()))
