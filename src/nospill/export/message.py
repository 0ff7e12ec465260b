"""A motion as the message trajectory_msgs/JointTrajectory of ROS, in plain tables, and back.

Units are those of ROS (REP 103): rad, rad/s, rad/s^2, s. The controller joint_trajectory_controller of ros2_controllers
plays it with one quintic polynomial per segment and joint where a message has positions, velocities and accelerations;
`POINT_COLUMNS` therefore are all there, always. It refuses a message whose last velocities are not zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nospill.errors import PlanFolderError, ScenarioError
from nospill.export.base import checked_samples, finite_row, full_columns, require_joints
from nospill.motion.interpolation import JointSamples
from nospill.scene.scene import Scene

MESSAGE_TYPE = "trajectory_msgs/msg/JointTrajectory"
POINT_COLUMNS = {"positions": "rad", "velocities": "rad/s", "accelerations": "rad/s^2"}
"""Columns of a point and their units."""
UNITS = POINT_COLUMNS | {"time_from_start": "s and ns"}
RECEIVER = "ROS 2 joint_trajectory_controller: one quintic per segment through position, velocity and acceleration"

TOPIC = "/joint_trajectory_controller/joint_trajectory"
"""Of the controller by its usual name."""
OPTIONS = ("prefix", "topic", "lead")
"""What can be chosen about how a message is sent."""
MOST_LEAD = 60.0
"""s; nobody waits longer for a first point."""
_NANO = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Addressed:
    """How a message is sent.

    Attributes:
        prefix: before every joint's name, as the controller has them.
        lead: time of the first point, s: until then the controller goes there from where the arm stands, on a spline of
            its own.
        topic: of the controller, or the name of its action.
        begins: header time, s after the start of the plan that it goes on from; who sends it adds the time of that
            start. Zero, for at once, of a motion from rest.
    """

    prefix: str = ""
    lead: float = 0.0
    topic: str = ""
    begins: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what no controller takes.

        Raises:
            ScenarioError: a lead that is negative or too long, or a name with blanks in it.
        """
        if not 0.0 <= self.lead <= MOST_LEAD:
            raise ScenarioError(f"--lead is {self.lead:g} s; 0 to {MOST_LEAD:g} s are allowed; try --lead 2")
        for option, name in (("prefix", self.prefix), ("topic", self.topic)):
            if any(sign.isspace() for sign in name):
                raise ScenarioError(f"--{option} is {name!r}; a name of ROS has no blanks")

    def names(self, scene: Scene) -> list[str]:
        """The joints as the controller has them."""
        return [f"{self.prefix}{name}" for name in scene.robot.joints]


PLAINLY = Addressed()
"""The joints' own names, the first point at time zero."""


def message_table(samples: JointSamples, scene: Scene, sent: Addressed = PLAINLY) -> dict[str, Any]:
    """Header, joint_names and points of the message, as dictionaries, lists and numbers."""
    speed, acceleration = full_columns(samples)
    nanoseconds = np.round(samples.t * _NANO).astype(np.int64) + round(sent.lead * _NANO)
    points = []
    for row, stamp in enumerate(nanoseconds.tolist()):
        rows = (samples.position[row], speed[row], acceleration[row])
        point: dict[str, Any] = dict(zip(POINT_COLUMNS, (values.tolist() for values in rows), strict=True))
        point["time_from_start"] = _stamp(stamp)
        points.append(point)
    header = {"stamp": _stamp(round(sent.begins * _NANO)), "frame_id": ""}
    return {"header": header, "joint_names": sent.names(scene), "points": points}


def message_samples(table: Any, scene: Scene, path: Path, sent: Addressed = PLAINLY) -> JointSamples:
    """The samples of a message, their times from the first point.

    Args:
        table: what `message_table` made, or anything else a file held.
        scene: whose robot it must be for.
        path: the file, for messages.
        sent: how it is sent.

    Raises:
        PlanFolderError: it is no such message, or for other joints.
    """
    points = table.get("points") if isinstance(table, dict) else None
    if not isinstance(points, list) or "joint_names" not in table:
        raise PlanFolderError(f"{path}: not a message {MESSAGE_TYPE}: joint_names or points are missing")
    if table["joint_names"] != sent.names(scene):
        require_joints(table["joint_names"], scene, path)
    if sent.begins and table.get("header", {}).get("stamp") != _stamp(round(sent.begins * _NANO)):
        raise PlanFolderError(f"{path}, header: its stamp is not {sent.begins:g} s, at which the motion begins")
    joints = len(scene.robot.joints)
    stamps, columns = [], {name: [] for name in POINT_COLUMNS}
    for number, point in enumerate(points, 1):
        where = f"{path}, point {number}"
        if not isinstance(point, dict):
            raise PlanFolderError(f"{where}: {str(point)[:60]} is not a point of a trajectory")
        stamps.append(_nanoseconds(point.get("time_from_start"), where) - round(sent.lead * _NANO))
        for name, rows in columns.items():
            cells = point.get(name)
            if not isinstance(cells, list) or not all(type(cell) in (int, float) for cell in cells):
                raise PlanFolderError(f"{where}, {name}: {str(cells)[:80]} is not a list of numbers")
            rows.append(finite_row(cells, joints, f"{where}, {name}"))
    position, speed, acceleration = (np.array(rows).reshape(-1, joints) for rows in columns.values())
    return checked_samples(JointSamples(np.array(stamps) / _NANO, position, speed, acceleration), path)


def _stamp(nanoseconds: int) -> dict[str, int]:
    return {"sec": nanoseconds // _NANO, "nanosec": nanoseconds % _NANO}


def _nanoseconds(stamp: Any, where: str) -> int:
    if isinstance(stamp, dict):
        sec, nanosec = stamp.get("sec"), stamp.get("nanosec")
        if type(sec) is int and type(nanosec) is int and sec >= 0 and 0 <= nanosec < _NANO:
            return sec * _NANO + nanosec
    raise PlanFolderError(f"{where}: time_from_start is {str(stamp)[:60]}; whole sec and nanosec are expected")
