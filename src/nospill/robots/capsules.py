"""The arm as capsules: one or more a link, in the link's own frame, and where each is fixed in the chain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nospill.core.arrays import read_only
from nospill.robots.description.urdf_tree import UrdfTree, read_tree, rotation_of
from nospill.robots.kinematics.bodies import chain_bodies, turned_by, z_to
from nospill.robots.robot import LinkCapsule, Robot

CAPSULES = "capsules"
"""Key of a robot's sources under which stands where its capsules come from."""

_THICK, _THIN = 0.05, 0.03
"""Radius at the base and at the flange as a fraction of the chain's length, where nobody states any."""
ESTIMATED = (
    f"estimated: along the chain, radii from {100 * _THICK:g} % of its length at the base to {100 * _THIN:g} % at "
    "the flange; state the arm's own as [[robot.capsule]]"
)

_ESTIMATED_WORD = "estimated"


def are_estimated(robot: Robot) -> bool:
    """Whether the capsules of an arm are guessed, and made around no geometry of its links."""
    return robot.sources.get(CAPSULES, _ESTIMATED_WORD).startswith(_ESTIMATED_WORD)


@dataclass(frozen=True, slots=True)
class PlacedCapsule:
    """A capsule fixed to a moving joint's frame (as in `kinematics.bodies`).

    Attributes:
        link: that it belongs to.
        joint: number of the moving joints before it, those that follow others counted, 0 for what stands still.
        ends: (2, 3) of the segment in that joint's frame, m.
        radius: m.
    """

    link: str
    joint: int
    ends: np.ndarray
    radius: float


def placed_capsules(robot: Robot) -> tuple[PlacedCapsule, ...]:
    """The capsules of an arm, base to tip: its own, or where it has none those of its chain.

    Raises:
        ScenarioError: the URDF cannot be read.
    """
    tree = read_tree(robot.urdf)
    own = robot.capsules or chain_capsules(tree, robot.joints, robot.tip)
    places = link_places(tree, robot.joints)
    found = []
    for item in own:
        joint, position, rotation = places[item.link]
        ends = position + np.array([item.start, item.end]) @ rotation.T
        found.append(PlacedCapsule(item.link, joint, read_only(ends), item.radius))
    return tuple(sorted(found, key=lambda item: item.joint))


def link_places(tree: UrdfTree, joints: Sequence[str]) -> dict[str, tuple[int, np.ndarray, np.ndarray]]:
    """Link -> the moving joints before it, its position (3,), m, and axes (3, 3) in the frame of the last of these.

    The frames are those of `chain_bodies`; joints that are not named stay at zero. Before the first moving joint it is
    the frame of the root.
    """
    children = tree.joints_on()
    places: dict[str, tuple[int, np.ndarray, np.ndarray]] = {tree.root(): (0, np.zeros(3), np.eye(3))}
    waiting = [tree.root()]
    while waiting:
        link = waiting.pop()
        number, position, rotation = places[link]
        for joint in children.get(link, []):
            if turned_by(joint, joints) is not None:
                # all of these stand in one chain
                places[joint.child] = (number + 1, np.zeros(3), z_to(joint.axis).T)
            else:
                place = position + rotation @ np.array(joint.position)
                places[joint.child] = (number, place, rotation @ rotation_of(joint.rpy))
            waiting.append(joint.child)
    return places


def chain_capsules(tree: UrdfTree, joints: Sequence[str], tip: str) -> tuple[LinkCapsule, ...]:
    """Capsules from joint to joint, thinner towards the flange, for an arm of which nothing else is known."""
    chain, moving = chain_bodies(tree, joints, tip), [item for item in tree.way_to(tip) if turned_by(item, joints)]
    steps = [body.position for body in chain.bodies[1:]] + [chain.flange_position]
    # of where the arm stands in the file only the height of its shoulder above its foot is a length of the arm
    foot = abs(float(chain.bodies[0].rotation[:, 2] @ chain.bodies[0].position))
    lengths = [foot, *(float(np.linalg.norm(step)) for step in steps)]
    total, gone, found = sum(lengths), lengths[0], []
    for joint, step, length in zip(moving, steps, lengths[1:], strict=True):
        lay = z_to(joint.axis)
        radius = total * (_THICK + (_THIN - _THICK) * (gone + length / 2) / total)
        end = tuple((lay @ step).tolist())
        found.append(LinkCapsule(joint.child, (0.0, 0.0, 0.0), end, radius))
        gone += length
    return tuple(found)
