"""What is said to be in the way where a free path goes round."""

from __future__ import annotations

import re

import numpy as np
import pytest

from benchmarks.carry.draw import PROBLEMS, read_problems
from nospill.path_search.branches import tray_is_clear
from nospill.path_search.candidates import with_path
from nospill.path_search.direct_way import blocked_direct_way
from nospill.plans.plan import Plan
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene

COLUMN = {"name": "column", "shape": "box", "at": [0.86, 0.0, 0.45], "size": [0.15, 0.15, 0.9], "clearance": 0.01}
TABLE = {"name": "table", "shape": "halfspace", "at": [0.0, 0.0, 0.0]}
DEPTH = 1e3 * (0.75 + 0.12 - (0.86 - 0.075))
"""mm; the far edge of the tray, 240 mm wide about x = 0.75 m, beyond the near side of the column."""


def scene_of(*obstacles: dict[str, object]) -> Scene:
    table = read_scenario("cups-around-a-column").source
    return scene_from_table({**table, "obstacle": [*obstacles], "motion": {"tilt": "fixed"}}, name="around")


def inside(scene: Scene) -> Scene:
    """The scene with a way nearer to the base."""
    points = scene.path.at(np.linspace(0.0, 1.0, 7))[:, :3]
    points[:, 0] -= 0.3 * np.sin(np.pi * np.linspace(0.0, 1.0, 7))
    return with_path(scene, points)


def test_the_obstacle_on_the_straight_line_is_named_with_its_depth() -> None:
    scene = scene_of(COLUMN, TABLE)
    assert blocked_direct_way(scene, inside(scene)).startswith(f'the tray enters "column" by {DEPTH:.0f} mm at s = 0.')


def test_a_link_is_named_where_the_tray_is_clear() -> None:
    """Of the benchmark: the tray passes, the wrist behind it does not, on any branch that is free at both ends."""
    scene = scene_from_table(read_problems(PROBLEMS)[3]["table"], name="south")
    assert tray_is_clear(scene, scene.path)
    assert re.match(r'the \w+_link enters "south" by [0-9.]+ mm', blocked_direct_way(scene, inside(scene)))


def test_nothing_is_said_where_the_direct_way_is_clear_or_taken() -> None:
    scene = scene_of(TABLE)
    assert blocked_direct_way(scene, inside(scene)) == ""
    blocked = scene_of(COLUMN, TABLE)
    assert blocked_direct_way(blocked, blocked) == ""


@pytest.mark.slow
def test_a_plan_says_it(example_plan) -> None:
    plan: Plan = example_plan("cups-around-a-column")
    assert f'enters "column" by {DEPTH:.0f} mm' in plan.report.blocked_way
    assert plan.summary()["blocked_way"] == plan.report.blocked_way
