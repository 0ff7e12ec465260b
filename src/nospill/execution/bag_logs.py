"""Joint logs in bags of ROS 1 and ROS 2: `sensor_msgs/JointState`, or the state of a joint trajectory controller.

The library rosbags reads them without a ROS installation; it comes with the extra `ros`.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from nospill.core.units import listed
from nospill.errors import MissingExtraError, ScenarioError
from nospill.execution.log import RawLog
from nospill.export.message import MESSAGE_TYPE

JOINT_STATE = "sensor_msgs/msg/JointState"
CONTROLLER_STATE = "control_msgs/msg/JointTrajectoryControllerState"

_MEASURED, _ASKED = ("feedback", "actual"), ("reference", "desired")
"""Fields of a controller's state, by their names since ROS 2 Humble and before."""


def read_bag(path: Path, joints: Sequence[str], topic: str | None = None) -> RawLog:
    """Read the joint positions of a bag: of the topic of a controller's state, else of one of joint states.

    Of several topics the one is taken whose messages hold the robot's joints, the one with most of them; messages
    without them, as of a gripper on the same topic, are left out. Time is that of the messages' headers where they have
    one, of their recording else. A controller's state has what was asked for too.

    Args:
        path: of the bag.
        joints: names of the robot's joints.
        topic: to read; found where left out.

    Raises:
        MissingExtraError: rosbags is not installed.
        ScenarioError: the bag cannot be read, has no such topic or no message with these joints.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise MissingExtraError(
            "a ROS bag needs the library rosbags; install it with pip install 'nospill[ros]'"
        ) from error
    by_topic: dict[str, list[tuple[int, Any]]] = {}
    kinds: dict[str, str] = {}
    undefined, commands = set[str](), set[str]()
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as bag:
            commands = {c.topic for c in bag.connections if c.msgtype == MESSAGE_TYPE}
            stated = [c for c in bag.connections if c.msgtype in (CONTROLLER_STATE, JOINT_STATE)]
            # up to ROS 2 Humble bags bring no definitions of their types, and those of controllers are not ROS's own
            usable = [c for c in stated if c.msgtype in bag.typestore.fielddefs]
            undefined = {c.topic for c in stated if c not in usable}
            for connection, stamp, data in bag.messages(connections=usable) if usable else ():
                kinds[connection.topic] = connection.msgtype
                message = bag.deserialize(data, connection.msgtype)
                by_topic.setdefault(connection.topic, []).append((stamp, message))
    except Exception as error:  # the library lets whatever a damaged file provokes through
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ScenarioError(f"{path}: damaged, or not a ROS bag ({reason[:120]})") from error
    if not by_topic and undefined:
        raise ScenarioError(
            f"{path}: {listed(sorted(undefined), last='and')} cannot be read, since the bag has no definition of "
            f"{CONTROLLER_STATE}; record {JOINT_STATE} too, or convert the bag to MCAP where that package is installed"
        )
    if not by_topic and commands:
        raise ScenarioError(
            f"{path}: {listed(sorted(commands), last='and')} is a {MESSAGE_TYPE}, a command and no log of what the "
            f"joints did; record {JOINT_STATE} while it is played, or judge the command by nospill judge {path}"
        )
    if not by_topic:
        raise ScenarioError(f"{path}: holds no message {JOINT_STATE} or {CONTROLLER_STATE}")
    if topic is not None and topic not in by_topic:
        raise ScenarioError(f"--topic {topic}: {path} has no such topic of joints; choose {listed(tuple(by_topic))}")
    candidates = [topic] if topic is not None else sorted(by_topic, key=lambda name: kinds[name] != CONTROLLER_STATE)
    found = {name: _with_joints(by_topic[name], joints) for name in candidates}
    best = max(found, key=lambda name: (kinds[name] == CONTROLLER_STATE and bool(found[name]), len(found[name])))
    if not found[best]:
        named = sorted({name for rows in by_topic.values() for _, message in rows for name in _row(message)})
        shown = ", ".join(named)[:160] or "none"
        raise ScenarioError(f"{path}: no message has the {len(joints)} joints {', '.join(joints)}; found: {shown}")
    others = [name for name in candidates if found[name] and name != best]
    return _raw(path, best, found[best], len(by_topic[best]), others, undefined)


def _with_joints(messages: Sequence[tuple[int, Any]], joints: Sequence[str]) -> list[tuple[int, Any, dict[str, float]]]:
    """The messages that hold the robot's joints, with their rows; by names, else by numbers."""
    rows = [(stamp, message, _row(message)) for stamp, message in messages]
    wanted = {name.lower() for name in joints}
    named = [row for row in rows if wanted <= {name.lower() for name in row[2]}]
    if named:
        return named
    numbered = re.compile(r".*?_?\d+")
    return [row for row in rows if len(joints) == sum(bool(numbered.fullmatch(name)) for name in row[2])]


def _raw(
    path: Path,
    topic: str,
    rows: Sequence[tuple[int, Any, dict[str, float]]],
    count: int,
    others: Sequence[str],
    undefined: Collection[str],
) -> RawLog:
    t = np.array([_stamp(message, recorded) for recorded, message, _ in rows])
    order = np.argsort(t, kind="stable")
    names = [name for name in rows[0][2] if all(name in row for _, _, row in rows)]
    columns = {name.lower(): np.array([row[name] for _, _, row in rows])[order] for name in names}
    headers = any(message.header.stamp.sec or message.header.stamp.nanosec for _, message, _ in rows[:1])
    said = [f"topic {topic}, time from {'headers' if headers else 'the recorder'}"]
    if count > len(rows):
        said.append(f"{count - len(rows):,} messages without these joints left out")
    if others:
        said.append(f"{listed(tuple(others), last='and')} not read (--topic)")
    if undefined:
        said.append(f"{listed(sorted(undefined), last='and')} not read, the bag does not define its type")
    t = t[order] - t[order[0]]
    infinite = {name: np.where(np.isfinite(values), values, np.nan) for name, values in columns.items()}
    return RawLog(str(path), infinite, {name: "rad" for name in infinite}, t, ", ".join(said))


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
