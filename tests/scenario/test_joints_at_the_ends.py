"""Joints in the place of start and goal: where the tray is then, which way leads there, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.path_search.level_arm import LevelArm
from nospill.path_search.sampled_paths import concatenate, sample_path
from nospill.robots.joint_paths.search import joint_paths, try_joint_paths
from nospill.robots.kinematics.forward import kinematics
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene

UR10E = np.radians([-45.0, -51.0, 99.0, -138.0, 90.0, -45.0])
START: dict[str, Any] = {"position": [0.75, -0.5, 0.45]}
GOAL: dict[str, Any] = {"position": [0.75, 0.5, 0.45]}


def scene_of(
    start: object,
    goal: object,
    *,
    example: str = "cups-around-a-column",
    obstacles: bool = False,
    robot: dict[str, object] | None = None,
) -> Scene:
    table: dict[str, Any] = read_scenario(example).source
    table = {key: value for key, value in table.items() if obstacles or key != "obstacle"}
    table["robot"] = {**table["robot"], **(robot or {})}
    return scene_from_table({**table, "path": {"type": "free", "start": start, "goal": goal}}, name="joints")


def on_the_line(example: str = "cups-around-a-column") -> tuple[Scene, np.ndarray]:
    """A scene with places at its ends, and its best joint path."""
    table = read_scenario(example).source
    ends = (START, GOAL) if "column" in example else (table["path"]["start"], table["path"]["goal"])  # type: ignore[index,call-overload]
    scene = scene_of(*ends, example=example)
    return scene, joint_paths(scene.robot, scene.path, tool=scene.tray.tool)[0].q


def test_the_tray_is_where_the_joints_hold_it() -> None:
    scene = scene_of({"joints": [f"{angle} deg" for angle in np.degrees(UR10E)]}, GOAL)
    position, rotation = kinematics(scene.robot).poses(UR10E[None], tool=scene.tray.tool)
    x, y, z, yaw = scene.path.at(0.0)[0]
    np.testing.assert_allclose([x, y, z], position[0], atol=1e-9)
    assert yaw == pytest.approx(np.arctan2(rotation[0, 1, 0], rotation[0, 0, 0]), abs=1e-9)
    start, goal = scene.path.ends
    assert start is not None and goal is None and scene.path.notes == ()
    np.testing.assert_allclose(start, UR10E, atol=1e-9)


def test_a_slight_lean_is_taken_out_and_told() -> None:
    scene = scene_of({"joints": np.add(UR10E, [0, 0, 0, np.radians(0.3), 0, 0]).tolist()}, GOAL)
    (note,), (start, _) = scene.path.notes, scene.path.ends
    assert start is not None
    assert note.startswith("start: the tray leans 0.3 deg in the stated joints; level, they are up to 0.")
    rotation = kinematics(scene.robot).poses(start[None], tool=scene.tray.tool)[1]
    np.testing.assert_allclose(rotation[0, :, 2], [0, 0, 1], atol=1e-9)
    assert 1e-3 < np.abs(start - UR10E).max() < 6e-3
    again = scene_from_table(scene.source, name="joints")
    np.testing.assert_array_equal(again.path.ends[0], start)


@pytest.mark.parametrize("example", ["cups-around-a-column", "shelf-to-table"])
def test_the_joint_path_begins_and_arrives_in_them(example: str) -> None:
    scene, q = on_the_line(example)
    held = scene_of({"joints": q[0].tolist()}, {"joints": q[-1].tolist()}, example=example)
    np.testing.assert_allclose(held.path.at([0.0, 1.0])[:, :3], scene.path.at([0.0, 1.0])[:, :3], atol=1e-9)
    found = try_joint_paths(held.robot, held.path, tool=held.tray.tool).paths
    assert len(found) == 1
    np.testing.assert_allclose(found[0].q[[0, -1]], q[[0, -1]], atol=1e-6)


def test_another_branch_and_other_turns_are_told() -> None:
    _, q = on_the_line()
    turned = q[-1] - [2 * np.pi, 0, 0, 0, 0, 0]
    scene = scene_of({"joints": q[0].tolist()}, {"joints": turned.tolist()})
    with pytest.raises(
        ScenarioError, match=r"arrives in joints \(.*\) deg along it, on another branch than goal.joints"
    ):
        joint_paths(scene.robot, scene.path, tool=scene.tray.tool)


def test_sampling_grows_from_the_stated_joints() -> None:
    _, q = on_the_line("shelf-to-table")
    scene = scene_of({"joints": q[0].tolist()}, {"joints": q[-1].tolist()}, example="shelf-to-table", obstacles=True)
    arm = LevelArm(scene)
    assert np.isin([arm.held_of(q[0]), arm.held_of(q[-1])], arm.held).all()
    legs = sample_path(arm, seed=0, samples=500)
    assert legs is not None
    way = concatenate(legs)
    assert max(np.abs(arm.apart(way.q[index], q[index])).max() for index in (0, -1)) < 1e-3


@pytest.mark.parametrize(
    ("start", "robot", "message"),
    [
        ({"joints": [0.0] * 3}, {}, "start.joints has 3 angles where 6 are needed: shoulder_pan_joint, "),
        ({"joints": [0.1] * 6}, {}, r"start.joints: the tray leans 91.7 deg there; it must be level, to 0.5 deg"),
        (
            {"joints": ["400 deg", 0, 0, 0, 0, 0]},
            {},
            "shoulder_pan_joint at 400 deg, outside its limits by 40 deg; it must be",
        ),
        ({**START, "joints": [0.0] * 6}, {}, "start: joints stand in the place of position and yaw; give one or the"),
        ({}, {}, "start: position is missing; give it, or joints"),
        ({"joints": "home"}, {}, r'\[path.start\]: joints "home" is not a list'),
        ({"joints": UR10E.tolist()}, {"base_yaw": "free"}, "start.joints: where the tray is then depends on base_yaw"),
    ],
)
def test_refused_joints(start: object, robot: dict[str, object], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        scene_of(start, GOAL, robot=robot)
