"""Joint accelerations stay below their limits, where there are any."""

from __future__ import annotations

import casadi as ca

from nospill.laws.constraints.base import Budget, Constraint, EvaluationPoint, JointKey, Range, Role
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene


class JointAcceleration(Constraint):
    """|qdd| <= max_acceleration of what the joints do; of joints that lag qdd + lag qddd too, of their command."""

    name = "joint acceleration"
    unit = "rad/s^2"
    role = Role.JOINT
    evaluated_at = EvaluationPoint.JOINT
    in_words = "acceleration of {subject}"
    description = "Joint acceleration inside the robot's limits, where they are set."
    backoff = 8e-3
    judge_resolution = 1.5e-3
    limit_key = JointKey("acceleration", "max_acceleration", "angular_acceleration")

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every joint, where the robot's accelerations are limited."""
        return () if scene.robot.max_acceleration is None else scene.robot.joints

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """Ranges of every joint."""
        if "acceleration" not in sample.structure.joint_limits:
            return ()
        qdd, limit = sample.joint_acceleration, sample.numbers.max_acceleration
        assert qdd is not None
        asked = sample.command_acceleration
        columns = qdd if asked is None else ca.horzcat(qdd, asked)
        return tuple(
            tuple(Range(columns[i, k], -limit[i], limit[i], limit[i]) for k in range(columns.size2()))
            for i in range(qdd.numel())
        )
