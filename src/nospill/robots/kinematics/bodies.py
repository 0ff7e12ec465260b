"""The bodies between the moving joints of a chain: frames, and mass properties of everything a joint carries rigidly.

The frame of joint i is fixed to what it carries, with its origin on the axis and the axis along z; at zero it is turned
against the joint's frame in the URDF by the rotation that lays z on the axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nospill.core.arrays import parallel_axis
from nospill.robots.description.urdf_tree import Inertial, UrdfJoint, UrdfTree, rotation_of

_LIGHTEST = 1e-6  # kg
_FLATTEST = 1e-9  # kg m^2


@dataclass(frozen=True, slots=True)
class Body:
    """What one moving joint carries up to the next one.

    Attributes:
        position: (3,) origin of the joint's frame at zero in the frame before it (first: the base), m.
        rotation: (3, 3) axes of the same.
        mass: kg.
        first_moment: (3,) mass times centre of mass, kg m, in the joint's frame.
        inertia: (3, 3) about the frame's origin, kg m^2, in the joint's frame.
    """

    position: np.ndarray
    rotation: np.ndarray
    mass: float
    first_moment: np.ndarray
    inertia: np.ndarray


@dataclass(frozen=True, slots=True)
class BodyChain:
    """Bodies from base to tip, and the flange (3,), m, (3, 3) in the last joint's frame."""

    bodies: tuple[Body, ...]
    flange_position: np.ndarray
    flange_rotation: np.ndarray


def chain_bodies(tree: UrdfTree, joints: Sequence[str], tip: str) -> BodyChain:
    """Lump every link of a description into the bodies of a chain; joints that are not named stay at zero.

    Args:
        tree: the description.
        joints: moving joints, base to tip.
        tip: the flange link.
    """
    children, way = tree.joints_on(), tree.way_to(tip)

    bodies: list[Body] = []
    position, rotation = np.zeros(3), np.eye(3)
    moving = [joint for joint in way if joint.name in set(joints)]
    pending = iter(way)
    for joint in moving:
        for step in pending:
            position, rotation = position + rotation @ np.array(step.position), rotation @ rotation_of(step.rpy)
            if step is joint:
                break
        lay = z_to(joint.axis)
        mass, moment, inertia = _carried(tree, children, joint.child, {other.name for other in moving})
        bodies.append(Body(position, rotation @ lay, mass, lay.T @ moment, lay.T @ inertia @ lay))
        position, rotation = np.zeros(3), lay.T
    for step in pending:
        position, rotation = position + rotation @ np.array(step.position), rotation @ rotation_of(step.rpy)
    return BodyChain(tuple(bodies), position, rotation)


def inertia_fault(tree: UrdfTree, joints: Sequence[str]) -> str | None:
    """Return why the masses and inertias of the links cannot be real, or None if nothing speaks against them.

    Args:
        tree: the description.
        joints: its moving joints, base to tip.
    """
    children = tree.joints_on()
    stated: list[Inertial] = []
    for joint in tree.joints:
        if joint.name not in joints:
            continue
        own = tree.links[joint.child]
        mass, _, inertia = _carried(tree, children, joint.child, set(joints))
        if mass < _LIGHTEST:
            return f"link {joint.child!r} has no mass"
        if np.linalg.eigvalsh(inertia)[0] < _FLATTEST or (
            own is not None and own.mass >= _LIGHTEST and np.linalg.eigvalsh(own.inertia())[0] <= 0.0
        ):
            return f"the inertia of link {joint.child!r} is not positive definite"
        if own is not None:
            stated.append(own)
    kinds = {(own.mass, own.tensor) for own in stated}
    if len(stated) > 1 and len(kinds) == 1:
        return "all links have the same mass and inertia, which are placeholders"
    if stated and all(own.tensor == (1.0, 0.0, 0.0, 1.0, 0.0, 1.0) for own in stated):
        return "all links have the unit inertia, which is a placeholder"
    return None


def z_to(axis: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return a rotation (3, 3) that turns z onto an axis of any length, a permutation for one along x, y or z."""
    direction = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    # the coordinate axis that is farthest from it makes a well-conditioned cross product
    other = np.eye(3)[int(np.argmin(np.abs(direction)))]
    first = np.cross(other, direction)
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(direction, first), direction]) + 0.0


def _carried(
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
