"""The tray that joints carry along a path of their own, as polynomials of s.

Of the tray value, first and second derivative are those of forward kinematics at the ends of short spans; the quintics
between them are off by less than a micrometre, which the problem has room for: the certificate is about the joints.
"""

from __future__ import annotations

import numpy as np

from nospill.core.arrays import read_only
from nospill.core.attitudes import yaw_of
from nospill.core.hermite import quintic_hermite
from nospill.core.piecewise import Pieces, refined
from nospill.paths.joint_curves import JointCurve
from nospill.paths.path import Path
from nospill.robots.kinematics.forward import ToolMotions, kinematics
from nospill.robots.robot import Robot
from nospill.robots.tool import Tool

_SPAN = 0.12
"""rad; greatest change of all joints together over a span."""


def carried_path(robot: Robot, tool: Tool, joints: Pieces, notes: tuple[str, ...] = ()) -> Path:
    """The path of the tray that joints carry.

    Its yaw is the turn about the vertical, added up from the start: with a level tray its yaw, and steady in any pose.

    Args:
        robot: the arm.
        tool: frame of the tray on its flange.
        joints: over s in [0, 1], (n) columns, rad, of degree 5 at most.
        notes: for people.
    """
    breaks = _refined_breaks(joints)
    of_joints = refined(joints, breaks, degree=5)
    fine = Pieces(breaks, of_joints)
    at_ends = [fine(breaks, order) for order in range(3)]
    motion = kinematics(robot).motions(*at_ends, tool=tool)
    ends = [np.hstack(parts) for parts in _pose_rates(motion)]
    width = np.diff(breaks)[:, None]
    tray = quintic_hermite(width, *(np.stack([own[:-1], own[1:]]) for own in ends))
    curve = JointCurve(Pieces(read_only(breaks), read_only(np.concatenate([tray, of_joints], axis=2))))
    turning, change = motion.angular_velocity[:, 2:], motion.angular_acceleration[:, 2:]
    turned = 0.5 * width * (turning[:-1] + turning[1:]) + width**2 / 12.0 * (change[:-1] - change[1:])
    yaw = float(yaw_of(motion.rotation[:1])[0]) + np.concatenate([[[0.0]], np.cumsum(turned, axis=0)])
    of_yaw = quintic_hermite(width, *(np.stack([own[:-1], own[1:]]) for own in (yaw, turning, change)))
    coefficients = np.concatenate([tray[:, :, :3], of_yaw], axis=2)
    first, last = (read_only(at_ends[0][index]) for index in (0, -1))
    return Path(curve.pieces.breaks, read_only(coefficients), notes, ends=(first, last), joint_curve=curve)


def _refined_breaks(joints: Pieces) -> np.ndarray:
    """Breaks over which the joints change little."""
    found = [joints.breaks[:1]]
    for first, last in zip(joints.breaks[:-1], joints.breaks[1:], strict=True):
        way = np.abs(np.diff(joints(np.linspace(first, last, 9)), axis=0)).sum()
        found.append(np.linspace(first, last, max(1, int(np.ceil(way / _SPAN))) + 1)[1:])
    return np.concatenate(found)


def _pose_rates(motion: ToolMotions) -> tuple[list[np.ndarray], ...]:
    """Position and rotation (m, 9) of the tray, and their first and second derivatives."""
    turning, change = _cross(motion.angular_velocity), _cross(motion.angular_acceleration)
    rotations = (motion.rotation, turning @ motion.rotation, (change + turning @ turning) @ motion.rotation)
    positions = (motion.position, motion.velocity, motion.acceleration)
    return tuple([place, turn.reshape(-1, 9)] for place, turn in zip(positions, rotations, strict=True))


def _cross(vectors: np.ndarray) -> np.ndarray:
    """Matrices (m, 3, 3) of the vector product with vectors (m, 3)."""
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    return np.moveaxis(np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]), 2, 0)
