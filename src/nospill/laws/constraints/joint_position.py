"""Joint positions stay inside their limits."""

from __future__ import annotations

from nospill.laws.constraints.base import Budget, Constraint, Place, Range
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene


class JointPosition(Constraint):
    """lower <= q <= upper."""

    name = "joint position"
    unit = "rad"
    place = Place.JOINT
    description = "Joint angle inside the robot's limits."

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every joint."""
        return scene.robot.joints

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One range per joint."""
        numbers, q = sample.numbers, sample.joint_position
        assert q is not None
        lower, upper = numbers.joint_lower, numbers.joint_upper
        return tuple((Range(q[i], lower[i], upper[i], upper[i] - lower[i]),) for i in range(q.numel()))
