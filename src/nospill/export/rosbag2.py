"""A ROS 2 bag (a folder with metadata.yaml and an MCAP file) that holds one trajectory_msgs/JointTrajectory.

`ros2 bag play` publishes it on the topic the controller listens to. Units are kept in the bag's custom data. The
library rosbags writes and reads it, without a ROS installation; it comes with the extra `ros`.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from nospill.core.files import atomic_folder
from nospill.errors import MissingExtraError, PlanFolderError, ScenarioError
from nospill.export.base import Exporter
from nospill.export.message import (
    MESSAGE_TYPE,
    OPTIONS,
    POINT_COLUMNS,
    RECEIVER,
    TOPIC,
    UNITS,
    Addressed,
    message_samples,
    message_table,
)
from nospill.motion.interpolation import QUINTIC_HERMITE, JointSamples
from nospill.scene.scene import Scene

_BAG_VERSION = 9
_METADATA = "metadata.yaml"


def _typestore() -> Any:
    try:
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise MissingExtraError(
            "a ROS 2 bag needs the library rosbags; install it with pip install 'nospill[ros]'"
        ) from error
    return get_typestore(Stores.ROS2_HUMBLE)


def _is_bag(names: set[str]) -> bool:
    return _METADATA in names and all(name == _METADATA or name.endswith(".mcap") for name in names)


def _write(samples: JointSamples, scene: Scene, path: Path, sent: Addressed) -> None:
    store = _typestore()
    from rosbags.rosbag2 import StoragePlugin, Writer

    types, table = store.types, message_table(samples, scene, sent)
    duration = types["builtin_interfaces/msg/Duration"]
    points = [
        types["trajectory_msgs/msg/JointTrajectoryPoint"](
            **{name: np.array(point[name]) for name in POINT_COLUMNS},
            effort=np.empty(0),
            time_from_start=duration(**point["time_from_start"]),
        )
        for point in table["points"]
    ]
    stamp = types["builtin_interfaces/msg/Time"](**table["header"]["stamp"])
    header = types["std_msgs/msg/Header"](stamp=stamp, frame_id=table["header"]["frame_id"])
    message = types[MESSAGE_TYPE](header=header, joint_names=table["joint_names"], points=points)
    with atomic_folder(path, replaceable=_is_bag) as partial:
        inner = partial / path.name  # the library wants to make the folder, and names the MCAP file after it
        with Writer(inner, version=_BAG_VERSION, storage_plugin=StoragePlugin.MCAP) as bag:
            bag.set_custom_data("nospill", json.dumps({"robot": scene.robot.name, "units": UNITS}))
            connection = bag.add_connection(sent.topic or TOPIC, MESSAGE_TYPE, typestore=store)
            bag.write(connection, 0, store.serialize_cdr(message, MESSAGE_TYPE))
        for file in list(inner.iterdir()):
            file.rename(partial / file.name)
        inner.rmdir()


def joint_trajectory_messages(path: Path) -> list[dict[str, Any]]:
    """Every JointTrajectory of a bag of ROS 1 or 2 as a table with `joint_names` and `points`.

    Raises:
        MissingExtraError: rosbags is not installed.
        ScenarioError: it is damaged, or no bag.
    """
    store = _typestore()
    from rosbags.highlevel import AnyReader

    try:
        with AnyReader([path], default_typestore=store) as bag:
            chosen = [connection for connection in bag.connections if connection.msgtype == MESSAGE_TYPE]
            return [
                _plain(bag.deserialize(data, connection.msgtype))
                for connection, _, data in (bag.messages(connections=chosen) if chosen else ())
            ]
    except Exception as error:  # the library lets whatever a damaged file provokes through
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ScenarioError(f"{path}: damaged, or not a ROS bag ({reason[:120]})") from error


def _read(path: Path, scene: Scene, sent: Addressed) -> JointSamples:
    store = _typestore()
    from rosbags.rosbag2 import Reader

    if not (path / _METADATA).is_file():
        raise PlanFolderError(f"{path}: not a ROS 2 bag: {_METADATA} is missing; write it again with nospill export")
    try:
        with Reader(path) as bag:
            messages = [
                store.deserialize_cdr(data, MESSAGE_TYPE)
                for connection, _, data in bag.messages()
                if connection.msgtype == MESSAGE_TYPE
            ]
    except Exception as error:  # the library lets whatever a damaged file provokes through
        reason = " ".join(str(error).split()) or type(error).__name__
        raise PlanFolderError(f"{path}: damaged, or not a ROS 2 bag ({reason[:120]})") from error
    if len(messages) != 1:
        raise PlanFolderError(f"{path}: holds {len(messages)} messages {MESSAGE_TYPE}, one is expected")
    return message_samples(_plain(messages[0]), scene, path, sent)


def _plain(message: Any) -> dict[str, Any]:
    points = [
        {name: getattr(point, name).tolist() for name in POINT_COLUMNS}
        | {"time_from_start": {"sec": point.time_from_start.sec, "nanosec": point.time_from_start.nanosec}}
        for point in message.points
    ]
    return {"joint_names": list(message.joint_names), "points": points}


def rosbag2_exporter(prefix: str = "", topic: str = "", lead: float = 0.0) -> Exporter:
    """The bag as it is played.

    Raises:
        ScenarioError: see `message.Addressed`.
    """
    sent = Addressed(prefix, lead, topic)
    return Exporter(
        name="rosbag2",
        suffixes=(".rosbag2",),
        title="ROS 2 bag (MCAP) with one trajectory_msgs/JointTrajectory; needs the extra ros",
        receiver=RECEIVER,
        interpolation=QUINTIC_HERMITE,
        reason_against=lambda scene, rate: None,
        write=lambda samples, scene, path: _write(samples, scene, path, sent),
        read=lambda path, scene: _read(path, scene, sent),
        uneven=True,
        options=OPTIONS,
        with_options=rosbag2_exporter,
    )


ROSBAG2 = rosbag2_exporter()
"""The message of ROS in a bag."""
