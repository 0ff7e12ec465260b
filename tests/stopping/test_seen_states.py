"""States with liquids as somebody has seen them: what is refused, and stops along a plan's own way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import nospill as ns
from nospill.certification.path_deviation import nearest_on
from nospill.errors import ScenarioError
from nospill.plans.plan import Plan
from nospill.plans.state import MotionState
from nospill.scene.swing import Swing
from nospill.stopping.seen_states import on_own_way

AT = 2.4
CALM = Swing(((0.0, 0.0),), ((0.0, 0.0),))


@pytest.fixture(scope="module")
def plan(gentle_plan: Callable[[str, int], Plan]) -> Plan:
    return gentle_plan("matrix-liquid-soft-end", 1)


@pytest.fixture(scope="module")
def state(plan: Plan) -> MotionState:
    return plan.state_at(AT)


@pytest.mark.parametrize(
    ("swings", "told"),
    [
        ({}, "does not say how the liquid of c1 swings, only none"),
        ({"cup": CALM}, "does not say how the liquid of c1 swings, only cup"),
        ({"c1": replace(CALM, displacement=((np.nan, 0.0),))}, "no number"),
    ],
)
def test_what_is_no_swing_of_its_liquids_is_refused(
    plan: Plan, state: MotionState, swings: dict[str, Swing], told: str
) -> None:
    with pytest.raises(ScenarioError, match=told):
        ns.recover(plan, replace(state, swings=swings))


@pytest.mark.parametrize("arguments", [("plan", 2.4), ("scene", "state")])
def test_what_is_no_plan_or_no_state_is_refused(plan: Plan, state: MotionState, arguments: tuple[Any, Any]) -> None:
    known = {"plan": plan, "scene": plan.scene, "state": state}
    with pytest.raises(ScenarioError, match=r"plan\.state_at\(0\.7\)"):
        ns.recover(*(known.get(item, item) for item in arguments))


def test_a_plan_that_has_no_stops_and_a_state_of_another_one_are_refused(plan: Plan, state: MotionState) -> None:
    ranged = replace(plan, scene=replace(plan.scene, motion=replace(plan.scene.motion, speed_range=(0.5, 1.0))))
    with pytest.raises(ScenarioError, match="speed_range"):
        ns.recover(ranged, state)
    with pytest.raises(ScenarioError, match="not one of this plan"):
        ns.recover(plan, replace(state, t=1.0))


def test_a_plan_whose_tray_leaves_its_path_is_stopped_along_its_own_way(plan: Plan, state: MotionState) -> None:
    """From an instant between the knots of that way, where it moves as the plan to rounding."""
    rules = replace(plan.scene.motion, corridor=0.05, yaw_free=True)
    leaving = replace(plan, scene=replace(plan.scene, motion=rules))
    at = AT + 1.0 / plan.trajectory.rate
    then = replace(plan.state_at(at), swings=state.swings)
    own_way, on_it = on_own_way(leaving, then)
    assert not own_way.scene.motion.leaves_path and on_it.swings == state.swings
    row = round(at * plan.trajectory.rate)
    gap = own_way.scene.path.at([on_it.arm.s])[0, :3] - plan.trajectory.tray_position[row]
    assert np.abs(gap).max() < 1e-9
    found = ns.recover(leaving, plan.state_at(at))
    assert found.certificate.ok and found.stop.duration <= plan.duration - at + 1e-9
    ends = found.stop.trajectory.tray_position[-1:]
    assert nearest_on(own_way.scene.path, ends)[1][0] < 1e-4
