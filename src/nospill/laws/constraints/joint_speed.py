"""Joint speeds stay below their limits."""

from __future__ import annotations

import casadi as ca

from nospill.core.frames import SX
from nospill.laws.constraints.base import Budget, Constraint, EvaluationPoint, JointKey, Range, Role, Stop
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene

_STANDING = 1e-3
"""rad/s; a joint may be this fast anywhere: what counts as rest at the ends of a motion."""


class JointSpeed(Constraint):
    """|qd| <= max_speed, and where the arm has limits of braking, those near the ends of the ranges.

    Up: qd <= sqrt(2 deceleration (upper - q)) - offset, down likewise [Franka Control Interface documentation, Limits
    for Franka Research 3]. Where a controller takes the limit at the place that the joint reaches in a period T, q is
    q + T qd: of differences (q1 - q0)/T that is q1.
    """

    name = "joint speed"
    unit = "rad/s"
    role = Role.JOINT
    evaluated_at = EvaluationPoint.JOINT
    in_words = "speed of {subject}"
    description = "Joint speed inside the robot's limits, which may fall towards the ends of the joint's range."
    limit_key = JointKey("speed", "max_speed", "angular_speed")

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every joint."""
        return scene.robot.joints

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One range, or one way to stop, per joint."""
        qd, limit = sample.joint_speed, sample.numbers.max_speed
        assert qd is not None
        joints = range(qd.numel())
        if not sample.structure.braking:
            return tuple((Range(qd[i], -limit[i], limit[i], limit[i]),) for i in joints)
        below, above = _squares(sample)
        offset = sample.numbers.braking.offset
        return tuple((Stop(qd[i], limit[i], below[i], above[i], offset[i]),) for i in joints)


def _squares(sample: Sample) -> tuple[SX, SX]:
    """Squares (n, 1) of the speeds, offset included, from which each joint stops before its lower and upper end."""
    q, qd, braking = sample.joint_position, sample.joint_speed, sample.numbers.braking
    assert q is not None and qd is not None
    least = (braking.offset + _STANDING) ** 2
    reached = q + braking.ahead * qd
    ways = (reached - braking.lower, braking.upper - reached)
    below, above = (ca.fmax(2 * braking.deceleration * way, least) for way in ways)
    return below, above
