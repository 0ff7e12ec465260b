"""Bodies of an arm's links: meshes of an installed package where one has the arm, else the capsules of its collisions.

The same bodies stand in the viewer, in films and in the report.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from nospill.collisions.bodies import bracket_corners
from nospill.core.shapes import capsule_shape
from nospill.drawing.geometry import Mesh, merge_meshes, transform_mesh, tube
from nospill.drawing.obstacles import shape_surface
from nospill.drawing.packaged_meshes import packaged_meshes
from nospill.drawing.robot_model import DrawnChain
from nospill.robots.capsules import PlacedCapsule, placed_capsules
from nospill.robots.kinematics.bodies import z_to
from nospill.robots.robot import Robot
from nospill.scene.tray import TRAY_THICKNESS, Tray

_BAR, _PLATE, _PLATE_THICKNESS = 0.025, 0.045, 0.01
"""m; radius of the bar from the flange to the board, as in collisions, and of the plate the board lies on."""
_COLUMN = 0.05
"""Radius of the column below the first joint over the distance of the flange, of an arm nobody states capsules of."""


def arm_bodies(robot: Robot, chain: DrawnChain, tray: Tray | None = None) -> dict[str, Mesh]:
    """Bodies of an arm's links, each in its link's own frame (that of the joint that carries it), m.

    Args:
        robot: the arm.
        chain: its joints.
        tray: what the flange carries: what turns with it is cut off below its board, and a bar holds it.

    Returns:
        By the name of the link, only links that have a body; what stands still under `chain.base`.

    Raises:
        ScenarioError: the robot's URDF cannot be read.
    """
    parts = packaged_meshes(robot) or _capsules(robot, chain)
    links = {chain.base, *(joint.child for joint in chain.joints)}
    parts = {link: mesh for link, mesh in parts.items() if link in links}
    if tray is None:
        return parts
    for link, (position, rotation) in _behind_last_joint(chain).items():
        # on a bracket the flange may be above the board, beside it
        if link in parts and tray.tool.upright:
            parts[link] = _below_board(parts[link], position, rotation, tray)
    return _with(parts, chain.joints[-1].child, holder(tray))


def holder(tray: Tray) -> Mesh:
    """From the flange to the underside of the board, flange frame."""
    out = tray.tool.rotation[:, 2]
    end = np.asarray(tray.tool.position, dtype=float) - TRAY_THICKNESS * out
    plate = tube(end - _PLATE_THICKNESS * out, end, (_PLATE, _PLATE))
    if not tray.tool.upright:
        corners = bracket_corners(tray.tool)
        bars = [
            transform_mesh(
                shape_surface(capsule_shape(_BAR, length + 2.0 * _BAR)), (start + stop) / 2.0, z_to(stop - start)
            )
            for start, stop in pairwise(corners)
            if (length := float(np.linalg.norm(stop - start))) > 1e-3
        ]
        return merge_meshes([*bars, plate])
    if np.linalg.norm(end) < 1e-3:
        return plate
    return merge_meshes([tube(np.zeros(3), end, (_BAR, _BAR)), plate])


def _capsules(robot: Robot, chain: DrawnChain) -> dict[str, Mesh]:
    """The capsules of collisions, which are fixed to the frames of moving joints, in the frames of links."""
    moving = [joint for joint in chain.joints if joint.index is not None]
    parts: dict[str, Mesh] = {}
    for item in placed_capsules(robot):
        if item.joint == 0:
            parts = _with(parts, chain.base, _surface(item))
        else:
            joint = moving[item.joint - 1]
            parts = _with(parts, joint.child, transform_mesh(_surface(item), np.zeros(3), z_to(joint.axis)))
    if not robot.capsules:
        parts = _with(parts, chain.base, _column(chain))
    return parts


def _surface(item: PlacedCapsule) -> Mesh:
    axis = item.ends[1] - item.ends[0]
    length = float(np.linalg.norm(axis))
    shape = capsule_shape(item.radius, length + 2.0 * item.radius)
    return transform_mesh(shape_surface(shape), item.ends.mean(axis=0), z_to(axis) if length > 0.0 else np.eye(3))


def _column(chain: DrawnChain) -> Mesh:
    """What the first moving joint stands on, in the frame of the root."""
    reach = sum(float(np.linalg.norm(joint.position)) for joint in chain.joints)
    first = next(number for number, joint in enumerate(chain.joints) if joint.index is not None)
    # no moving joint comes before it, so that any angles will do
    frames = chain.frames(np.zeros((1, sum(joint.index is not None for joint in chain.joints))))
    foot = frames[first - 1][0][0] if first else np.zeros(3)
    top, radius = frames[first][0][0], _COLUMN * reach
    if np.linalg.norm(top - foot) < 1e-6:
        return shape_surface(capsule_shape(radius, 2.0 * radius))
    return tube(foot, top, (1.5 * radius, radius))


def _behind_last_joint(chain: DrawnChain) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Links that turn with the flange -> place of the flange in each one's frame: origin (3,), m, and axes (3, 3)."""
    last = max(number for number, joint in enumerate(chain.joints) if joint.index is not None)
    position, rotation = np.zeros(3), np.eye(3)
    found = {chain.joints[-1].child: (position, rotation)}
    for before, joint in zip(chain.joints[last:-1][::-1], chain.joints[last + 1 :][::-1], strict=True):
        position, rotation = joint.position + joint.rotation @ position, joint.rotation @ rotation
        found[before.child] = (position, rotation)
    return found


def _below_board(mesh: Mesh, position: np.ndarray, rotation: np.ndarray, tray: Tray) -> Mesh:
    """A body pressed below the board's underside; the flange is at `position` with axes `rotation` in its frame."""
    in_flange = (mesh.vertices - position) @ rotation
    top = float(tray.tool.position[2]) - TRAY_THICKNESS
    in_flange[:, 2] = np.minimum(in_flange[:, 2], top)
    return Mesh(in_flange @ rotation.T + position, mesh.faces)


def _with(parts: dict[str, Mesh], link: str, mesh: Mesh) -> dict[str, Mesh]:
    return {**parts, link: merge_meshes([parts[link], mesh]) if link in parts else mesh}
