"""Ways found by sampling: clear, on one branch, the same for the same seed, shorter after shortening."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.path_search.level_arm import LevelArm
from nospill.path_search.sampled_paths import SampledPath, concatenate, sample_path, shorten
from nospill.robots.kinematics.forward import kinematics
from nospill.scenario import scene_from_table

CUP = {"name": "cup", "shape": "cylinder", "radius": 0.03, "height": 0.08, "mass": 0.2, "centre_of_mass_height": 0.03}


def arm_of(
    model: str,
    start: list[float],
    goal: list[float],
    *obstacles: dict[str, object],
    via: list[list[float]] | None = None,
) -> LevelArm:
    table = {
        "robot": {"model": model},
        "tray": {"size": [0.16, 0.12], "offset": 0.08, "friction": 0.4},
        "cargo": [{**CUP, "at": [0.0, 0.0]}],
        "obstacle": [*obstacles],
        "path": {"type": "free", "start": {"position": start}, "goal": {"position": goal, "yaw": 0.3}}
        | ({"via": [{"position": place} for place in via]} if via else {}),
    }
    return LevelArm(scene_from_table(table, name="sampled"), spare=0.01)


@pytest.fixture(scope="module", params=["ur5e", "franka-fr3"])
def searched(request: pytest.FixtureRequest) -> tuple[LevelArm, SampledPath]:
    column = {"name": "column", "shape": "cylinder", "at": [0.5, 0.0, 0.5], "radius": 0.05, "height": 1.0}
    arm = arm_of(request.param, [0.45, -0.35, 0.45], [0.45, 0.35, 0.45], column)
    found = sample_path(arm, seed=0, samples=2000)
    assert found is not None and len(found) == 1
    return arm, found[0]


def test_the_way_leads_from_start_to_goal_level_and_clear(searched: tuple[LevelArm, SampledPath]) -> None:
    arm, way = searched
    assert np.allclose(way.poses[[0, -1], :3], arm.ends[:, :3])
    assert arm.clear(way.poses, way.q).all()
    assert np.abs(arm.apart(way.q[1:], way.q[:-1])).max() < 0.3
    positions, rotations = kinematics(arm.robot).poses(way.q, tool=arm.scene.tray.tool)
    assert np.abs(positions - way.poses[:, :3]).max() < 1e-4
    assert np.abs(rotations[:, 2, 2] - 1.0).max() < 1e-6


def test_the_same_seed_finds_the_same_way(searched: tuple[LevelArm, SampledPath]) -> None:
    arm, way = searched
    again = sample_path(arm, seed=0, samples=2000)
    assert again is not None and np.array_equal(again[0].q, way.q)


def test_shortening_takes_time_away(searched: tuple[LevelArm, SampledPath]) -> None:
    arm, way = searched
    short = shorten(arm, way, seed=0, tries=30)
    assert arm.clear(short.poses, short.q).all()
    assert np.sum(arm.time(short.q[1:], short.q[:-1])) < np.sum(arm.time(way.q[1:], way.q[:-1]))


def test_a_goal_that_the_arm_cannot_reach_gives_none() -> None:
    floor = {"name": "floor", "shape": "halfspace", "at": [0.0, 0.0, -0.5]}
    arm = arm_of("ur5e", [0.45, -0.35, 0.45], [2.0, 0.0, 0.4], floor)
    assert sample_path(arm, seed=0, samples=50) is None


def test_a_way_through_places_is_one_way_of_several_legs() -> None:
    column = {"name": "column", "shape": "cylinder", "at": [0.5, 0.0, 0.5], "radius": 0.05, "height": 1.0}
    places = [[0.3, -0.1, 0.6], [0.3, 0.2, 0.3]]
    arm = arm_of("ur5e", [0.45, -0.35, 0.45], [0.45, 0.35, 0.45], column, via=places)
    legs = sample_path(arm, seed=0, samples=2000)
    assert legs is not None and len(legs) == 3
    for leg, place in zip(legs, places, strict=False):
        assert np.allclose(leg.poses[-1, :3], place)
    way = concatenate(legs)
    assert arm.clear(way.poses, way.q).all()
    assert np.abs(arm.apart(way.q[1:], way.q[:-1])).max() < 0.3
    assert len(way.q) == sum(len(leg.q) for leg in legs) - 2
