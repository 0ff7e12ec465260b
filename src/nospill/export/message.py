"""A motion as the message trajectory_msgs/JointTrajectory of ROS, in plain tables, and back.

Units are those of ROS (REP 103): rad, rad/s, rad/s^2, s. The controller joint_trajectory_controller of ros2_controllers
plays it with one quintic polynomial per segment and joint where a message has positions, velocities and accelerations;
`POINT_COLUMNS` therefore are all there, always. It refuses a message whose last velocities are not zero.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from nospill.errors import PlanFolderError
from nospill.export.base import checked_samples, finite_row, full_columns, require_joints
from nospill.motion.interpolation import JointSamples
from nospill.scene.scene import Scene

MESSAGE_TYPE = "trajectory_msgs/msg/JointTrajectory"
POINT_COLUMNS = {"positions": "rad", "velocities": "rad/s", "accelerations": "rad/s^2"}
"""Columns of a point and their units."""
UNITS = POINT_COLUMNS | {"time_from_start": "s and ns"}
RECEIVER = "ROS 2 joint_trajectory_controller: one quintic per segment through position, velocity and acceleration"

_NANO = 1_000_000_000


def message_table(samples: JointSamples, scene: Scene) -> dict[str, Any]:
    """Header, joint_names and points of the message, as dictionaries, lists and numbers."""
    speed, acceleration = full_columns(samples)
    nanoseconds = np.round(samples.t * _NANO).astype(np.int64)
    points = []
    for row, stamp in enumerate(nanoseconds.tolist()):
        rows = (samples.position[row], speed[row], acceleration[row])
        point: dict[str, Any] = dict(zip(POINT_COLUMNS, (values.tolist() for values in rows), strict=True))
        point["time_from_start"] = {"sec": stamp // _NANO, "nanosec": stamp % _NANO}
        points.append(point)
    header = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    return {"header": header, "joint_names": list(scene.robot.joints), "points": points}


def message_samples(table: Any, scene: Scene, path: Path) -> JointSamples:
    """The samples of a message.

    Args:
        table: what `message_table` made, or anything else a file held.
        scene: whose robot it must be for.
        path: the file, for messages.

    Raises:
        PlanFolderError: it is no such message, or for other joints.
    """
    points = table.get("points") if isinstance(table, dict) else None
    if not isinstance(points, list) or "joint_names" not in table:
        raise PlanFolderError(f"{path}: not a message {MESSAGE_TYPE}: joint_names or points are missing")
    require_joints(table["joint_names"], scene, path)
    joints = len(scene.robot.joints)
    stamps, columns = [], {name: [] for name in POINT_COLUMNS}
    for number, point in enumerate(points, 1):
        where = f"{path}, point {number}"
        if not isinstance(point, dict):
            raise PlanFolderError(f"{where}: {str(point)[:60]} is not a point of a trajectory")
        stamps.append(_seconds(point.get("time_from_start"), where))
        for name, rows in columns.items():
            cells = point.get(name)
            if not isinstance(cells, list) or not all(type(cell) in (int, float) for cell in cells):
                raise PlanFolderError(f"{where}, {name}: {str(cells)[:80]} is not a list of numbers")
            rows.append(finite_row(cells, joints, f"{where}, {name}"))
    position, speed, acceleration = (np.array(rows).reshape(-1, joints) for rows in columns.values())
    return checked_samples(JointSamples(np.array(stamps), position, speed, acceleration), path)


def _seconds(stamp: Any, where: str) -> float:
    if isinstance(stamp, dict):
        sec, nanosec = stamp.get("sec"), stamp.get("nanosec")
        if type(sec) is int and type(nanosec) is int and sec >= 0 and 0 <= nanosec < _NANO:
            return (sec * _NANO + nanosec) / _NANO
    raise PlanFolderError(f"{where}: time_from_start is {str(stamp)[:60]}; whole sec and nanosec are expected")
