"""A serial chain as small expressions: pose, twist and its derivative by the recursion from link to link.

Every constant rotation of the chain is made once, joint axes become z axes by it, and what is a right angle up to
rounding is taken as one, so that its zeros and ones vanish from the expressions. With w, z, p the angular velocity,
axis and origin of a joint in base axes and r the way to the next one [Siciliano et al., Robotics, 3.1 and 7.5]:

    w' = w + z qd               v' = v + w' x r
    alpha' = alpha + z qdd + w x z qd        a' = a + alpha' x r + w' x (w' x r)

These expressions have a third of the operations of products of general transforms and a differentiated Jacobian;
planning time is nearly proportional to that.
"""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree.ElementTree import Element

import casadi as ca
import numpy as np

from nospill.errors import ScenarioError
from nospill.frames import SX

_RIGHT_ANGLE = 1e-10
"""Entries of constant rotations this close to 0 or 1 become 0 or 1; files write right angles with a dozen digits."""


@dataclass(frozen=True, slots=True)
class Link:
    """From one joint's frame, after its turn, to the next one's, whose axis is z: (3,) m and rotation (3, 3)."""

    translation: np.ndarray
    rotation: np.ndarray


@dataclass(frozen=True, slots=True)
class ChainExpressions:
    """Motion of the last frame in base axes; (3, 1) each but `rotation` (3, 3) and `jacobian` (6, n)."""

    position: SX
    rotation: SX
    velocity: SX
    angular_velocity: SX
    acceleration: SX
    angular_acceleration: SX
    jacobian: SX


def links(tree: Element, joints: tuple[str, ...], tip: str) -> tuple[Link, ...]:
    """The links of a chain from the root of a URDF to the tip: one before each joint in `joints`, and the last.

    Other joints on the way stay at zero.

    Raises:
        ScenarioError: the tip is not in the URDF, or the joints are not those of the chain in their order.
    """
    by_child = {_name(joint, "child"): joint for joint in tree.findall("joint")}
    names = {link.get("name") for link in tree.findall("link")}
    if tip not in names:
        known = ", ".join(sorted(str(name) for name in names)[:12])
        raise ScenarioError(f"robot description cannot be used (tip {tip!r}): no such link; there are {known}")
    way: list[Element] = []
    frame = tip
    while frame in by_child:
        way.append(by_child[frame])
        frame = _name(way[-1], "parent")
        if len(way) > len(by_child):
            raise ScenarioError(f"robot description cannot be used: the joints to {tip!r} form a loop")
    found, translation, rotation = [], np.zeros(3), np.eye(3)
    moving = []
    for joint in reversed(way):
        xyz, rpy = _origin(joint)
        translation = translation + rotation @ xyz
        rotation = rotation @ _fixed_axes(rpy)
        if joint.get("name") not in joints:
            continue
        moving.append(str(joint.get("name")))
        to_axis = _to_z(_axis(joint))
        found.append(Link(translation, _exact(rotation @ to_axis)))
        # the turn is C Rz(q) C^T: C^T belongs to the way to the next joint
        translation, rotation = np.zeros(3), to_axis.T
    if tuple(moving) != joints:
        raise ScenarioError(
            f"robot description cannot be used: the way to {tip!r} has the joints {', '.join(moving) or 'none'}, "
            f"not {', '.join(joints)}"
        )
    return (*found, Link(translation, _exact(rotation)))


def chain_expressions(
    chain: tuple[Link, ...], q: SX, qd: SX, qdd: SX, *, tool_position: SX, tool_yaw: SX
) -> ChainExpressions:
    """Motion of a tool frame: origin at `tool_position` in flange axes, turned by `tool_yaw` about the flange's z."""
    zero = SX.zeros(3)
    position, rotation = zero, SX.eye(3)
    velocity = omega = acceleration = alpha = zero
    axes, origins = [], []
    for index, link in enumerate(chain):
        last = index == len(chain) - 1
        step = rotation @ ca.sparsify(SX(ca.DM(link.translation)))
        rotation = rotation @ ca.sparsify(ca.DM(link.rotation))
        if last:
            step = step + rotation @ tool_position
        position = position + step
        velocity = velocity + ca.cross(omega, step)
        acceleration = acceleration + ca.cross(alpha, step) + ca.cross(omega, ca.cross(omega, step))
        if last:
            continue
        axis = rotation[:, 2]
        axes.append(axis)
        origins.append(position)
        alpha = alpha + axis * qdd[index] + ca.cross(omega, axis * qd[index])
        omega = omega + axis * qd[index]
        rotation = rotation @ _about_z(q[index])
    rotation = rotation @ _about_z(tool_yaw)
    columns = [ca.vertcat(ca.cross(axis, position - origin), axis) for axis, origin in zip(axes, origins, strict=True)]
    return ChainExpressions(position, rotation, velocity, omega, acceleration, alpha, ca.horzcat(*columns))


def _about_z(angle: SX) -> SX:
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.sparsify(ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1)))


def _fixed_axes(rpy: np.ndarray) -> np.ndarray:
    """Rotation (3, 3) about the fixed axes x, y, z by roll, pitch, yaw, as a URDF has it: Rz Ry Rx."""
    (a, b, c), (d, e, f) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [c * b, c * e * d - f * a, c * e * a + f * d],
            [f * b, f * e * d + c * a, f * e * a - c * d],
            [-e, b * d, b * a],
        ]
    )


def _to_z(axis: np.ndarray) -> np.ndarray:
    """A rotation whose z column is the axis; the others are chosen to have many zeros."""
    z = axis / np.linalg.norm(axis)
    other = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(other, z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def _exact(rotation: np.ndarray) -> np.ndarray:
    nearest = np.round(rotation)
    return np.where(np.abs(rotation - nearest) < _RIGHT_ANGLE, nearest, rotation)


def _name(joint: Element, tag: str) -> str:
    found = joint.find(tag)
    return "" if found is None else str(found.get("link"))


def _origin(joint: Element) -> tuple[np.ndarray, np.ndarray]:
    found = joint.find("origin")
    if found is None:
        return np.zeros(3), np.zeros(3)
    return _numbers(found.get("xyz", "0 0 0")), _numbers(found.get("rpy", "0 0 0"))


def _axis(joint: Element) -> np.ndarray:
    found = joint.find("axis")
    return np.array([1.0, 0.0, 0.0]) if found is None else _numbers(found.get("xyz", "1 0 0"))


def _numbers(text: str) -> np.ndarray:
    try:
        values = np.array([float(word) for word in text.split()])
    except ValueError:
        values = np.zeros(0)
    if values.shape != (3,) or not np.isfinite(values).all():
        raise ScenarioError(f"robot description cannot be used: {text!r} are not three numbers")
    return values
