"""Joint jerks stay below their limits, where there are any."""

from __future__ import annotations

from nospill.laws.constraints.base import Budget, Constraint, EvaluationPoint, JointKey, Range, Role, RowId
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


def command_backoff(scene: Scene) -> dict[RowId, float]:
    """First back-off of the jerks of joints that lag, whose command has lag times the jump of a jerk in one period.

    A jump is as large as the jerk itself from rest, and twice that at most.
    """
    controller, robot = scene.controller, scene.robot
    if controller is None or not controller.compensate or robot.max_jerk is None:
        return {}
    rate = scene.output_rate if controller.interface is None else controller.update_rate
    shares = 1.0 - (1.0 - JointJerk.backoff) / (1.0 + controller.lag * rate)
    return {RowId(JointJerk.name, joint): float(share) for joint, share in zip(robot.joints, shares, strict=True)}
