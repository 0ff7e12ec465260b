"""Joint positions stay inside their limits."""

from __future__ import annotations

import math

import numpy as np

from nospill.laws.constraints.base import Budget, Constraint, EvaluationPoint, Range, Role, RowId
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene


class JointPosition(Constraint):
    """lower <= q <= upper."""

    name = "joint position"
    unit = "rad"
    role = Role.JOINT
    evaluated_at = EvaluationPoint.JOINT
    in_words = "range of {subject}"
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


def range_backoff(scene: Scene, q: np.ndarray) -> dict[RowId, float]:
    """First back-off of joint ranges, which leaves no less than the path needs where it gives the joints.

    That is on all of it for a level tray, at its ends for one that tilts.

    Args:
        scene: the task.
        q: (m, n) rad, joint positions along the path.
    """
    robot = scene.robot
    given = q if scene.motion.is_given else q[[0, -1]]
    nearest = np.min(np.minimum(given - robot.lower, robot.upper - given), axis=0)
    shares = np.minimum(np.maximum(nearest, 0.0) / (robot.upper - robot.lower), JointPosition.backoff)
    return {RowId(JointPosition.name, joint): float(share) for joint, share in zip(robot.joints, shares, strict=True)}
