"""Joint jerks stay below their limits, where there are any."""

from __future__ import annotations

from nospill.laws.constraints.base import Budget, Constraint, EvaluationPoint, JointKey, Range, Role
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene


class JointJerk(Constraint):
    """|qddd| <= max_jerk; the judge takes third differences of the samples, as a controller does."""

    name = "joint jerk"
    unit = "rad/s^3"
    role = Role.JOINT
    evaluated_at = EvaluationPoint.CONTROL
    in_words = "jerk of {subject}"
    description = "Third difference of the joint samples inside the robot's limits, where they are set."
    limit_key = JointKey("jerk", "max_jerk", "angular_jerk")

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every joint, where the robot's jerks are limited."""
        return () if scene.robot.max_jerk is None else scene.robot.joints

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One range per joint."""
        if "jerk" not in sample.structure.joint_limits:
            return ()
        jerk, limit = sample.joint_jerk, sample.numbers.max_jerk
        assert jerk is not None
        return tuple((Range(jerk[i], -limit[i], limit[i], limit[i]),) for i in range(jerk.numel()))
