"""Sweeps of cycles: lines are those of the cycles planned one by one, and a bound that is known in closed form."""

from __future__ import annotations

import pytest

import nospill as ns
from nospill.planning.varied import varied_from_text
from nospill.sweeps.bounds import largest
from nospill.sweeps.definition import define_sweep
from nospill.sweeps.figures import CYCLE_FIGURES
from nospill.sweeps.planning_process import PointPlanner
from nospill.sweeps.points import PLANNED
from tests.cycles import small_plan, there_and_back


def test_a_line_of_a_cycle_is_what_its_plan_says() -> None:
    """The base as it stands, in the process that plans points, and a neighbour that starts from it."""
    text = ns.load_cycle(there_and_back()).text
    planner, plan = PointPlanner(text, "small"), small_plan()
    own = planner.line({}, key="a", warm=None, keep=False)
    assert own["ending"] == PLANNED and own["warm_from"] == "" and set(own["figures"]) == set(CYCLE_FIGURES)
    assert own["figures"]["duration_s"] == pytest.approx(plan.duration, abs=1e-9)
    assert own["figures"]["moves_per_hour"] == pytest.approx(plan.moves_per_hour)
    assert own["figures"]["largest_use"] == plan.certificate.worst[1].use
    assert own["nearest"].endswith(f"leg {plan.certificate.worst[0]}")
    longer = planner.line({"leg.back.dwell": "0.7 s"}, key="b", warm={"key": "a", "values": {}}, keep=False)
    assert longer["ending"] == PLANNED and longer["warm_from"] == "a"
    assert longer["figures"]["duration_s"] == pytest.approx(plan.duration + 0.5, rel=5e-3)
    refused = planner.line({"leg.out.unload": ["nothing"]}, key="c", warm=None, keep=False)
    assert refused["ending"] == "refused" and "there is no object" in refused["reason"]


def test_the_largest_dwell_within_a_time_is_what_the_motions_leave() -> None:
    motions = sum(leg.motion for leg in small_plan().times)
    found = largest(there_and_back(), "leg.back.dwell", motions + 0.3 + 0.5, between=(0.3, 0.8), precision=0.05)
    assert found.plan.certificate.ok and found.value == pytest.approx(0.5, rel=0.08)


def test_ends_that_were_left_out_follow_where_a_leg_is_changed() -> None:
    cycle = ns.load_cycle(there_and_back())
    base = varied_from_text(cycle.text, "small")
    x, y, z, _ = cycle.legs[0].scene.path.at([1.0])[0].tolist()
    moved = base.changed({"leg.out.path.end": [x, y + 0.05, z]})
    assert isinstance(moved, type(cycle))
    assert moved.legs[1].scene.path.at([0.0])[0][1] == pytest.approx(y + 0.05)


def test_columns_of_a_cycle_may_be_derived_from_and_aimed_at() -> None:
    found = define_sweep(
        there_and_back(),
        {"leg.out.dwell": [0.3, 0.4]},
        columns={"drinks": "2 * cycles_per_hour"},
        goals={"moves_per_hour": "greatest"},
    )
    assert len(found.points) == 2 and found.goals[0][0] == "moves_per_hour"
