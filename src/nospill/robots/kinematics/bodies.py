"""The bodies between the moving joints of a chain: frames, and mass properties of everything a joint carries rigidly.

The frame of joint i is fixed to what it carries, with its origin on the axis and the axis along z; at zero it is turned
against the joint's frame in the URDF by the rotation that lays z on the axis.

A joint that mimics another one has a body too: its angle is a q + b with the angle q of the joint that it follows. With
C (bodies, joints) the matrix of the factors a, the bodies turn by C q + b, a Jacobian of the joints is that of the
bodies times C, and by virtual work the torques of the joints are C^T times those of the bodies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nospill.core.arrays import parallel_axis
from nospill.robots.description.urdf_tree import UrdfJoint, UrdfTree, rotation_of


@dataclass(frozen=True, slots=True)
class Body:
    """What one moving joint carries up to the next one.

    Attributes:
        position: (3,) origin of the joint's frame at zero in the frame before it (first: the base), m.
        rotation: (3, 3) axes of the same.
        mass: kg.
        first_moment: (3,) mass times centre of mass, kg m, in the joint's frame.
        inertia: (3, 3) about the frame's origin, kg m^2, in the joint's frame.
        joint: index in q of the joint that turns it: its own, or the one that its own follows.
        factor: its angle per angle of that joint.
        offset: its angle where that joint is at zero, rad.
    """

    position: np.ndarray
    rotation: np.ndarray
    mass: float
    first_moment: np.ndarray
    inertia: np.ndarray
    joint: int
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class BodyChain:
    """Bodies from base to tip, and the flange (3,), m, (3, 3) in the last joint's frame."""

    bodies: tuple[Body, ...]
    flange_position: np.ndarray
    flange_rotation: np.ndarray

    @property
    def coupled(self) -> bool:
        """Whether a joint follows another one."""
        return any(body.joint != index for index, body in enumerate(self.bodies))

    @property
    def factors(self) -> np.ndarray:
        """(bodies, joints) turn of every body per angle of every joint."""
        matrix = np.zeros((len(self.bodies), 1 + max(body.joint for body in self.bodies)))
        for index, body in enumerate(self.bodies):
            matrix[index, body.joint] = body.factor
        return matrix

    def angles(self, q: np.ndarray) -> np.ndarray:
        """Angles (m, bodies) of the bodies at joint positions (m, n), rad."""
        return self.rates(q) + [body.offset for body in self.bodies] if self.coupled else q

    def rates(self, qd: np.ndarray) -> np.ndarray:
        """Rates (m, bodies) of the bodies at joint speeds (m, n), rad/s; likewise accelerations."""
        return qd @ self.factors.T if self.coupled else qd


def chain_bodies(tree: UrdfTree, joints: Sequence[str], tip: str) -> BodyChain:
    """Lump every link of a description into the bodies of a chain.

    Joints that are neither named nor follow one that is stay at zero.

    Args:
        tree: the description.
        joints: moving joints, base to tip.
        tip: the flange link.
    """
    children, way = tree.joints_on(), tree.way_to(tip)

    bodies: list[Body] = []
    position, rotation = np.zeros(3), np.eye(3)
    moving = [joint for joint in way if turned_by(joint, joints) is not None]
    pending = iter(way)
    for joint in moving:
        for step in pending:
            position, rotation = position + rotation @ np.array(step.position), rotation @ rotation_of(step.rpy)
            if step is joint:
                break
        lay = z_to(joint.axis)
        mass, moment, inertia = carried(tree, children, joint.child, {other.name for other in moving})
        index, factor, offset = _law(joint, joints)
        own = lay.T @ moment, lay.T @ inertia @ lay
        bodies.append(Body(position, rotation @ lay, mass, *own, joint=index, factor=factor, offset=offset))
        position, rotation = np.zeros(3), lay.T
    for step in pending:
        position, rotation = position + rotation @ np.array(step.position), rotation @ rotation_of(step.rpy)
    return BodyChain(tuple(bodies), position, rotation)


def turned_by(joint: UrdfJoint, joints: Sequence[str]) -> str | None:
    """Which of some joints turns one: itself, or the one that it follows; None where none of them does."""
    if joint.name in joints:
        return joint.name
    return joint.mimic.joint if joint.mimic is not None and joint.mimic.joint in joints else None


def _law(joint: UrdfJoint, joints: Sequence[str]) -> tuple[int, float, float]:
    if joint.mimic is None or joint.name in joints:
        return list(joints).index(joint.name), 1.0, 0.0
    return list(joints).index(joint.mimic.joint), joint.mimic.multiplier, joint.mimic.offset


def z_to(axis: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return a rotation (3, 3) that turns z onto an axis of any length, a permutation for one along x, y or z."""
    direction = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    # the coordinate axis that is farthest from it makes a well-conditioned cross product
    other = np.eye(3)[int(np.argmin(np.abs(direction)))]
    first = np.cross(other, direction)
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(direction, first), direction]) + 0.0


def carried(
    tree: UrdfTree, children: dict[str, list[UrdfJoint]], link: str, moving: set[str]
) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, first moment (3,) and inertia (3, 3) about the link's origin of all it carries without a moving joint."""
    mass, moment, inertia = 0.0, np.zeros(3), np.zeros((3, 3))
    waiting = [(link, np.zeros(3), np.eye(3))]
    while waiting:
        name, position, rotation = waiting.pop()
        own = tree.links[name]
        if own is not None and own.mass > 0.0:
            centre = position + rotation @ np.array(own.centre)
            mass += own.mass
            moment = moment + own.mass * centre
            inertia = inertia + rotation @ own.inertia() @ rotation.T + own.mass * parallel_axis(centre)
        for joint in children.get(name, []):
            if joint.name not in moving:
                place = position + rotation @ np.array(joint.position)
                waiting.append((joint.child, place, rotation @ rotation_of(joint.rpy)))
    return mass, moment, inertia
