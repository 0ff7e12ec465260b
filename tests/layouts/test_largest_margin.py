"""The largest margin within a time: found where it is known in closed form, and shown by the certificate."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from nospill.certification.certificate import judge
from nospill.errors import NoSolutionError, ScenarioError
from nospill.laws.constraints.base import Role
from nospill.laws.constraints.residual_height import EndDisplacement
from nospill.layouts import goals
from nospill.layouts.goals import LargestMargin, Outcome
from nospill.layouts.margins import margin_of, reserving
from nospill.layouts.search import layout
from nospill.planning import varied
from nospill.plans.cycle import CyclePlan
from nospill.plans.plan import Plan
from nospill.scenario import load
from nospill.scene.scene import Scene
from tests.cycles import there_and_back
from tests.layouts.test_layout_search import small

STATED = 0.9
"""What the friction reserve of the example leaves."""


class Accelerations:
    """In the planner's place: T = 1 s where nothing is kept back, and T^2 as 1/(1 - reserve), up to a wall."""

    wall, plans = 1.0, 0

    def plan(self, scene: Scene) -> Any:
        self.plans += 1
        left = (1.0 - scene.cargo[0].friction_reserve) / STATED
        if 1.0 - left > self.wall:
            raise NoSolutionError("No motion found: beyond the wall")
        return SimpleNamespace(duration=left**-0.5, certificate=SimpleNamespace(ok=True), scene=scene)


@pytest.mark.parametrize(
    ("within", "wall", "reserve"), [(1.5, 1.0, 1 - 1.5**-2), (4.0, 1.0, 1 - 4.0**-2), (2.0, 0.3, 0.3)]
)
def test_the_largest_reserve_is_that_of_the_known_law(within: float, wall: float, reserve: float) -> None:
    planner: Any = Accelerations()
    planner.wall = wall
    found = LargestMargin(within).planned(load("matrix-liquid"), planner, None)
    assert isinstance(found, Outcome)
    assert found.plan.duration <= within
    assert found.reserve == pytest.approx(reserve, abs=0.05 if wall < 1.0 else 0.01) and found.reserve <= reserve
    assert planner.plans <= 6


def test_a_layout_that_cannot_keep_what_one_nearby_does_costs_one_plan() -> None:
    planner: Any = Accelerations()
    scene, goal = load("matrix-liquid"), LargestMargin(1.5)
    near = goal.planned(scene, planner, None)
    assert isinstance(near, Outcome)
    planner.plans = 0
    why_not = LargestMargin(1.4).planned(scene, planner, near)
    assert isinstance(why_not, str) and "of its limits kept back, longer than 1.4 s" in why_not
    assert planner.plans == 1


def test_a_reserve_makes_every_limit_on_liquid_and_contact_smaller_by_its_part() -> None:
    scene = load("mixed-tray")
    kept = scene.changed(reserving(scene, 0.25))
    for before, after in zip(scene.cargo, kept.cargo, strict=True):
        assert after.planned_friction == pytest.approx(0.75 * before.planned_friction)
        assert 1.0 - after.footprint_reserve == pytest.approx(0.75 * (1.0 - before.footprint_reserve))
        if before.filling is not None and after.filling is not None:
            assert after.filling.max_slosh_height == pytest.approx(0.75 * before.filling.max_slosh_height)
    rack = load("vial-rack")  # what stands in it has its friction, and no such key
    assert rack.changed(reserving(rack, 0.25)).cargo[1].footprint_reserve == pytest.approx(1 - 0.75 * 0.95)


def test_the_certificate_shows_the_margin_by_the_limits_as_stated() -> None:
    scene = load(small(path={**small()["path"], "yaw": ["0 deg", "90 deg"]}))
    found = layout(scene, {"cargo.cup.at": None}, within="1.5 s", plans=2)
    assert isinstance(found.plan, Plan)
    assert found.plan.certificate.ok and found.plan.duration <= 1.5
    assert scene.changed(found.values) == found.plan.scene  # with no limit but its own
    rows = [row for row in found.plan.certificate.rows if row.of_object and row.constraint != "still at the end"]
    assert found.margin == pytest.approx(1.0 - max(row.use for row in rows)) == margin_of(found.plan)
    assert found.margin_before is not None and found.margin is not None
    assert found.margin >= found.margin_before > 0.05
    assert found.text.startswith("best layout of") and "margin" in found.text


@pytest.mark.parametrize(
    "tables",
    [
        {"tolerance": {"friction": "5 %", "liquid_height": "1 mm"}},
        {"motion": {"end": "residual", "residual_fraction": 0.8, "speed_range": ["95 %", "100 %"]}},
    ],
    ids=["tolerance", "speed range"],
)
def test_a_margin_counts_every_variant_of_what_it_is_asked_for(
    tables: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(goals, "_MOST_PLANS", 2)  # a margin, if not the largest
    found = layout(small(**tables), {"cargo.cup.at": None}, within="1.4 s", plans=1)
    assert isinstance(found.plan, Plan) and found.margin is not None
    assert found.plan.certificate.ok and found.plan.duration <= 1.4
    judged = judge(found.plan.trajectory, found.plan.scene).variant_rows
    names = {
        row.known.name for row in judged if row.known is not None and row.known.role in (Role.LIQUID, Role.CONTACT)
    }
    uses = [row.use for row in judged if row.constraint in names - {EndDisplacement.name}]
    assert 0.1 < found.margin <= 1.0 - max(uses) + 1e-9


def test_the_margin_of_a_cycle_is_the_least_of_its_legs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(goals, "_MOST_PLANS", 2)
    found = layout(there_and_back(), {"cargo.*.at": None}, within="5 s", plans=1)
    assert isinstance(found.plan, CyclePlan) and found.margin is not None
    assert found.plan.certificate.ok and found.plan.duration <= 5.0
    margins = [margin_of(leg) for leg in found.plan.legs]
    assert found.margin == pytest.approx(min(one for one in margins if one is not None)) and found.margin > 0.05


@pytest.mark.parametrize(
    ("within", "changes", "message"),
    [
        ("0 s", {}, 'within "0 s" is no time for a motion; give one above 0'),
        ("3 mm", {}, "within: "),
        ("2 s", {"cargo.cup.fixed": True, "cargo.cup.lid": True, "cargo.cup.max_slosh_height": None}, "no margin"),
    ],
)
def test_a_margin_that_is_none_is_refused_in_one_line(within: str, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError) as error:
        layout(load(small(fidelity="full")).changed(changes), {"cargo.cup.at": None}, within=within)
    assert message in str(error.value) and "\n" not in str(error.value)


def test_a_time_that_no_layout_keeps_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(varied, "Planner", Accelerations)
    with pytest.raises(NoSolutionError, match=r'certified motion within "0.9 s"; the last: takes 1.000 s'):
        layout("matrix-liquid", {"cargo.c1.at": None}, within="0.9 s", plans=3)
