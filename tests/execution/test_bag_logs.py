"""Joint logs in ROS bags."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.execution.bag_logs import CONTROLLER_STATE, JOINT_STATE, read_bag
from nospill.execution.log import log_of_joints
from nospill.export import EXPORTERS
from nospill.motion.interpolation import JointSamples
from tests.export.test_formats import arm

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


STATE = """std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint desired
trajectory_msgs/JointTrajectoryPoint actual
trajectory_msgs/JointTrajectoryPoint error
"""
"""Of control_msgs; ROS 2 Humble's recorder writes messages without it."""


def write_as_humble(place: Path, *, joint_states: bool) -> Path:
    """A bag of SQLite without definitions, with states of a controller and perhaps joint states."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg(STATE, CONTROLLER_STATE))
    types: Any = store.types
    point = types["trajectory_msgs/msg/JointTrajectoryPoint"]
    with Writer(place, version=8, storage_plugin=StoragePlugin.SQLITE3) as bag:
        states = bag.add_connection("/controller/state", CONTROLLER_STATE, typestore=store)
        joints = bag.add_connection("/joint_states", JOINT_STATE, typestore=store) if joint_states else None
        for index, row in enumerate(POSITION):
            stamp = types["builtin_interfaces/msg/Time"](sec=5, nanosec=index * 2_000_000)
            header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="")
            none = np.zeros(0)
            at = point(row, none, none, none, types["builtin_interfaces/msg/Duration"](sec=0, nanosec=0))
            state = types[CONTROLLER_STATE](header, NAMES, at, at, at)
            bag.write(states, index * 2_000_000, store.serialize_cdr(state, CONTROLLER_STATE))
            if joints is not None:
                own = types[JOINT_STATE](header, NAMES, row, none, none)
                bag.write(joints, index * 2_000_000, store.serialize_cdr(own, JOINT_STATE))
    with closing(sqlite3.connect(next(place.glob("*.db3")))) as file, file:
        file.execute("DELETE FROM message_definitions")
    return place


def test_a_type_that_the_bag_does_not_define_is_passed_over(tmp_path: Path) -> None:
    raw = read_bag(write_as_humble(tmp_path / "run", joint_states=True), ("joint_a", "joint_b"))
    found = log_of_joints(raw, ("joint_a", "joint_b"))
    assert found.position == pytest.approx(POSITION[:, ::-1])
    assert "topic /joint_states" in raw.said and "/controller/state not read, the bag does not define" in raw.said


def test_a_bag_of_undefined_types_alone_is_refused_by_that(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"run: /controller/state cannot be read, since the bag has no definition"):
        read_bag(write_as_humble(tmp_path / "run", joint_states=False), ("joint_a", "joint_b"))


def test_what_is_no_bag_is_refused(tmp_path: Path) -> None:
    (tmp_path / "run.bag").write_bytes(b"no bag")
    with pytest.raises(ScenarioError, match=r"run.bag: damaged, or not a ROS bag"):
        read_bag(tmp_path / "run.bag", ("joint_a", "joint_b"))


def several(place: Path, messages: list[tuple[str, list[str], np.ndarray]]) -> Path:
    """A ROS 2 bag of joint states of several topics, 2 ms between the messages of each round."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    types: Any = store.types
    with Writer(place, version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        topics: dict[str, Any] = {}
        for index, (topic, names, row) in enumerate(messages):
            if topic not in topics:
                topics[topic] = bag.add_connection(topic, JOINT_STATE, typestore=store)
            stamp = types["builtin_interfaces/msg/Time"](sec=5, nanosec=index * 1_000_000)
            header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="")
            message = types[JOINT_STATE](
                header=header, name=names, position=row, velocity=np.zeros(0), effort=np.zeros(0)
            )
            bag.write(topics[topic], 5_000_000_000 + index * 1_000_000, store.serialize_cdr(message, JOINT_STATE))
    return place


@pytest.mark.parametrize("gripper", ["/gripper/joint_states", "/joint_states"])
def test_the_messages_that_hold_the_arm_s_joints(tmp_path: Path, gripper: str) -> None:
    """A gripper's topic comes first, or it speaks on the arm's; one message is empty."""
    rows = [
        message
        for row in POSITION
        for message in ((gripper, ["finger"], np.array([0.01])), ("/joint_states", NAMES, row))
    ]
    rows.insert(7, ("/joint_states", [], np.zeros(0)))
    raw = read_bag(several(tmp_path / "run", rows), ("joint_a", "joint_b"))
    found = log_of_joints(raw, ("joint_a", "joint_b"))
    assert found.position == pytest.approx(POSITION[:, ::-1])
    assert "topic /joint_states, time from headers" in found.read
    left_out = 1 if gripper.startswith("/gripper") else 41
    assert f"{left_out} messages without these joints left out" in found.read


def test_a_message_that_is_not_a_number_is_left_out(tmp_path: Path) -> None:
    position = POSITION.copy()
    position[11] = np.nan
    raw = read_bag(several(tmp_path / "run", [("/js", NAMES, row) for row in position]), ("joint_a", "joint_b"))
    found = log_of_joints(raw, ("joint_a", "joint_b"))
    assert len(found.t) == 39 and "1 rows without a number left out" in found.read
    assert found.position == pytest.approx(np.delete(POSITION, 11, axis=0)[:, ::-1])


def test_a_topic_is_chosen_by_its_name(tmp_path: Path) -> None:
    rows = [m for row in POSITION for m in (("/left", NAMES, row), ("/right", NAMES, row + 1.0))]
    place = several(tmp_path / "run", rows)
    found = log_of_joints(read_bag(place, ("joint_a", "joint_b"), "/right"), ("joint_a", "joint_b"))
    assert found.position == pytest.approx(POSITION[:, ::-1] + 1.0)
    either = log_of_joints(read_bag(place, ("joint_a", "joint_b")), ("joint_a", "joint_b"))
    assert "/right not read (--topic)" in either.read or "/left not read (--topic)" in either.read
    with pytest.raises(ScenarioError, match=r"--topic /up: .* has no such topic of joints; choose /left or /right"):
        read_bag(place, ("joint_a", "joint_b"), "/up")


def test_our_own_bag_is_a_command_and_said_to_be_one(tmp_path: Path) -> None:
    """Recorded beside what the joints did, it is passed over."""
    place = tmp_path / "command"
    t, rest = np.linspace(0.0, 1.0, 51), np.zeros((51, 6))
    EXPORTERS["rosbag2"].write(JointSamples(t, rest, rest, rest), arm(6), place)
    with pytest.raises(ScenarioError) as caught:
        read_bag(place, arm(6).robot.joints)
    text = str(caught.value)
    assert "is a trajectory_msgs/msg/JointTrajectory, a command and no log of what the joints did" in text
    assert f"nospill judge {place}" in text and "record sensor_msgs/msg/JointState" in text
