"""Joint torques stay below their limits, where the arm's inertias are known."""

from __future__ import annotations

from nospill.laws.constraints.base import Budget, Constraint, EvaluationPoint, JointKey, Range, Role
from nospill.laws.sample import Sample
from nospill.robots.kinematics.dynamics import Load, torque_expression, torque_joints
from nospill.scene.scene import Scene


class JointTorque(Constraint):
    """|tau| <= max_torque, tau by rigid-body inverse dynamics with tray and cargo as a rigid load at the flange.

    Friction in the joints, rotor inertias and the reaction of the sloshing liquid are not in it.
    """

    name = "joint torque"
    unit = "N m"
    role = Role.JOINT
    evaluated_at = EvaluationPoint.JOINT
    in_words = "torque of {subject}"
    description = "Joint torque of the rigid arm with its load inside the limits, where inertias and limits are known."
    limit_key = JointKey("torque", "max_torque", "torque", falls_with_load=True)

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every joint whose torque is limited, where torques can be computed."""
        return tuple(scene.robot.joints[joint] for joint in torque_joints(scene.robot))

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One range per joint that has a limit."""
        if not sample.structure.torque_joints:
            return ()
        numbers, q, qd, qdd = sample.numbers, sample.joint_position, sample.joint_speed, sample.joint_acceleration
        assert q is not None and qd is not None and qdd is not None
        load = Load(numbers.load_mass, numbers.load_first_moment, numbers.load_inertia)
        torque = torque_expression(sample.structure, q, qd, qdd, load, gravity=numbers.gravity)
        limit = numbers.max_torque
        return tuple((Range(torque[i], -limit[i], limit[i], limit[i]),) for i in sample.structure.torque_joints)
