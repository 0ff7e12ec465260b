"""Free paths planned from the plan before, along its way."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

import nospill as ns
from nospill.path_search.candidates import path_table_of
from nospill.planning import way_before
from nospill.planning.active_set import ActiveSet
from nospill.planning.way_before import NO_WAY

pytestmark = pytest.mark.slow

START: dict[str, Any] = {"position": [0.6, -0.3, 1.2]}
POST = {"name": "post", "shape": "cylinder", "at": [1.0, 0.0, 0.9], "radius": 0.03, "height": 1.8}


def towards(x: float, y: float = 0.3, post: float = 1.0, friction: float = 0.466308) -> ns.Scene:
    table: dict[str, Any] = ns.load("matrix-rigid").source
    table["planning"] = {"intervals": 40}
    del table["motion"]["path_jerk_limit"]
    table["motion"] |= {"tilt": "fixed", "max_jerk": 2000.0}
    table["tray"] |= {"friction": friction}
    goal = {"position": [x, y, 1.2]}
    obstacle = [{**POST, "at": [post, 0.0, 0.9]}]
    return ns.load({**table, "path": {"type": "free", "start": START, "goal": goal}, "obstacle": obstacle})


@pytest.fixture(scope="module")
def first() -> ns.Plan:
    return ns.plan(towards(0.6))


@pytest.mark.parametrize("scene", [towards(0.68), towards(0.6, post=0.95)], ids=["goal", "post"])
def test_a_goal_or_an_obstacle_that_moves_needs_no_search(first: ns.Plan, scene: ns.Scene) -> None:
    found, cold = ns.Planner(first).plan(scene), ns.plan(scene)
    assert found.certificate.ok and found.report.warm and not found.report.not_warm
    assert "kinematics" not in found.report.phases
    assert found.duration == pytest.approx(cold.duration, rel=0.01)
    assert found.scene.path.at(1.0)[0, :3] == pytest.approx(scene.path.at(1.0)[0, :3], abs=1e-6)


def test_where_ends_and_obstacles_stay_the_way_does_too() -> None:
    planner = ns.Planner()
    before = planner.plan(towards(0.6))
    found = planner.plan(towards(0.6, friction=0.45))
    assert found.certificate.ok and found.report.warm
    assert path_table_of(found.scene) == path_table_of(before.scene)
    assert found.report.starts.tried == 1 and "kinematics" not in found.report.phases


def test_a_goal_far_away_is_searched_for(first: ns.Plan) -> None:
    found = ns.Planner(first).plan(towards(0.6, y=0.75))
    assert found.certificate.ok and not found.report.warm and found.report.not_warm == NO_WAY


def test_of_a_planner_that_goes_on_an_obstacle_moves_with_the_multipliers(first: ns.Plan) -> None:
    planner = ns.Planner()
    planner.plan(towards(0.6))
    found = planner.plan(towards(0.6, post=0.98))
    assert found.certificate.ok and found.report.warm
    assert found.report.starts.tried == 1  # none from the coarse grid
    assert found.duration == pytest.approx(first.duration, rel=0.01)


def test_the_weights_that_another_goal_asked_for_count_for_less(
    first: ns.Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[float] = []

    def caught(active: ActiveSet, *_: object) -> None:
        seen.append(active.smoothness.factor)
        raise ns.NoSolutionError("none is looked for")

    monkeypatch.setattr(way_before, "solve_lazily", caught)
    heavy = replace(first, report=replace(first.report, jerk_weight_factor=50.0))
    found = ns.Planner(heavy).plan(towards(0.68))
    assert 1.0 < seen[0] < 50.0**0.5 and len(seen) == 1
    assert found.certificate.ok and not found.report.warm
