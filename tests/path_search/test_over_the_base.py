"""Over the base: from the front of an arm to behind it, straight through the axis of its first joint."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.carry.draw import PROBLEMS, read_problems
from nospill.path_search import free_path
from nospill.path_search.level_arm import LevelArm
from nospill.path_search.over_the_base import axis_crossings, base_axis, lead_over_axis, pose_beyond
from nospill.path_search.sampled_paths import concatenate, sample_path, split_after
from nospill.robots.description.catalog import load_robot
from nospill.robots.joint_paths.search import try_joint_paths
from nospill.robots.kinematics.forward import kinematics
from nospill.scenario import scene_from_table
from nospill.scene.scene import Scene

CUP = {"name": "cup", "shape": "cylinder", "radius": 0.03, "height": 0.08, "mass": 0.2, "centre_of_mass_height": 0.03}


def scene_of(model: str, offset: object = 0.1) -> Scene:
    table = {
        "robot": {"model": model},
        "tray": {"size": [0.16, 0.12], "offset": offset, "friction": 0.4},
        "cargo": [{**CUP, "at": [0.0, 0.0]}],
        "path": {"type": "free", "start": {"position": [0.5, -0.3, 0.6]}, "goal": {"position": [0.5, 0.3, 0.6]}},
    }
    return scene_from_table(table, name="over")


def test_the_axis_is_that_of_an_upright_arm_of_six_with_the_tray_on_its_flange() -> None:
    np.testing.assert_array_equal(base_axis(scene_of("comau-smart-six")), [0.0, 0.0])
    assert base_axis(scene_of("franka-fr3")) is None
    assert base_axis(scene_of("comau-smart-six", [0.05, 0.0, 0.1])) is None


def ahead(q: np.ndarray) -> np.ndarray:
    """Where the front of a Smart SiX is (m, 2): its first axis points down."""
    return np.column_stack([np.cos(q[:, 0]), -np.sin(q[:, 0])])


def test_a_curve_is_led_exactly_through_the_axis_and_keeps_its_ends() -> None:
    axis, s = np.array([0.1, 0.2]), np.linspace(0.0, 1.0, 41)
    poses = np.column_stack([s - 0.37, 0.23 - 0.1 * s**2, 0.5 + s, s])
    moved = lead_over_axis(poses, 0.5, axis)
    gaps = np.linalg.norm(moved[:, :2] - axis, axis=1)
    assert gaps.min() == 0.0 and np.argmin(gaps) % 2 == 1
    np.testing.assert_array_equal(moved[[0, -1]], poses[[0, -1]])
    np.testing.assert_array_equal(moved[:, 2:], poses[:, 2:])


def test_a_step_over_it_is_straight() -> None:
    random, axis = np.random.default_rng(0), np.array([0.1, 0.2])
    pose = pose_beyond(np.array([0.5, -0.1, 0.6, 0.0]), axis, random)
    assert pose is not None
    here, there = np.array([0.4, -0.3]), pose[:2] - axis
    assert here @ there < 0.0 and here[0] * there[1] - here[1] * there[0] == pytest.approx(0.0, abs=1e-12)
    assert pose_beyond(np.array([0.11, 0.2, 0.6, 0.0]), axis, random) is None


def test_from_behind_to_the_front_joint_1_does_not_jump(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the benchmark: the start is clear from behind only, and the goal is within the limits from the front only."""
    table = read_problems(PROBLEMS)[184]["table"]
    # stated, the capsules may not be entered, as estimated ones may
    capsules = [
        {"link": item.link, "from": list(item.start), "to": list(item.end), "radius": item.radius}
        for item in load_robot(table["robot"]["model"]).capsules
    ]
    scene = scene_from_table(table | {"robot": table["robot"] | {"capsule": capsules}}, name="behind")
    axis, arm = base_axis(scene), LevelArm(scene, spare=0.015)
    assert axis is not None
    legs = sample_path(arm, seed=1, samples=2000, over=axis)
    assert legs is not None
    (leg,) = legs
    over = axis_crossings(leg.poses, leg.q, axis)
    assert len(over)
    parts = split_after(leg, over)
    np.testing.assert_array_equal(concatenate(parts).q, leg.q)
    assert len(parts) == 2 * len(over) + 1
    monkeypatch.setattr(free_path, "SEEDS", (1,))
    monkeypatch.setattr(free_path, "sample_path", lambda _, *, over, **given: legs if over is not None else None)
    found = free_path.fastest_sampled_path(scene)
    assert found is not None
    way = found[1].path
    assert np.hypot(*way.at(np.linspace(0.0, 1.0, 41))[:, :2].T).min() < 1e-9
    q = try_joint_paths(scene.robot, way, tool=scene.tray.tool).paths[0].at(np.linspace(0.0, 1.0, 2001))
    assert np.abs(np.diff(q, axis=0)).max() < 0.05
    reach = np.sum(kinematics(scene.robot).poses(q, tool=scene.tray.tool)[0][:, :2] * ahead(q), axis=1)
    assert reach[0] * reach[-1] < 0.0
