"""Joint logs in ROS bags."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.execution.bag_logs import JOINT_STATE, read_bag
from nospill.execution.log import log_of_joints

rosbags = pytest.importorskip("rosbags", reason="rosbags is not installed")

NAMES = ["joint_b", "joint_a"]
POSITION = np.column_stack([np.linspace(0.0, 1.0, 40), np.linspace(2.0, 3.0, 40)])


def write(place: Path, *, ros1: bool, kind: str = JOINT_STATE) -> Path:
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    types: Any = store.types
    writer: Any = Writer1(place) if ros1 else Writer2(place, version=9, storage_plugin=StoragePlugin.MCAP)
    with writer as bag:
        connection = bag.add_connection("/joint_states", kind, typestore=store)
        for index, row in enumerate(POSITION):
            stamp = types["builtin_interfaces/msg/Time"](sec=5, nanosec=index * 2_000_000)
            extra = {"seq": index} if ros1 else {}
            header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="", **extra)
            message = types[kind](header=header, name=NAMES, position=row, velocity=np.zeros(0), effort=np.zeros(0))
            data = store.serialize_ros1(message, kind) if ros1 else store.serialize_cdr(message, kind)
            bag.write(connection, 5_000_000_000 + index * 2_100_000, data)
    return place


@pytest.mark.parametrize("ros1", [False, True])
def test_joint_states_by_their_headers_time(tmp_path: Path, ros1: bool) -> None:
    raw = read_bag(write(tmp_path / ("run.bag" if ros1 else "run"), ros1=ros1), ("joint_a", "joint_b"))
    found = log_of_joints(raw, ("joint_a", "joint_b"))
    assert found.t == pytest.approx(0.002 * np.arange(40))
    assert found.position == pytest.approx(POSITION[:, ::-1])


def test_joints_of_another_robot_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"no message has the 2 joints elbow, wrist; found: joint_a, joint_b"):
        read_bag(write(tmp_path / "run", ros1=False), ("elbow", "wrist"))


def test_what_is_no_bag_is_refused(tmp_path: Path) -> None:
    (tmp_path / "run.bag").write_bytes(b"no bag")
    with pytest.raises(ScenarioError, match=r"run.bag: damaged, or not a ROS bag"):
        read_bag(tmp_path / "run.bag", ("joint_a", "joint_b"))
