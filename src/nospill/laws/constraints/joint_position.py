"""Joint positions stay inside their limits."""

from __future__ import annotations

import math

from nospill.laws.constraints.base import Budget, Constraint, EvaluationPoint, Range, Role
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene


class JointPosition(Constraint):
    """lower <= q <= upper."""

    name = "joint position"
    unit = "rad"
    role = Role.JOINT
    evaluated_at = EvaluationPoint.JOINT
    description = "Joint angle inside the robot's limits."
    least_size = math.pi  # half a turn: a joint's zero may lie anywhere in its range

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every joint."""
        return scene.robot.joints

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One range per joint."""
        numbers, q = sample.numbers, sample.joint_position
        assert q is not None
        lower, upper = numbers.joint_lower, numbers.joint_upper
        return tuple((Range(q[i], lower[i], upper[i], upper[i] - lower[i]),) for i in range(q.numel()))
