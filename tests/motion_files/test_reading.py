"""Motion files of others: what is read is what they hold, in the robot's joints, or the sentence says why not."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from nospill.errors import NospillError, ScenarioError
from nospill.export import EXPORTERS
from nospill.motion.resampling import resampled
from nospill.motion_files.reading import read_motion
from nospill.plans.plan import Plan
from nospill.scenario import read_scenario
from nospill.scene.scene import Scene

JOINTS = ["elbow_joint", "shoulder_pan_joint", "shoulder_lift_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
"""As joint_states of this arm list them: in the order of the alphabet."""


@pytest.fixture(scope="module")
def scene() -> Scene:
    return read_scenario("coffee-to-go")


def points(scene: Scene, count: int = 12, *, joints: list[str] | None = None, speeds: bool = True) -> dict[str, Any]:
    """A slow quintic of 0.1 rad from the home of the path, as a message whose joints come in another order."""
    names = joints or JOINTS
    u = np.linspace(0.0, 1.0, count)
    way, rate = 10 * u**3 - 15 * u**4 + 6 * u**5, (30 * u**2 - 60 * u**3 + 30 * u**4) / 2.0
    rows = []
    for time, value, speed in zip((2.0 * u).tolist(), way.tolist(), rate.tolist(), strict=True):
        q = {name: -0.5 + 0.1 * value * (index + 1) for index, name in enumerate(scene.robot.joints)}
        v = {name: 0.1 * speed * (index + 1) for index, name in enumerate(scene.robot.joints)}
        sec = int(time)
        row: dict[str, Any] = {
            "positions": [q.get(name, 0.02) for name in names],
            "time_from_start": {"sec": sec, "nanosec": round((time - sec) * 1e9)},
        }
        rows.append(row | ({"velocities": [v.get(name, 0.0) for name in names]} if speeds else {}))
    return {"joint_names": names, "points": rows}


def written(place: Path, table: Any) -> Path:
    text = json.dumps(table) if place.suffix == ".json" else yaml.safe_dump(table)
    place.write_text(text, encoding="utf-8")
    return place


def as_expected(scene: Scene, table: dict[str, Any], name: str) -> np.ndarray:
    order = [table["joint_names"].index(joint) for joint in scene.robot.joints]
    return np.array([point[name] for point in table["points"]])[:, order]


@pytest.mark.parametrize(
    "wrapped",
    [
        lambda table: table,
        lambda table: {"header": {"stamp": {"sec": 0, "nanosec": 0}}, **table},
        lambda table: {"joint_trajectory": table, "multi_dof_joint_trajectory": {"joint_names": [], "points": []}},
        lambda table: {"model_id": "arm", "trajectory": [{"joint_trajectory": table}]},
        lambda table: {"goal": {"trajectory": table, "goal_time_tolerance": {"sec": 0, "nanosec": 0}}},
        lambda table: {"type": "trajectory_msgs/msg/JointTrajectory", "msg": table},
    ],
    ids=["bare", "with header", "MoveIt", "MoveIt display", "goal", "nospill"],
)
@pytest.mark.parametrize("suffix", [".yaml", ".json"])
def test_messages_at_any_depth(wrapped, suffix: str, scene: Scene, tmp_path: Path) -> None:
    table = points(scene, joints=[*JOINTS, "gripper"])
    found = read_motion(written(tmp_path / f"motion{suffix}", wrapped(table)), scene)
    np.testing.assert_array_equal(found.samples.position, as_expected(scene, table, "positions"))
    assert found.samples.speed is not None and found.samples.acceleration is None
    np.testing.assert_array_equal(found.samples.speed, as_expected(scene, table, "velocities"))
    assert found.samples.t[-1] == pytest.approx(2.0, abs=1e-9)
    assert found.read == (
        "12 points over 2.000 s, positions and speeds, joints by name, time from time_from_start; left out: gripper"
    )


def test_echo_of_ros2_has_a_line_of_hyphens_behind_each_message(scene: Scene, tmp_path: Path) -> None:
    place = tmp_path / "echo.yaml"
    place.write_text(yaml.safe_dump(points(scene)) + "---\n", encoding="utf-8")
    assert len(read_motion(place, scene).samples.t) == 12
    place.write_text(2 * (yaml.safe_dump(points(scene)) + "---\n"), encoding="utf-8")
    with pytest.raises(ScenarioError, match="it holds 2 of them"):
        read_motion(place, scene)


@pytest.mark.parametrize("stamps", [("secs", "nsecs"), None], ids=["ROS 1", "seconds"])
def test_durations_of_others(stamps, scene: Scene, tmp_path: Path) -> None:
    table = points(scene)
    for point in table["points"]:
        both = point["time_from_start"]
        plain = both["sec"] + 1e-9 * both["nanosec"]
        point["time_from_start"] = dict(zip(stamps, both.values(), strict=True)) if stamps else plain
    found = read_motion(written(tmp_path / "motion.yaml", table), scene)
    np.testing.assert_allclose(found.samples.t, np.linspace(0.0, 2.0, 12), atol=1e-9)


def test_namespaces_before_joint_names(scene: Scene, tmp_path: Path) -> None:
    table = points(scene)
    table["joint_names"] = [f"left/{name}" for name in table["joint_names"]]
    np.testing.assert_array_equal(
        read_motion(written(tmp_path / "motion.yaml", table), scene).samples.position,
        as_expected(scene, points(scene), "positions"),
    )


def test_arrays_by_name_of_numpy_and_json(scene: Scene, tmp_path: Path) -> None:
    table = points(scene)
    q, v = (as_expected(scene, table, name) for name in ("positions", "velocities"))
    t = np.linspace(0.0, 2.0, 12)
    np.savez(tmp_path / "toppra.npz", ts=t, qs=q, qds=v)
    np.savez(tmp_path / "batch.npz", position=q[None], velocity=v[None], interpolation_dt=2.0 / 11.0)
    listed = {"joint_names": list(scene.robot.joints), "dt": 2.0 / 11.0, "position": q.tolist(), "velocity": v.tolist()}
    (tmp_path / "dump.json").write_text(json.dumps(listed), encoding="utf-8")
    said = {
        "toppra.npz": "time from ts",
        "batch.npz": "time from interpolation_dt = 0.181818 s",
        "dump.json": "by name",
    }
    for name, words in said.items():
        found = read_motion(tmp_path / name, scene)
        np.testing.assert_allclose(found.samples.t, t, atol=1e-12)
        np.testing.assert_array_equal(found.samples.position, q)
        np.testing.assert_array_equal(found.samples.speed, v)
        assert words in found.read


@pytest.mark.parametrize("name", [name for name in EXPORTERS if name not in ("tray-csv", "urscript")])
def test_every_exporter_s_file_is_read(name: str, gentle_plan, tmp_path: Path) -> None:
    plan: Plan = gentle_plan("matrix-liquid", cargo=1)
    samples = resampled(plan.trajectory, 500.0)
    for suffix in EXPORTERS[name].suffixes:
        EXPORTERS[name].write(samples, plan.scene, tmp_path / f"motion{suffix}")
        found = read_motion(tmp_path / f"motion{suffix}", plan.scene)
        np.testing.assert_allclose(found.samples.position, samples.position, atol=1e-11)
        np.testing.assert_allclose(found.samples.t, samples.t, atol=1e-9)


def changed(scene: Scene, **values: Any) -> dict[str, Any]:
    return points(scene) | values


def broken(scene: Scene, row: int, **values: Any) -> dict[str, Any]:
    table = points(scene)
    table["points"][row] |= values
    return table


BAD: dict[str, tuple[Any, str]] = {
    "joints of another arm": (
        lambda scene: changed(scene, joint_names=[f"joint_{number}" for number in range(6)]),
        '"shoulder_pan_joint", .* and "wrist_3_joint" of the robot.* not among them: this is the motion of another arm',
    ),
    "two joints of one name": (lambda scene: changed(scene, joint_names=["elbow_joint"] * 6), "6 joint names"),
    "one point": (lambda scene: changed(scene, points=points(scene)["points"][:1]), "1 points; at least 2"),
    "no points": (lambda scene: changed(scene, points=[]), "it holds none with points"),
    "a row too short": (lambda scene: broken(scene, 3, positions=[0.0]), "point 4, positions: .0.0. is no list of 6"),
    "no number": (lambda scene: broken(scene, 3, positions=[float("nan")] * 6), "positions of point 4 hold a value"),
    "text": (lambda scene: broken(scene, 3, positions=["a"] * 6), "point 4, positions"),
    "no time": (lambda scene: broken(scene, 3, time_from_start=None), "point 4: time_from_start is None"),
    "times backwards": (
        lambda scene: broken(scene, 3, time_from_start={"sec": 0, "nanosec": 0}),
        "time does not increase from point 3 .* to 4",
    ),
    "speeds of some": (lambda scene: broken(scene, 3, velocities=[]), "11 of 12 points have velocities"),
    "it begins in motion": (
        lambda scene: broken(scene, 0, velocities=[0.2] + [0.0] * 5),
        "begins at 0.2 rad/s of elbow",
    ),
    "it ends in motion": (
        lambda scene: broken(scene, -1, velocities=[0.0] * 5 + [0.3]),
        "ends at 0.3 rad/s of wrist_3",
    ),
    "degrees": (
        lambda scene: changed(
            scene,
            points=[
                point | {"positions": [np.degrees(value).item() for value in point["positions"]]}
                for point in points(scene)["points"]
            ],
        ),
        "positions look like degrees",
    ),
    "another configuration": (
        lambda scene: broken(scene, 6, positions=[2.4] * 6),
        "jumps by .* another configuration of the arm",
    ),
    "whole turns": (
        lambda scene: broken(
            scene,
            6,
            positions=[
                value + 2 * math.pi * (row == 5) for row, value in enumerate(points(scene)["points"][6]["positions"])
            ],
        ),
        "wrist_3_joint jumps by 6.* off by whole turns",
    ),
    "milliseconds": (
        lambda scene: changed(
            scene,
            points=[point | {"time_from_start": 1000.0 * row} for row, point in enumerate(points(scene)["points"])],
        ),
        "times look like milliseconds",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_no_motion_of_this_arm(name: str, scene: Scene, tmp_path: Path) -> None:
    table, says = BAD[name]
    with pytest.raises(ScenarioError, match=says) as caught:
        read_motion(written(tmp_path / "motion.yaml", table(scene)), scene)
    assert "\n" not in str(caught.value) and "motion.yaml" in str(caught.value)


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("none.yaml", None, "no such file"),
        ("text.yaml", "points: [", "is not YAML"),
        ("text.json", "{", "is not JSON"),
        ("list.yaml", "- 1\n- 2\n", "it holds none with points"),
        ("arrays.json", '{"position": [[0,0,0,0,0,0]]}', "has no time for every point"),
        (
            "arrays.json",
            '{"position": [[0,0],[0,0]], "dt": 0.1}',
            "2 columns without names where the robot has 6",
        ),
        ("arrays.json", '{"position": [[0,0],[0]], "dt": 0.1}', "is no table of numbers"),
        ("arrays.json", '{"position": [[0,0,0,0,0,0]], "dt": -1}', "one step above 0 s"),
        ("arrays.npz", "no archive", "no archive of NumPy arrays"),
    ],
)
def test_files_that_are_none(name: str, content: str | None, says: str, scene: Scene, tmp_path: Path) -> None:
    place = tmp_path / name
    if content is not None:
        place.write_text(content, encoding="utf-8")
    with pytest.raises(ScenarioError, match=says):
        read_motion(place, scene)


@given(data=st.data())
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_mutated_files_are_read_or_refused_in_one_sentence(data: st.DataObject, scene: Scene, tmp_path: Path) -> None:
    text = yaml.safe_dump(points(scene, 4))
    for _ in range(data.draw(st.integers(1, 3))):
        first = data.draw(st.integers(0, len(text)))
        last = data.draw(st.integers(first, min(first + 40, len(text))))
        text = text[:first] + data.draw(st.text(max_size=8)) + text[last:]
    place = tmp_path / "motion.yaml"
    place.write_text(text, encoding="utf-8", errors="replace")
    try:
        found = read_motion(place, scene)
    except NospillError as error:
        assert "\n" not in str(error)
    else:
        assert np.all(np.isfinite(found.samples.position)) and np.all(np.diff(found.samples.t) > 0.0)
