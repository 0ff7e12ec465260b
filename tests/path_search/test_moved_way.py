"""The way of an earlier plan led to other ends."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nospill.path_search.candidates import path_table_of, with_path
from nospill.path_search.moved_way import FARTHEST, same_surroundings, way_of
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene

START: dict[str, Any] = {"position": [0.6, -0.3, 0.5], "yaw": 0.2}
POST = {"name": "post", "shape": "cylinder", "at": [0.9, 0.0, 0.5], "radius": 0.03, "height": 1.0}


def to(goal: tuple[float, float, float], yaw: float = 0.4, **path: object) -> Scene:
    table = read_scenario("cups-around-a-column").source | {"obstacle": [POST]}
    ends = {"type": "free", "start": START, "goal": {"position": [*goal], "yaw": yaw}}
    return scene_from_table({**table, "path": ends | path}, name="moved")


@pytest.fixture(scope="module")
def before() -> Scene:
    scene, s = to((0.6, 0.3, 0.5)), np.linspace(0.0, 1.0, 21)
    arc = scene.path.at(s) + np.outer(np.sin(np.pi * s), [0.0, 0.0, 0.2, 0.3])
    return with_path(scene, arc[:, :3], arc[:, 3])


def test_the_way_is_bent_to_the_new_goal_and_stays_as_it_is_near_the_start(before: Scene) -> None:
    scene = way_of(before, to((0.7, 0.35, 0.45), yaw=0.1))
    assert scene is not None
    moved = scene.path.at([0.0, 0.1, 1.0]) - before.path.at([0.0, 0.1, 1.0])
    np.testing.assert_allclose(moved[0], 0.0, atol=1e-6)
    assert np.abs(moved[1]).max() < 0.01
    np.testing.assert_allclose(moved[2], [0.1, 0.05, -0.05, -0.3], atol=1e-6)


def test_a_goal_turned_by_more_than_half_a_turn_takes_the_short_way(before: Scene) -> None:
    scene = way_of(before, to((0.6, 0.3, 0.5), yaw=0.3 + 2.0 * np.pi))
    assert scene is not None
    assert scene.path.at(1.0)[0, 3] - before.path.at(1.0)[0, 3] == pytest.approx(-0.1, abs=1e-6)


def test_with_the_ends_as_they_were_the_way_is_the_same_to_the_last_digit(before: Scene) -> None:
    scene = way_of(before, to((0.6, 0.3, 0.5)))
    assert scene is not None and path_table_of(scene) == path_table_of(before)
    assert same_surroundings(before, scene)


def test_a_straight_way_stays_straight() -> None:
    scene = to((0.6, 0.3, 0.5))
    assert way_of(to((0.6, 0.3, 0.5)), scene) is scene


@pytest.mark.parametrize(
    "scene",
    [
        to((0.6, 0.3, 0.5 + 1.01 * FARTHEST)),
        to((0.6, 0.3, 0.5), via=[{"position": [0.65, 0.0, 0.6], "radius": 0.1}]),
        read_scenario("matrix-liquid"),
    ],
    ids=["too far", "another place on the way", "a given path"],
)
def test_what_is_another_way_is_none(before: Scene, scene: Scene) -> None:
    assert way_of(before, scene) is None


def test_a_post_that_stands_elsewhere_is_seen(before: Scene) -> None:
    scene = scene_from_table(before.source | {"obstacle": [POST | {"at": [0.95, 0.0, 0.5]}]}, name="moved")
    assert not same_surroundings(before, scene)
