"""Plans that can be stopped in time: which bound on the speed is found, where stops take as long as a law says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

import nospill as ns
from nospill.errors import NoSolutionError, ScenarioError
from nospill.plans.plan import Plan
from nospill.scene.scene import Scene
from nospill.stopping import stoppable
from nospill.stopping.stoppable import plan_stoppable

FASTEST = 1.4
"""m/s, of the tray without a bound."""


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch, gentle_plan: Callable[[str, int], Plan]) -> list[Scene]:
    """The scenes that are planned, in the place of planning; what a stop takes is 0.5 s at 1 m/s, in proportion."""
    scenes: list[Scene] = []
    made = gentle_plan("matrix-liquid-soft-end", 1)

    def planned(scene: Scene, **_: Any) -> Plan:
        scenes.append(scene)
        return replace(made, scene=scene)

    def longest(plan: Plan, every: float, within: float) -> tuple[float, float]:
        return 0.5 * min(plan.scene.motion.max_speed or FASTEST, FASTEST), 1.0

    monkeypatch.setattr(stoppable, "plan", planned)
    monkeypatch.setattr(stoppable, "_longest", longest)
    monkeypatch.setattr(stoppable, "_greatest_speed", lambda plan: FASTEST)
    return scenes


def test_the_bound_is_the_one_at_which_stops_just_hold(asked: list[Scene]) -> None:
    found = plan_stoppable(ns.load("matrix-liquid-soft-end").changed({"motion.stoppable": "0.4 s"}))
    assert found.max_speed is not None and 0.8 / 1.04 < found.max_speed <= 0.8
    assert found.longest <= found.within == 0.4
    assert found.plan.scene.motion.max_speed == found.max_speed
    assert f"max_speed = {found.max_speed:.3f} m/s" in found.text and "(+0.0 %)" in found.text
    assert [scene.motion.stoppable for scene in asked] == [None] * len(found.tried)
    assert len(found.tried) <= 8


def test_a_motion_that_can_be_stopped_as_it_is_is_planned_once(asked: list[Scene]) -> None:
    found = plan_stoppable("matrix-liquid-soft-end", within=0.8)
    assert found.max_speed is None and len(asked) == 1 and "without a bound" in found.text


def test_where_no_bound_is_low_enough_it_is_said(monkeypatch: pytest.MonkeyPatch, asked: list[Scene]) -> None:
    monkeypatch.setattr(stoppable, "_longest", lambda *_: (2.0, 0.7))
    with pytest.raises(NoSolutionError, match=r"stops within 0\.8 s; .* takes 2\.000 s, from 0\.700 s"):
        plan_stoppable("matrix-liquid-soft-end", within=0.8)


def test_times_and_callers_that_make_no_sense_are_refused() -> None:
    with pytest.raises(ScenarioError, match="stoppable = None"):
        plan_stoppable("matrix-liquid-soft-end")
    with pytest.raises(ScenarioError, match=r"above 0\.02 s"):
        plan_stoppable("matrix-liquid-soft-end", within=0.01)
    with pytest.raises(ScenarioError, match="plan_stoppable"):
        ns.plan(ns.load("matrix-liquid-soft-end").changed({"motion.stoppable": "0.4 s"}))
