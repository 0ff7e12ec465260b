"""Joint logs in bags of ROS 1 and ROS 2: `sensor_msgs/JointState`, or the state of a joint trajectory controller.

The library rosbags reads them without a ROS installation; it comes with the extra `ros`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from nospill.errors import MissingExtraError, ScenarioError
from nospill.execution.log import RawLog

JOINT_STATE = "sensor_msgs/msg/JointState"
CONTROLLER_STATE = "control_msgs/msg/JointTrajectoryControllerState"

_MEASURED, _ASKED = ("feedback", "actual"), ("reference", "desired")
"""Fields of a controller's state, by their names since ROS 2 Humble and before."""


def read_bag(path: Path) -> RawLog:
    """Read the joint positions of a bag: of the topic of a controller's state, else of the topic of joint states.

    Time is that of the messages' headers where they have one, of their recording else. A controller's state has what
    was asked for too.

    Raises:
        MissingExtraError: rosbags is not installed.
        ScenarioError: the bag cannot be read, or has no such messages.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise MissingExtraError(
            "a ROS bag needs the library rosbags; install it with pip install 'nospill[ros]'"
        ) from error
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as bag:
            of_kind = ([c for c in bag.connections if c.msgtype == kind] for kind in (CONTROLLER_STATE, JOINT_STATE))
            usable = next((found for found in of_kind if found), [])
            chosen = [connection for connection in usable if connection.topic == usable[0].topic]
            messages = [
                (stamp, bag.deserialize(data, connection.msgtype))
                for connection, stamp, data in (bag.messages(connections=chosen) if chosen else ())
            ]
    except Exception as error:  # the library lets whatever a damaged file provokes through
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ScenarioError(f"{path}: damaged, or not a ROS bag ({reason[:120]})") from error
    if not messages:
        raise ScenarioError(f"{path}: holds no message {JOINT_STATE} or {CONTROLLER_STATE}")
    rows = [_row(message) for _, message in messages]
    names = sorted(rows[0])
    if any(sorted(row) != names for row in rows):
        raise ScenarioError(f"{path}: its messages are of different joints; record the topic of one robot")
    t = np.array([_stamp(message, recorded) for recorded, message in messages])
    order = np.argsort(t, kind="stable")
    columns = {name.lower(): np.array([row[name] for row in rows])[order] for name in names}
    return RawLog(str(path), t[order] - t[order[0]], columns)


def _row(message: Any) -> dict[str, float]:
    """Positions by joint, and what was asked for by joint and "_command"."""
    if hasattr(message, "joint_names"):
        measured, asked = (
            next(getattr(message, name) for name in names if hasattr(message, name)) for names in (_MEASURED, _ASKED)
        )
        names = list(message.joint_names)
        found = dict(zip(names, map(float, measured.positions), strict=False))
        return found | {f"{name}_command": float(q) for name, q in zip(names, asked.positions, strict=False)}
    return dict(zip(message.name, map(float, message.position), strict=False))


def _stamp(message: Any, recorded: int) -> float:
    stamp = message.header.stamp
    own = stamp.sec + 1e-9 * stamp.nanosec
    return own if own > 0.0 else 1e-9 * recorded
