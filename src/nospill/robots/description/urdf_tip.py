"""The tip of a chain: which frame it is, how its z axis lies to the axis of the last joint, and a turn that is stated.

A level tray has the tip's z axis upwards: that axis is to point out of the flange, along the axis of the last joint.
ROS's convention for frames called flange has the x axis there.
"""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np

from nospill.core.units import format_quantity
from nospill.errors import ScenarioError
from nospill.robots.description.urdf_followers import hint_of, some
from nospill.robots.description.urdf_tree import UrdfJoint, UrdfTree, Vector, rotation_of
from nospill.robots.robot import Doubt

USUAL_TIPS = ("tool0", "flange")
"""Frames taken as the tip when none is named, the first that exists: names of the ROS-Industrial convention."""

_OFF_AXIS = math.radians(1.0)
_AWAY = 1e-3  # m
_TURNED = "tip_turned"


def tip_of(tree: UrdfTree, tip: str | None) -> tuple[str, list[str]]:
    """The flange link and a note where it was chosen.

    Raises:
        ScenarioError: the tip is not in the tree, or none is given and there are several ends.
    """
    links = list(tree.links)
    if tip is not None:
        if tip not in tree.links:
            raise ScenarioError(f"tip {tip!r} is not in the URDF (frames: {some(links)}){hint_of(tip, links)}")
        return tip, []
    parents = {joint.parent for joint in tree.joints}
    ends = [link for link in links if link not in parents]
    usual = [link for link in USUAL_TIPS if link in tree.links]
    if not usual and len(ends) > 1:
        raise ScenarioError(f"tip is missing and the URDF has several ends ({some(ends)}); name the flange's frame")
    chosen = usual[0] if usual else ends[0]
    return chosen, [f"the tip is the frame {chosen!r}; the tray stands along its z axis"]


def turned_tip(tree: UrdfTree, tip: str, rpy: Vector) -> tuple[UrdfTree, str]:
    """The description with a frame at the tip that is turned against it, and the name of that frame.

    Args:
        tree: the description.
        tip: the flange link as it is in the file.
        rpy: roll, pitch and yaw about the tip's own x, y and z, in this order, rad.
    """
    if not any(rpy):
        return tree, tip
    frame, name = _free(_TURNED, tree.links), _free(f"to_{_TURNED}", [joint.name for joint in tree.joints])
    turn = UrdfJoint(name, "fixed", tip, frame, rpy=rpy)
    return UrdfTree(tree.name, {**tree.links, frame: None}, (*tree.joints, turn), tree.meshes), frame


def tip_doubt(tree: UrdfTree, tip: str, rpy: Vector) -> Doubt | None:
    """What is said where the tip's z axis does not point out of the flange along the axis of the last joint.

    Outwards is where the tip lies, seen along that axis from the joint before; where it lies beside neither way, the
    nearer one of both directions.

    Args:
        tree: the description as in the file, no joint locked.
        tip: the flange link.
        rpy: by which the tip is turned already, rad.
    """
    way = tree.way_to(tip)
    moving = [index for index, joint in enumerate(way) if joint.kind != "fixed"]
    if not moving:
        return None
    last = way[moving[-1]]
    place, turn = _pose(way[moving[-1] + 1 :])
    turn = turn @ rotation_of(rpy)
    axis = np.array(last.axis) / np.linalg.norm(last.axis)
    before = _pose(way[moving[-2] + 1 : moving[-1] + 1]) if len(moving) > 1 else (np.zeros(3), np.eye(3))
    outwards = float((before[1].T @ before[0] + place) @ axis)
    if last.kind == "prismatic" or (len(moving) > 1 and abs(outwards) <= _AWAY):
        outwards = float(turn[:, 2] @ axis) or 1.0
    if outwards < 0.0:
        axis = -axis
    lean = math.acos(float(np.clip(turn[:, 2] @ axis, -1.0, 1.0)))
    if lean <= _OFF_AXIS:
        return None
    advice = "[" + ", ".join(f'"{_degrees(value)} deg"' for value in _remedy(rotation_of(rpy) @ turn.T @ axis)) + "]"
    how = (
        "lies square to the axis of the last joint"
        if abs(lean - math.pi / 2) <= _OFF_AXIS
        else "points back along the axis of the last joint, into the arm"
        if math.pi - lean <= _OFF_AXIS
        else f"leans {format_quantity(lean, 'angle', digits=3)} from the axis of the last joint"
    )
    return Doubt(
        "tip",
        tip,
        f"the z axis of the tip {tip!r} {how} ({last.name}), and the tray stands along it. Where the tray is to stand "
        f"on the face of the flange, write tip_rpy = {advice} under [robot].",
    )


def _remedy(outwards: np.ndarray) -> Vector:
    """Roll, pitch and yaw that turn z onto a direction (3,) of the tip's own frame, the yaw being zero."""
    x, y, z = outwards
    return (math.asin(float(np.clip(-y, -1.0, 1.0))), math.atan2(x, z) if math.hypot(x, z) > 1e-9 else 0.0, 0.0)


def _degrees(angle: float) -> str:
    return f"{round(math.degrees(angle), 6) + 0.0:g}" if abs(math.degrees(angle)) > 1e-6 else "0"


def _pose(joints: list[UrdfJoint]) -> tuple[np.ndarray, np.ndarray]:
    """Position (3,) and axes (3, 3) of the last of some joints' frames at zero, from the frame before the first."""
    position, rotation = np.zeros(3), np.eye(3)
    for joint in joints:
        position, rotation = position + rotation @ np.array(joint.position), rotation @ rotation_of(joint.rpy)
    return position, rotation


def _free(name: str, taken: Collection[str]) -> str:
    while name in taken:
        name += "_"
    return name
