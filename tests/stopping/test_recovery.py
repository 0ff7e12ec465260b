"""Stops from states that break a limit: no more excess than the state has, nothing else broken, and an end to it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest

import nospill as ns
from nospill.certification.certificate import judge_motion
from nospill.errors import ScenarioError
from nospill.plans.plan import Plan
from nospill.plans.state import MotionState
from nospill.scene.swing import Swing
from nospill.stopping import recovery, verdicts
from nospill.stopping.solving import stopping_scene

AT = 2.4
"""s; in the midst of the motion."""


@pytest.fixture(scope="module")
def plan(gentle_plan: Callable[[str, int], Plan]) -> Plan:
    return gentle_plan("matrix-liquid-soft-end", 1)


def _bumped(plan: Plan, crest: float) -> MotionState:
    """The state of a plan with the liquid at rest at a crest, m, towards x, as it never is in the plan."""
    state = plan.state_at(AT)
    ((name, _),) = state.swings.items()
    gain = plan.scene.cargo[0].oscillators[0].surface_gain
    return replace(state, swings={name: Swing(((crest / gain, 0.0),), ((0.0, 0.0),))})


def test_from_a_state_within_its_limits_the_stop_is_certified(plan: Plan) -> None:
    found = ns.recover(plan, plan.state_at(AT))
    assert found.certificate.ok and found.text == "certified" and found.until == 0.0 and not found.moves
    assert found.stop.duration < plan.duration - AT


def test_a_bumped_liquid_comes_below_its_limit_and_rises_no_higher(plan: Plan) -> None:
    limit, crest = plan.scene.cargo[0].filling.max_slosh_height, 0.018  # type: ignore[union-attr]
    found = ns.recover(plan, _bumped(plan, crest))
    ((name, excess),) = found.excess.items()
    assert 0.99 * (crest - limit) <= excess <= 1.03 * crest - limit
    assert [row.id for row in found.certificate.rows if not row.ok] == [("slosh height", name)]
    assert 0.0 < found.until < found.stop.duration
    assert found.text.startswith(f"recovering: {name} 3.")
    height = found.stop.trajectory.slosh[name].height
    t = found.stop.trajectory.t
    assert height[t > found.until + 2e-3].max() <= limit * (1.0 + 1e-6)


def test_a_liquid_that_cannot_be_stilled_on_what_is_left_of_the_path_swings_on(plan: Plan) -> None:
    """With a tenth of a second left no stop calms a wave twice as high as allowed; least excess, and said to go on."""
    state = plan.state_at(plan.duration - 0.1)
    ((name, _),) = state.swings.items()
    limit, gain = plan.scene.cargo[0].filling.max_slosh_height, plan.scene.cargo[0].oscillators[0].surface_gain  # type: ignore[union-attr]
    crest = 1.9 * limit
    found = ns.recover(plan, replace(state, swings={name: Swing(((crest / gain, 0.0),), ((0.0, 0.0),))}))
    assert crest - limit - 1e-6 <= found.excess[name] <= 1.1 * crest - limit
    after = found.until - found.stop.duration
    mode = plan.scene.cargo[0].oscillators[0]
    slowest = math.log((limit + found.excess[name]) / limit) / (mode.damping * mode.frequency)  # of its free decay
    assert 0.0 < after <= slowest + 2.0 * math.pi / mode.frequency
    assert after > 0.5 * slowest and found.text.endswith(
        f"until {found.until:.3f} s, {after:.3f} s after the arm stands"
    )
    assert {row.constraint for row in found.certificate.rows if not row.ok} == {"slosh height", "residual height"}
    rim = plan.scene.cargo[0].container.height - plan.scene.cargo[0].filling.liquid_height  # type: ignore[union-attr]
    assert (limit + found.excess[name] > rim) == (found.spilled == (name,))


def test_a_stop_in_which_an_object_moves_says_so(plan: Plan, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where none is found in which it stays, which is looked for first."""
    monkeypatch.setattr(verdicts, "stays", lambda *_, **__: False)
    found = ns.recover(plan, plan.state_at(AT))
    assert found.moves and found.certificate.ok
    assert found.text == "certified; by the whole physics an object moves"
    steep = replace(found, stop=replace(found.stop, doubted=("c1", "c2")))
    assert steep.text == f"{found.text}; the flow that judges c1, c2 is in doubt"


def test_where_no_stop_is_found_what_is_left_of_the_plan_is_the_answer(
    plan: Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With its own verdict: the liquid rises as the whole motion after the bump has it, and other breaks are said."""
    monkeypatch.setattr(recovery, "found_from_afar", lambda *_, **__: None)
    state = _bumped(plan, 0.018)
    found = ns.recover(plan, state)
    assert found.stop.origin == "rest of the plan" and found.stop.duration == pytest.approx(plan.duration - AT)
    whole = judge_motion(state.rest, stopping_scene(plan.scene, state, 1.0)).certificate
    assert found.certificate == whole and not whole.ok
    ((name, excess),) = found.excess.items()
    limit = plan.scene.cargo[0].filling.max_slosh_height  # type: ignore[union-attr]
    assert excess == pytest.approx(max(row.worst_value for row in whole.rows if not row.ok) - limit)
    assert found.broken == () and found.text.startswith(f"recovering: {name} ")
    assert found.text.endswith("; no stop was found, it is what is left of the plan")
    calm = ns.recover(plan, plan.state_at(AT))
    assert calm.certificate.ok and calm.stop.origin == "rest of the plan" and calm.text == "certified"


def test_what_is_left_of_the_plan_says_which_other_rows_it_breaks(plan: Plan, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recovery, "found_from_afar", lambda *_, **__: None)
    state = _bumped(plan, 0.018)
    friction = tuple(replace(item, friction=0.02) for item in plan.scene.cargo)
    smooth = replace(plan, scene=replace(plan.scene, cargo=friction))
    found = ns.recover(smooth, replace(smooth.state_at(AT), swings=state.swings))
    (slip,) = found.broken
    assert slip.startswith("slip of ") and found.moves
    assert found.text.endswith(f"; no stop was found, it is what is left of the plan; {slip}")
    calm = ns.recover(smooth, smooth.state_at(AT))
    assert not calm.excess and calm.broken and calm.text.startswith("recovering: no liquid is too high; ")


def test_what_stands_above_the_rim_has_been_spilled(plan: Plan) -> None:
    with pytest.raises(ScenarioError, match="rim of its cup"):
        ns.recover(plan, _bumped(plan, 0.06))
