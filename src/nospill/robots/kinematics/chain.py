"""A serial chain as small expressions: pose, twist and its derivative by the recursion from joint to joint.

With w, z, p the angular velocity, axis and origin of a joint in base axes and r the way to the next one [Siciliano et
al., Robotics, 3.1 and 7.5]:

    w' = w + z qd               v' = v + w' x r
    alpha' = alpha + z qdd + w x z qd        a' = a + alpha' x r + w' x (w' x r)

These expressions have a quarter of the operations of products of general transforms and a differentiated Jacobian, and
planning time is nearly proportional to that.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from nospill.core.frames import SX
from nospill.robots.kinematics.bodies import BodyChain

_RIGHT_ANGLE = 1e-10


@dataclass(frozen=True, slots=True)
class ChainExpressions:
    """Motion of the tool frame in base axes; (3, 1) each but `rotation` (3, 3) and `jacobian` (6, n)."""

    position: SX
    rotation: SX
    velocity: SX
    angular_velocity: SX
    acceleration: SX
    angular_acceleration: SX
    jacobian: SX


def chain_expressions(chain: BodyChain, q: SX, qd: SX, qdd: SX, *, tool: SX) -> ChainExpressions:
    """Motion of a tool frame: `tool` (12, 1) is its origin and its axes in those of the flange, as `Tool.row`."""
    q, qd, qdd = body_angles(chain, q), body_rates(chain, qd), body_rates(chain, qdd)
    position, rotation = SX.zeros(3), SX.eye(3)
    velocity = omega = acceleration = alpha = SX(3, 1)
    axes, origins = [], []

    def carry(step: SX) -> tuple[SX, SX, SX]:
        swing = ca.cross(alpha, step) + ca.cross(omega, ca.cross(omega, step))
        return position + step, velocity + ca.cross(omega, step), acceleration + swing

    for index, body in enumerate(chain.bodies):
        position, velocity, acceleration = carry(rotation @ _constant(body.position))
        rotation = rotation @ _constant(_squared(body.rotation))
        axis = rotation[:, 2]
        axes.append(axis)
        origins.append(position)
        alpha = alpha + axis * qdd[index] + ca.cross(omega, axis * qd[index])
        omega = omega + axis * qd[index]
        rotation = rotation @ about_z(q[index])
    flange = rotation @ _constant(_squared(chain.flange_rotation))
    position, velocity, acceleration = carry(rotation @ _constant(chain.flange_position) + flange @ tool[:3])
    columns = [ca.vertcat(ca.cross(axis, position - origin), axis) for axis, origin in zip(axes, origins, strict=True)]
    turned = flange @ ca.reshape(tool[3:], 3, 3).T
    jacobian = of_joints(chain, ca.horzcat(*columns))
    return ChainExpressions(position, turned, velocity, omega, acceleration, alpha, jacobian)


def with_base_at(motion: ChainExpressions, place: SX) -> ChainExpressions:
    """The same motion in axes in which the base stands at a place (4, 1) x, y, z in m and yaw in rad."""
    turn = about_z(place[3])
    jacobian = ca.vertcat(turn @ motion.jacobian[:3, :], turn @ motion.jacobian[3:, :])
    return ChainExpressions(
        position=place[:3] + turn @ motion.position,
        rotation=turn @ motion.rotation,
        velocity=turn @ motion.velocity,
        angular_velocity=turn @ motion.angular_velocity,
        acceleration=turn @ motion.acceleration,
        angular_acceleration=turn @ motion.angular_acceleration,
        jacobian=jacobian,
    )


def body_angles(chain: BodyChain, q: SX) -> SX:
    """Angles (bodies, 1) of the bodies at joint positions (n, 1), rad, as expressions."""
    return body_rates(chain, q) + ca.DM([body.offset for body in chain.bodies]) if chain.coupled else q


def body_rates(chain: BodyChain, qd: SX) -> SX:
    """Rates (bodies, 1) of the bodies at joint speeds (n, 1), rad/s, as expressions; likewise accelerations."""
    return ca.vertcat(*[body.factor * qd[body.joint] for body in chain.bodies]) if chain.coupled else qd


def of_joints(chain: BodyChain, of_bodies: SX) -> SX:
    """What belongs to bodies, a column each (a Jacobian, torques as one row), as what belongs to the joints."""
    return of_bodies @ _constant(chain.factors) if chain.coupled else of_bodies


def joints_between(chain: BodyChain, inner: int, outer: int) -> list[int]:
    """Indices of the joints that turn the bodies between two frames, in the order of q; numbers as `frame_in_frame`."""
    return sorted({body.joint for body in chain.bodies[inner:outer]})


def frame_in_frame(chain: BodyChain, inner: int, outer: int, q: SX) -> tuple[SX, SX]:
    """Position (3, 1), m, and axes (3, 3) of one joint's frame (as in `bodies`) in the frame of another one before it.

    Args:
        chain: the arm.
        inner: number of the bodies before the other frame, 0 for the base.
        outer: of those before the frame itself.
        q: (k, 1) positions of the joints that turn what is between, rad: of `joints_between`.
    """
    place = {joint: index for index, joint in enumerate(joints_between(chain, inner, outer))}
    position, rotation = SX.zeros(3), SX.eye(3)
    for body in chain.bodies[inner:outer]:
        angle = q[place[body.joint]]
        if chain.coupled:
            angle = body.factor * angle + body.offset
        position = position + rotation @ _constant(body.position)
        rotation = rotation @ _constant(_squared(body.rotation)) @ about_z(angle)
    return position, rotation


def _squared(rotation: np.ndarray) -> np.ndarray:
    """A rotation whose entries near 0 and 1 are 0 and 1: files write right angles with a dozen digits."""
    nearest = np.round(rotation)
    return np.where(np.abs(rotation - nearest) < _RIGHT_ANGLE, nearest, rotation)


def _constant(values: np.ndarray) -> SX:
    # sparse, so that zeros make no nodes
    return ca.sparsify(SX(ca.DM(values)))


def about_z(angle: SX) -> SX:
    """Rotation (3, 3) by an angle, rad, about z."""
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.sparsify(ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1)))
