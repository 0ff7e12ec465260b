"""Every format in the table: what is written is what is read, with names and units, and nothing else is accepted."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from ruamel.yaml import YAML
from scipy.io import loadmat, savemat
from scipy.spatial.transform import Rotation

from nospill.errors import NospillError, PlanFolderError, ScenarioError
from nospill.export import EXPORTERS
from nospill.export.base import number
from nospill.export.message import MESSAGE_TYPE, UNITS
from nospill.motion.interpolation import INTERPOLATIONS, JointSamples
from nospill.motion.resampling import resampled

FORMATS = pytest.mark.parametrize("name", sorted(EXPORTERS))
RECORDING = ("csv", "joint-trajectory", "action-goal", "rosbag2", "mat")
"""Formats that keep every column to the last bit, for any number of joints."""
SPELLINGS = [(exporter.name, suffix) for exporter in EXPORTERS.values() for suffix in exporter.suffixes]
PRECISION = {"lab-csv": 0.51e-12, "urscript": 0.51e-12, "tray-csv": 1e-10}


def arm(joints: int) -> Any:
    names = tuple(f"axis_{index}" for index in range(joints))
    robot = SimpleNamespace(name="arm", joints=names)
    return SimpleNamespace(name="task", output_rate=500.0, controller=None, robot=robot)


@pytest.fixture(scope="module")
def planned(gentle_plan) -> tuple[Any, JointSamples]:
    """A real scene, whose arm has the name of one that reads URScript, and a motion that inverse kinematics follow."""
    plan = gentle_plan("matrix-rigid", 1)
    whole = resampled(plan.trajectory, 500.0)
    scene = replace(plan.scene, robot=replace(plan.scene.robot, name="ur10e"))
    return scene, JointSamples(
        *(getattr(whole, field.name)[:200] for field in fields(whole) if field.name != "in_motion")
    )


@pytest.fixture
def written(planned, tmp_path: Path) -> Callable[[str, str], Path]:
    def write(name: str, suffix: str) -> Path:
        scene, samples = planned
        path = tmp_path / f"motion{suffix}"
        EXPORTERS[name].write(samples, scene, path)
        return path

    return write


def text_in(path: Path) -> str:
    """All that a human or a program can read in a file or folder."""
    files = sorted(path.iterdir()) if path.is_dir() else [path]
    if path.suffix == ".mat":
        return str(loadmat(path, simplify_cells=True))
    return "".join(file.read_bytes().decode("latin-1") for file in files)


# --- the contract -----------------------------------------------------------------------------------------------------


@FORMATS
def test_entries_of_the_table(name):
    exporter = EXPORTERS[name]
    assert exporter.name == name
    assert exporter.suffixes and all(suffix.startswith(".") for suffix in exporter.suffixes)
    assert exporter.interpolation is INTERPOLATIONS[exporter.interpolation.name]
    for text in (exporter.title, exporter.receiver):
        assert text and "\n" not in text


def test_suffixes_tell_the_formats_apart():
    usual = [exporter.suffixes[0] for exporter in EXPORTERS.values()]
    assert len(set(usual)) == len(usual)


@pytest.mark.parametrize(("name", "suffix"), SPELLINGS)
def test_what_is_written_is_read(planned, written, name, suffix):
    scene, samples = planned
    back = EXPORTERS[name].read(written(name, suffix), scene)
    np.testing.assert_array_equal(back.t, samples.t)
    np.testing.assert_allclose(back.position, samples.position, atol=PRECISION.get(name, 0.0), rtol=0.0)
    if name in RECORDING:
        np.testing.assert_array_equal(back.speed, samples.speed)
        np.testing.assert_array_equal(back.acceleration, samples.acceleration)
    else:
        assert back.speed is None and back.acceleration is None, "such a receiver sees positions alone"


@pytest.mark.parametrize(("name", "suffix"), [pair for pair in SPELLINGS if pair[0] != "lab-csv"])
def test_names_and_units_are_in_the_file(planned, written, name, suffix):
    scene, _ = planned
    text = text_in(written(name, suffix))
    for joint in scene.robot.joints:
        assert joint in text
    assert "rad" in text
    if name in RECORDING:
        assert "rad/s" in text and "rad/s^2" in text
    assert scene.robot.name in text


@pytest.mark.parametrize(("name", "suffix"), [pair for pair in SPELLINGS if pair[0] != "lab-csv"])
def test_a_file_for_other_joints_is_refused(planned, written, name, suffix):
    scene, _ = planned
    for joints in (scene.robot.joints[::-1], (*scene.robot.joints[:-1], "elbow")):
        other = replace(scene, robot=replace(scene.robot, joints=joints))
        with pytest.raises(PlanFolderError, match=r"its joints are joint_1, .*; those of the robot are"):
            EXPORTERS[name].read(written(name, suffix), other)


@FORMATS
@pytest.mark.parametrize("joints", [1, 6, 7])
def test_how_many_joints(samples, tmp_path, name, joints):
    exporter, scene, path = EXPORTERS[name], arm(joints), tmp_path / f"a{EXPORTERS[name].suffixes[0]}"
    reason = exporter.reason_against(scene, 500.0)
    if name in RECORDING:
        assert reason is None
        motion = samples(joints=joints)
        exporter.write(motion, scene, path)
        for field in fields(motion):
            np.testing.assert_array_equal(getattr(exporter.read(path, scene), field.name), getattr(motion, field.name))
    elif joints == 7:
        assert reason and "7 joints" in reason
        with pytest.raises(ScenarioError, match="7 joints"):
            exporter.write(samples(joints=7), scene, path)
        assert not path.exists()


@FORMATS
def test_writing_again_replaces_and_leaves_nothing_else(planned, tmp_path, name):
    (scene, samples), exporter = planned, EXPORTERS[name]
    path = tmp_path / f"motion{exporter.suffixes[0]}"
    for position in (samples.position, samples.position + 1e-3):
        exporter.write(replace(samples, position=position), scene, path)
        np.testing.assert_allclose(exporter.read(path, scene).position, position, atol=1e-10)
    assert list(tmp_path.iterdir()) == [path]


@FORMATS
def test_a_place_that_cannot_be_written(planned, tmp_path, name):
    (scene, samples), exporter = planned, EXPORTERS[name]
    (tmp_path / "file").write_text("no folder")
    with pytest.raises(PlanFolderError, match="cannot write") as caught:
        exporter.write(samples, scene, tmp_path / "file" / f"a{exporter.suffixes[0]}")
    assert "\n" not in str(caught.value)
    assert (tmp_path / "file").read_text() == "no folder"


@pytest.mark.parametrize("name", RECORDING)
def test_positions_alone_are_not_enough(samples, tmp_path, name):
    bare = JointSamples(samples().t, samples().position)
    with pytest.raises(PlanFolderError, match="needs speeds and accelerations"):
        EXPORTERS[name].write(bare, arm(6), tmp_path / f"a{EXPORTERS[name].suffixes[0]}")


finite = st.floats(allow_nan=False, allow_infinity=False, width=64)


@settings(deadline=None, max_examples=25)
@given(columns=hnp.arrays(float, st.tuples(st.just(3), st.integers(2, 4), st.integers(1, 8)), elements=finite))
@pytest.mark.parametrize("suffix", [".yaml", ".json", ".mat"])
def test_any_numbers_come_back_to_the_last_bit(tmp_path_factory, suffix, columns):
    exporter = EXPORTERS["mat" if suffix == ".mat" else "joint-trajectory"]
    path, scene = tmp_path_factory.mktemp("numbers") / f"a{suffix}", arm(columns.shape[2])
    motion = JointSamples(np.arange(columns.shape[1]) / 500, *columns)
    exporter.write(motion, scene, path)
    back = exporter.read(path, scene)
    for field in fields(motion):
        np.testing.assert_array_equal(getattr(back, field.name), getattr(motion, field.name))


@given(finite)
def test_a_number_is_one_to_every_parser(value):
    text = number(value)
    assert float(text) == value
    for parsed in (json.loads(text), yaml.safe_load(text), YAML(typ="safe").load(text)):
        assert type(parsed) is float and parsed == value
    assert math.copysign(1.0, float(number(-0.0))) == 1.0


# --- the message of ROS -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("parse", [yaml.safe_load, lambda text: YAML(typ="safe").load(text)], ids=["1.1", "1.2"])
def test_yaml_is_the_message_of_json(written, parse):
    from_yaml = parse(written("joint-trajectory", ".yaml").read_text())
    from_json = json.loads(written("joint-trajectory", ".json").read_text())
    assert from_yaml == from_json["msg"]
    assert from_json["type"] == MESSAGE_TYPE
    assert from_json["units"] == UNITS


def test_fields_are_those_of_the_message_definition(samples, tmp_path):
    """What `ros2 topic pub` does: every key must be a field, every value of the field's type."""
    from rosbags.typesys import Stores, get_typestore

    types: Any = get_typestore(Stores.ROS2_JAZZY).types
    EXPORTERS["joint-trajectory"].write(samples(), arm(6), tmp_path / "a.yaml")
    message = yaml.safe_load((tmp_path / "a.yaml").read_text())

    def names(kind: str) -> set[str]:
        return {field.name for field in fields(types[kind])} - {"__msgtype__"}

    assert set(message) == names(MESSAGE_TYPE)
    assert set(message["header"]) == names("std_msgs/msg/Header")
    for point in message["points"]:
        assert set(point) == names("trajectory_msgs/msg/JointTrajectoryPoint") - {"effort"}
        assert set(point["time_from_start"]) == names("builtin_interfaces/msg/Duration")
        assert all(type(value) is float for value in point["positions"])
    assert message["points"][-1]["velocities"] == [0.0] * 6, "the controller refuses anything else"


@pytest.mark.oracle
def test_bag_as_the_library_reads_it(planned, written):
    from rosbags.highlevel import AnyReader

    scene, samples = planned
    path = written("rosbag2", ".rosbag2")
    assert sorted(file.name for file in path.iterdir()) == ["metadata.yaml", "motion.rosbag2.mcap"]
    with AnyReader([path]) as bag:
        (connection,) = bag.connections
        assert (connection.topic, connection.msgtype) == ("/joint_trajectory_controller/joint_trajectory", MESSAGE_TYPE)
        ((_, _, data),) = bag.messages()
        message: Any = bag.deserialize(data, connection.msgtype)
    assert tuple(message.joint_names) == scene.robot.joints
    stamps = [point.time_from_start.sec + 1e-9 * point.time_from_start.nanosec for point in message.points]
    np.testing.assert_allclose(stamps, samples.t, atol=1e-12)
    np.testing.assert_array_equal([point.accelerations for point in message.points], samples.acceleration)
    custom = yaml.safe_load((path / "metadata.yaml").read_text())["rosbag2_bagfile_information"]["custom_data"]
    assert json.loads(custom["nospill"])["units"] == UNITS


# --- poses of the tray ------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_tray_poses_are_those_of_the_plan(gentle_plan, tmp_path):
    plan, path = gentle_plan("mixed-tray", 1), tmp_path / "a.csv"
    EXPORTERS["tray-csv"].write(resampled(plan.trajectory, 500.0), plan.scene, path)
    table = np.loadtxt(path, delimiter=";", skiprows=4)
    assert path.read_text().splitlines()[3] == "t;x;y;z;qx;qy;qz;qw"
    np.testing.assert_allclose(table[:, 0], plan.trajectory.t, atol=1e-9)
    np.testing.assert_allclose(table[:, 1:4], plan.trajectory.tray_position, atol=1e-6)
    turn = Rotation.from_quat(table[:, 4:]).inv() * Rotation.from_quat(plan.trajectory.tray_quaternion)
    assert np.max(turn.magnitude()) < 1e-6
    assert np.all(np.sum(table[1:, 4:] * table[:-1, 4:], axis=1) > 0.99), "neighbours on one side"


def test_branch_of_the_start_is_the_one_that_is_read(planned, written):
    """Another start configuration with the same pose leads to other joints, or to none: never silently to ours."""
    scene, samples = planned
    path = written("tray-csv", ".tray.csv")
    text = path.read_text()
    flipped = samples.position[0] + (0, 0, 0, np.pi, 0, -np.pi)
    flipped[4] *= -1.0
    wanted = "; ".join(f"{name} = {value!r}" for name, value in zip(scene.robot.joints, flipped.tolist(), strict=True))
    lines = [f"# joints at the first row, rad: {wanted}" if "first row" in line else line for line in text.splitlines()]
    path.write_text("\n".join(lines))
    back = EXPORTERS["tray-csv"].read(path, scene)
    np.testing.assert_allclose(back.position[0], flipped, atol=1e-9)
    assert np.max(np.abs(back.position - samples.position)) > 1.0


# --- what is not accepted ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "suffix", "old", "new", "message"),
    [
        ("joint-trajectory", ".yaml", "joint_names:", "names:", "joint_names or points are missing"),
        ("joint-trajectory", ".yaml", '"positions": [', '"positions": [0.0, ', r"point 1, positions: .* row of 6"),
        ("joint-trajectory", ".yaml", '"velocities": [', '"velocities": ["0", ', "velocities: .* list of numbers"),
        ("joint-trajectory", ".yaml", '"accelerations"', '"efforts"', "point 1, accelerations: None"),
        ("joint-trajectory", ".yaml", '"nanosec": 2000000', '"nanosec": 0', r"time does not increase after sample 1"),
        ("joint-trajectory", ".yaml", '"nanosec": 2000000', '"nanosec": 2e6', "whole sec and nanosec"),
        ("joint-trajectory", ".yaml", "points:", "points: 5", r"line 7: .* is not a line of a trajectory"),
        ("joint-trajectory", ".yaml", "- {", "- {{", r"line 7: .* is not a line of a trajectory"),
        ("joint-trajectory", ".json", '"msg"', '"message"', "joint_names or points are missing"),
        ("joint-trajectory", ".json", "[0.0, ", "[NaN, ", "is not a row of 6 finite numbers"),
        ("joint-trajectory", ".json", "[0.0, ", f"[1{400 * '0'}, ", "is not a row of 6 finite numbers"),
        ("joint-trajectory", ".json", "}", "", "not a JSON file"),
        ("urscript", ".script", "stopj(2.0)", "movej(start)", r"'movej\(start\)' is not what nospill wrote there"),
        ("urscript", ".script", "  i = 0\n", "", "is not what nospill wrote there"),
        ("urscript", ".script", ", 0, 0, 0.002, 0.03, 300)", ", 0, 0, 0.004, 0.03, 300)", "0.004 s or changes"),
        ("urscript", ".script", ", 0, 0, 0.002, 0.03, 300)", ", 0, 0, 0.002, 0.3, 300)", "lookahead_time is 0.3"),
        ("urscript", ".script", ", 0, 0, 0.002, 0.03, 300)", ", 0, 0, 0.002, 0.03, 30)", "gain is 30"),
        ("urscript", ".script", "servoj([", "servoj([0, ", "is not a row of 6 finite numbers"),
        ("urscript", ".script", "# joints: ", "# ", "its joints are None"),
        (
            "tray-csv",
            ".tray.csv",
            "t;x;y;z;qx;qy;qz;qw",
            "x;y;z;qx;qy;qz;qw",
            "the line t;x;y;z;qx;qy;qz;qw is missing",
        ),
        ("tray-csv", ".tray.csv", "\n0.002;", "\n0.002;0;", "line 6: .* row of 8 finite numbers"),
        ("tray-csv", ".tray.csv", "\n0.002;", "\n0.002;1", "(does not reach|have to jump to) this pose"),
        ("tray-csv", ".tray.csv", "joint_1 = ", "joint_1 = x", "joints at the first row: .* finite numbers"),
        ("tray-csv", ".tray.csv", "\n0.0;", "\n0.5;", "time starts at 0.5 s"),
        ("tray-csv", ".tray.csv", "\n0.002;", "\n0.0;", "time does not increase after sample 1"),
    ],
)
def test_damaged_text_is_named(planned, written, name, suffix, old, new, message):
    path = written(name, suffix)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(PlanFolderError, match=message) as caught:
        EXPORTERS[name].read(path, planned[0])
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_a_quaternion_of_another_length_is_named(planned, written):
    path = written("tray-csv", ".tray.csv")
    lines = path.read_text().splitlines()
    cells = lines[9].split(";")
    lines[9] = ";".join([*cells[:4], *(str(1.001 * float(cell)) for cell in cells[4:])])
    path.write_text("\n".join(lines))
    with pytest.raises(PlanFolderError, match=r"line 10: the quaternion has length 1\.001, 1 is needed"):
        EXPORTERS["tray-csv"].read(path, planned[0])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"qd": None}, "the variable qd is missing"),
        ({"q": np.zeros((3, 6))}, r"q: an array of shape \(3, 6\)"),
        ({"t": np.full(40, np.nan)}, "t: an array of shape"),
        ({"qdd": np.full((40, 6), "x")}, "qdd: an array of shape"),
        ({"units": {"t": "s", "q": "deg", "qd": "deg/s", "qdd": "deg/s^2"}}, "its units are"),
    ],
)
def test_other_matlab_files_are_named(samples, tmp_path, change, message):
    path, scene = tmp_path / "a.mat", arm(6)
    EXPORTERS["mat"].write(samples(), scene, path)
    found = {key: value for key, value in loadmat(path, simplify_cells=True).items() if not key.startswith("__")}
    savemat(path, {key: value for key, value in (found | change).items() if value is not None})
    with pytest.raises(PlanFolderError, match=message):
        EXPORTERS["mat"].read(path, scene)


def test_a_bag_without_the_message_is_named(tmp_path):
    from rosbags.rosbag2 import StoragePlugin, Writer

    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP):
        pass
    with pytest.raises(PlanFolderError, match="holds 0 messages"):
        EXPORTERS["rosbag2"].read(tmp_path / "bag", arm(6))


def test_a_folder_that_is_no_bag_is_not_replaced(samples, tmp_path):
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "thesis.txt").write_text("years of work")
    with pytest.raises(PlanFolderError, match="holds files that nospill did not write"):
        EXPORTERS["rosbag2"].write(samples(), arm(6), tmp_path / "bag")
    assert (tmp_path / "bag" / "thesis.txt").exists()


@pytest.mark.parametrize(("name", "suffix"), SPELLINGS)
@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00\x01", b"{}", b"[1, 2]", b"hello: 5\n", b"- 3\n"])
def test_other_files_are_refused(planned, tmp_path, name, suffix, content):
    path = tmp_path / f"a{suffix}"
    if name == "rosbag2":
        path.mkdir()
        (path / "metadata.yaml").write_bytes(content)
    else:
        path.write_bytes(content)
    with pytest.raises(PlanFolderError) as caught:
        EXPORTERS[name].read(path, planned[0])
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.slow
@settings(deadline=None, max_examples=60)
@given(data=st.data())
@pytest.mark.parametrize(
    ("name", "suffix"),
    # ".yml" is ".yaml"; scipy's reader of ".mat", in C, ends the process on some broken bytes (1.17, read_var_array)
    [pair for pair in SPELLINGS if pair[0] in RECORDING and pair[1] not in (".yml", ".mat")],
)
def test_broken_bytes_never_let_a_foreign_error_out(tmp_path_factory, name, suffix, data):
    exporter, scene, path = EXPORTERS[name], arm(2), tmp_path_factory.mktemp("broken") / f"a{suffix}"
    t = np.arange(3) / 500
    exporter.write(JointSamples(t, *(np.ones((3, 2)) * scale for scale in (1, 2, 3))), scene, path)
    file = data.draw(st.sampled_from(sorted(path.iterdir()))) if path.is_dir() else path
    content = bytearray(file.read_bytes())
    place = data.draw(st.integers(0, len(content) - 1))
    if data.draw(st.booleans()):
        content[place] = data.draw(st.integers(0, 255))
    else:
        content = content[:place]
    file.write_bytes(bytes(content))
    try:
        back = exporter.read(path, scene)
    except NospillError as error:
        assert "\n" not in str(error)
    else:
        assert np.all(np.isfinite(back.position)) and np.all(np.diff(back.t) > 0.0)


def test_without_the_library_the_bag_says_which_extra(monkeypatch, samples, tmp_path):
    monkeypatch.setitem(__import__("sys").modules, "rosbags.typesys", None)
    with pytest.raises(NospillError, match=r"nospill\[ros\]"):
        EXPORTERS["rosbag2"].write(samples(), arm(6), tmp_path / "bag")
    assert not (tmp_path / "bag").exists()


def test_spelling_of_a_joint_trajectory_follows_its_name(samples, tmp_path):
    with pytest.raises(ScenarioError, match=r"written as \.yaml, \.yml or \.json"):
        EXPORTERS["joint-trajectory"].write(samples(), arm(6), tmp_path / "a.txt")
