"""Layouts of cycles: derivatives add up over the legs, and the certificate of the whole decides."""

from __future__ import annotations

from itertools import combinations

import pytest

import nospill as ns
from nospill.errors import ScenarioError
from nospill.layouts.search import layout
from nospill.layouts.spacing import Spacing
from nospill.layouts.variables import variables_of
from nospill.planning.cycles import CyclePlanner
from nospill.planning.varied import Varied
from nospill.plans.cycle import CyclePlan
from nospill.scenario.cycles import changed_cycle
from nospill.scenario.layout import overlap
from tests.cycles import there_and_back

PLACE = "leg.out.path.end"
SHORTER = [0.6, 0.24, 0.5]


def test_a_place_between_two_legs_counts_in_both() -> None:
    cycle = ns.load_cycle(there_and_back())
    planner = CyclePlanner()
    with pytest.raises(ScenarioError, match="no cycle of these legs was planned before"):
        planner.duration_change(cycle)
    before = planner.plan(cycle)
    moved = changed_cycle(cycle, {PLACE: SHORTER})
    foretold = planner.duration_change(moved)
    after = planner.plan(moved)
    legs = [one.duration - other.duration for one, other in zip(after.legs, before.legs, strict=True)]
    assert all(leg < -5e-3 for leg in legs)
    assert foretold == pytest.approx(sum(legs), rel=0.1)


def test_the_best_layout_of_a_cycle_is_certified_as_a_whole_and_no_longer() -> None:
    found = layout(there_and_back(), {"cargo.*.at": None, PLACE: [SHORTER, [0.6, 0.25, 0.5]]}, plans=3)
    plan, before = found.plan, found.before
    assert isinstance(plan, CyclePlan) and isinstance(before, CyclePlan)
    assert plan.certificate.ok and plan.duration < before.duration
    assert all(overlap(*pair) <= 1e-9 for leg in plan.legs for pair in combinations(leg.scene.cargo, 2))


def test_only_what_stands_together_keeps_apart() -> None:
    table = there_and_back()
    table["cargo"].append({**table["cargo"][1], "name": "next", "at": [0.07, 0.0]})
    table["leg"][0]["load"] = ["next"]
    table["leg"][1]["unload"] = ["next"]
    base = Varied(ns.load_cycle(table))
    variables = variables_of(base, {"cargo.*.at": None})
    # three edges, and of three pairs the two that are ever on the tray together
    assert len(Spacing(base, variables).distances(variables.stated)) == 3 + 2
