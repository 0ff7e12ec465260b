"""A joint log by its place: a table of text or a ROS bag, as the joints of a robot."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path

from nospill.core.units import as_written
from nospill.errors import ScenarioError
from nospill.execution.bag_logs import read_bag
from nospill.execution.csv_logs import is_table, read_table
from nospill.execution.log import JointLog, log_of_joints
from nospill.robots.robot import Robot


def read_log(
    path: str | os.PathLike[str],
    robot: Robot,
    *,
    offsets: Mapping[str, float] | None = None,
    rate: float | None = None,
    unit: str = "rad",
    topic: str | None = None,
) -> JointLog:
    """Read the joint log of a robot.

    Args:
        path: a table of text, or a ROS bag (`.bag`, `.mcap`, or the folder of a ROS 2 bag).
        robot: whose joints.
        offsets: rad, by joint: added to what was recorded.
        rate: rows a second of a table without times, Hz; 500 of one without a header where left out.
        unit: "rad" or "deg", of the angles of a table whose names say nothing.
        topic: of a bag; the one with the robot's joints where left out.

    Raises:
        ScenarioError: no such file, no such columns, or another unit or rate than there can be.
        MissingExtraError: a bag, without rosbags.
    """
    if unit not in ("rad", "deg"):
        raise ScenarioError(f"--unit {as_written(unit)} is not known; choose rad or deg")
    if rate is not None and not (math.isfinite(rate) and rate > 0.0):
        raise ScenarioError(f"--rate {rate:g}: rows a second are needed, for example 500")
    place = Path(path)
    if not place.exists():
        raise ScenarioError(f"{place}: no such file; give a joint log as CSV or as a ROS bag")
    joints = robot.joints
    raw = read_table(place, joints=len(joints)) if is_table(place) else read_bag(place, joints, topic)
    return log_of_joints(raw, joints, offsets, rate=rate, unit=unit)
