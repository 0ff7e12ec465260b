"""Distances of an arm to itself, its tray and its cargo by coal, with kinematics of their own from the URDF's text.

Nothing of `nospill.collisions` or `nospill.robots` computes anything here: joints are read from the XML, capsules, tray
and cargo are made of coal's own shapes, cups as cylinders that hold them.
"""

from __future__ import annotations

import importlib
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from typing import Any

import numpy as np

from nospill.scene.scene import Scene

coal: Any = importlib.import_module("coal")

BOARD = 0.006
"""m; thickness of the tray."""


@dataclass(frozen=True)
class Solid:
    """A shape fixed to a link.

    Attributes:
        name: of the link, the tray or the object.
        link: to which it is fixed.
        shape: coal's.
        pose: (4, 4) in the link's frame.
        reach: m; by how much it may be entered, where it is estimated.
    """

    name: str
    link: str
    shape: Any
    pose: np.ndarray
    reach: float = 0.0


def pose(xyz: np.ndarray, rpy: np.ndarray) -> np.ndarray:
    """(4, 4) of fixed-axis roll, pitch and yaw."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    turn = np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
    return np.block([[turn, np.reshape(xyz, (3, 1))], [np.zeros((1, 3)), np.ones((1, 1))]])


class Arm:
    """Forward kinematics of a URDF: poses of all links, (m, 4, 4) in the root."""

    def __init__(self, urdf: str, joints: tuple[str, ...]) -> None:
        self.joints = joints
        self.steps = []
        for joint in ElementTree.fromstring(urdf).iter("joint"):
            parent, child, origin, axis = (joint.find(key) for key in ("parent", "child", "origin", "axis"))
            if parent is None or child is None:
                continue
            at = [_numbers("0 0 0" if origin is None else origin.get(key, "0 0 0")) for key in ("xyz", "rpy")]
            about = _numbers("1 0 0" if axis is None else axis.get("xyz", "1 0 0"))
            self.steps.append((joint.get("name"), parent.get("link"), child.get("link"), pose(*at), about))

    def poses(self, q: np.ndarray) -> dict[str, np.ndarray]:
        """Of each link at joint positions (m, n), rad."""
        children = {child for _, _, child, _, _ in self.steps}
        (root,) = {parent for _, parent, _, _, _ in self.steps} - children
        found = {root: np.tile(np.eye(4), (len(q), 1, 1))}
        waiting = list(self.steps)
        while waiting:
            name, parent, child, origin, axis = waiting.pop(0)
            if parent not in found:
                waiting.append((name, parent, child, origin, axis))
                continue
            found[child] = found[parent] @ origin
            if name in self.joints:
                found[child] = found[child] @ _turns(axis, q[:, self.joints.index(name)])
        return found


def _numbers(text: str) -> np.ndarray:
    return np.array([float(value) for value in text.split()])


def _turns(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """(m, 4, 4) turns about an axis, by Rodrigues' formula."""
    x, y, z = axis / np.linalg.norm(axis)
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    found = np.tile(np.eye(4), (len(angle), 1, 1))
    found[:, :3, :3] += np.sin(angle)[:, None, None] * skew + (1.0 - np.cos(angle))[:, None, None] * (skew @ skew)
    return found


def solids(scene: Scene) -> list[Solid]:
    """Capsules of the links, the tray, and the objects: boxes, and cylinders about what is round."""
    share = 0.25 if scene.robot.sources["capsules"].startswith("estimated") else 0.0
    found = []
    for item in scene.robot.capsules:
        start, end = np.array(item.start), np.array(item.end)
        length = float(np.linalg.norm(end - start))
        at = np.eye(4)
        at[:3, 3] = (start + end) / 2
        if length > 0.0:
            at[:3, :3] = _z_to((end - start) / length)
        found.append(Solid(item.link, item.link, coal.Capsule(item.radius, length), at, share * item.radius))
    tool, tip = scene.tray.tool, scene.robot.tip
    tray = pose(tool.position, np.array([0.0, 0.0, tool.yaw]))
    board = coal.Box(*map(float, scene.tray.size), BOARD)
    found.append(Solid("tray", tip, board, tray @ pose(np.array([0.0, 0.0, -BOARD / 2]), np.zeros(3))))
    for item in scene.cargo:
        outline, height = item.container.outline, item.container.height
        middle = tray @ pose(np.array([*item.position, item.seat + height / 2]), np.array([0.0, 0.0, item.yaw]))
        low, high = outline.min(axis=0), outline.max(axis=0)
        is_box = type(item.container).__name__.lower() == "box"
        shape = coal.Box(*(high - low), height) if is_box else coal.Cylinder(float(np.abs(outline).max()), height)
        found.append(Solid(item.name, tip, shape, middle))
    return found


def _z_to(axis: np.ndarray) -> np.ndarray:
    other = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    other /= np.linalg.norm(other)
    return np.column_stack([other, np.cross(axis, other), axis])


def least_rooms(scene: Scene, q: np.ndarray, pairs: set[tuple[str, str]]) -> dict[tuple[str, str], float]:
    """Least distance by coal, m, of each pair of names at joint positions (m, n), beside what may be entered."""
    poses, parts = Arm(scene.robot.urdf, scene.robot.joints).poses(q), solids(scene)
    found: dict[tuple[str, str], float] = {}
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    for first in parts:
        for second in parts:
            if (first.name, second.name) not in pairs:
                continue
            measure = coal.ComputeDistance(first.shape, second.shape)
            between = np.linalg.inv(poses[second.link] @ second.pose) @ (poses[first.link] @ first.pose)
            still, least = coal.Transform3s.Identity(), np.inf
            for one in between:
                result.clear()
                at = coal.Transform3s(np.ascontiguousarray(one[:3, :3]), one[:3, 3])
                least = min(least, float(measure(at, still, request, result)))
            key = first.name, second.name
            found[key] = min(found.get(key, np.inf), least + first.reach + second.reach)
    return found
