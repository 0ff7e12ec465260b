"""Which way round obstacles a free path takes, and what is said where all are blocked."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.collisions.configurations import Configurations
from nospill.diagnosis import free_ways, freest_way
from nospill.errors import NoSolutionError, ScenarioError
from nospill.robots.joint_paths.search import joint_paths
from nospill.scenario import read_scenario, scene_from_table
from nospill.scenario.free_way import ways
from nospill.scene.scene import Scene

pytest.importorskip("coal")
pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def _one_short_search(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(free_ways, "SEEDS", (0,))
    monkeypatch.setattr(free_ways, "SAMPLES", 300)


COLUMN = {"name": "column", "shape": "box", "at": [0.86, 0.0, 0.45], "size": [0.15, 0.15, 0.9], "clearance": 0.01}
TABLE = {"name": "table", "shape": "halfspace", "at": [0.0, 0.0, 0.0]}


def scene_of(*obstacles: dict[str, object]) -> Scene:
    table = read_scenario("cups-around-a-column").source
    return scene_from_table({**table, "obstacle": [*obstacles], "motion": {"tilt": "fixed"}}, name="around")


def is_clear(scene: Scene) -> bool:
    paths = joint_paths(scene.robot, scene.path, tool=scene.tray.tool)
    looks = np.linspace(0.0, 1.0, 301)
    return any(Configurations(scene).clear(path.at(looks)).all() for path in paths[:40])


def test_three_plain_ways_are_looked_at() -> None:
    scene = scene_of(TABLE)
    assert 1 < len(ways(scene)) <= 3
    assert freest_way(scene).source == ways(scene)[0].source


def test_a_sampled_way_round_a_column_is_clear_and_the_same_every_time() -> None:
    scene = scene_of(COLUMN, TABLE)
    found = freest_way(scene)
    assert is_clear(found) and not is_clear(ways(scene)[0])
    assert found.path.length < 1.5  # the arc the other way round is 4.6 m long
    assert freest_way(scene).source == found.source
    kept = scene_from_table(found.source, name="kept")
    assert np.array_equal(kept.path.coefficients, found.path.coefficients)


def test_where_all_are_blocked_one_line_says_so() -> None:
    walls = [
        {"name": name, "shape": "box", "at": [side, 0.0, 1.25], "size": ["1.8 m", "20 mm", "2.5 m"]}
        for name, side in (("front", 1.1), ("back", -1.1))
    ]
    with pytest.raises(NoSolutionError, match=r"No way found for the arm: .* random searches found no way") as caught:
        freest_way(scene_of(*walls, TABLE))
    assert caught.value.exit_code == 3


def test_a_goal_beside_an_obstacle_is_bad_input() -> None:
    with pytest.raises(ScenarioError, match=r"where the path ends; move the obstacle or the path") as caught:
        freest_way(scene_of({**COLUMN, "at": [0.75, 0.66, 0.45]}, TABLE))
    assert caught.value.exit_code == 2
