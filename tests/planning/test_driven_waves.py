"""Waves of second order as states of the problem: which liquids have them, and what the flow asks for then."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from nospill import plan
from nospill.certification.verdict import Row
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.scene_parameters import structure_of
from nospill.planning import refinement, shortening
from nospill.planning.active_set import ActiveSet
from nospill.planning.candidate import Candidate
from nospill.planning.driven_waves import (
    as_carried,
    beyond_backoff_of_flow,
    far_over,
    relaxed_by_flow,
    smooth_enough,
    steadier_backoff,
)
from nospill.planning.refinement import solve_from
from nospill.planning.task import Task
from nospill.scenario.examples import example_path
from nospill.scenario.loading import load, read_scenario

_NONLINEAR = {"motion.residual_height": "nonlinear"}


def test_upright_cups_and_boxes_have_them_with_their_modes() -> None:
    scene = read_scenario("mixed-tray")
    asked = scene.changed(_NONLINEAR)
    task = Task.of(asked)
    assert task.driven == Task.of(scene).driven == {"cup", "mug", "box"}
    assert not Task.of(scene.changed({"motion.residual_height": "linear"})).driven
    assert not Task.of(scene.changed({"motion.residual_height": "second order"})).driven
    refined = task.problem_scene(task.first_members, ["cup", "box"], 2)
    found = {cargo.name: item.driven for cargo, item in zip(refined.cargo, structure_of(refined).objects, strict=True)}
    assert found == {"cup": "cup", "mug": "", "box": "box that turns", "bottle": ""}
    first = task.problem_scene(task.first_members, [], 2)
    assert not any(item.driven for item in structure_of(first).objects)
    assert not Task.of(replace(asked, motion=replace(asked.motion, stop=True))).driven
    assert not replace(task, smooth_first=True).driven
    alone = replace(task, smooth_alone=True)
    assert not alone.driven and not alone.may_be_driven
    assert alone.judged_scene(["cup"]).motion.residual_height == "second order"


def test_a_rough_motion_is_judged_to_the_second_order() -> None:
    asked = read_scenario("mixed-tray").changed(_NONLINEAR)
    task = Task.of(asked)
    assert task.judged_scene([]).motion.residual_height == "second order"
    assert task.judged_scene(["cup"]) is asked
    one_mode = asked.changed({"planning.slosh_modes": 1})
    assert Task.of(one_mode).judged_scene([]) is one_mode


def _left(use: float, subject: str = "cup") -> Row:
    limit = 0.003
    return Row("residual height", subject, "m", limit, use * limit, (1 - use) * limit, 0.0, use <= 1.0, "", 0.002)


def test_smoothness_comes_first_where_much_is_left() -> None:
    assert far_over([_left(6.5)], {"cup"}) and not far_over([_left(6.5)], {"mug"}) and not far_over([_left(5)], {"cup"})
    assert smooth_enough([_left(2.5)], {"cup"}) and not smooth_enough([_left(3.5)], {"cup"})


def test_jerks_weigh_more_where_back_off_is_not_enough() -> None:
    def over(use: float, backoff: float) -> float:
        row = _left(use)
        return beyond_backoff_of_flow([row], {"cup"}, {row.id: backoff})

    assert over(0.9, 0.9) == over(1.1, 0.5) == 0.0
    assert over(1.1, 0.75) == pytest.approx(1.1, rel=1e-3)
    assert over(1.5, 0.0) == pytest.approx(1.5, rel=1e-2)
    assert beyond_backoff_of_flow([_left(9.0)], {"mug"}, {}) == 0.0


def test_with_them_the_rows_that_are_over_get_back_off() -> None:
    over, under = _left(1.5), _left(0.9, "mug")
    backoff = {over.id: 0.5, under.id: 0.5, RowId("slosh height", "cup"): 0.1}
    raised = steadier_backoff([over, under], {"cup", "mug"}, backoff)
    assert raised == {**backoff, over.id: pytest.approx(0.625)}
    assert steadier_backoff([over], {"cup"}, {over.id: 0.8}) == {over.id: 0.8}


def test_crests_get_no_more_back_than_what_is_left_allows() -> None:
    near, far, full = _left(0.93), _left(0.3, "mug"), _left(0.99, "jug")
    crest = {name: RowId("slosh height", name) for name in ("cup", "mug", "jug", "box")}
    backoff = dict.fromkeys(crest.values(), 0.3)
    relaxed = dict.fromkeys(crest.values(), 0.1)
    found = relaxed_by_flow(relaxed, [near, far, full], {"cup", "mug", "jug"}, backoff)
    room = (1.0 - found[crest["cup"]]) / 0.7
    assert 0.9 < 0.93 * room**3 < 0.95  # what a finer grid may find is in it
    assert found[crest["mug"]] == found[crest["box"]] == 0.1 and found[crest["jug"]] == 0.3


def test_their_row_is_one_like_others() -> None:
    assert as_carried(_left(1.1)).linear_value is None
    crest = Row("slosh height", "cup", "m", 0.015, 0.016, -0.001, 0.5, False, "", 0.012)
    assert as_carried(crest) is crest


@pytest.mark.slow
def test_the_flow_keeps_its_limit_in_a_motion_hardly_longer_than_with_linear_heights() -> None:
    document = tomllib.loads(example_path("matrix-liquid-tilt").read_text())
    scene = load({**document, "cargo": document["cargo"][:1]}).changed(
        {"planning.intervals": 25, "planning.slosh_modes": 3}
    )
    found = {order: plan(scene.changed({"motion.residual_height": order})) for order in ("linear", "nonlinear")}
    assert all(item.certificate.ok for item in found.values())
    row = next(item for item in found["nonlinear"].certificate.rows if item.id == RowId(ResidualHeight.name, "c1"))
    assert row.linear_value is not None and np.isfinite(row.worst_value)
    longer = found["nonlinear"].trajectory.end_time / found["linear"].trajectory.end_time
    assert longer < 1.06


@pytest.mark.slow
@pytest.mark.parametrize("end", ["published", "still"])
def test_modes_that_are_to_stand_still_at_the_end_do(end: str) -> None:
    """Those that the problem has not join it, as with other heights: no back-off stills them."""
    scene = load("bracket-tray")
    one = {"cargo": scene.source["cargo"][:1], "planning.intervals": 20, "motion.end": end}
    found = plan(scene.changed(_NONLINEAR | one))
    assert found.certificate.ok


@pytest.mark.slow
def test_where_their_problem_has_no_answer_smoothness_stills_them(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = []

    def without_answer(active: ActiveSet, *args: Any, **options: Any) -> Candidate | None:
        tried.append(bool(active.task.driven & active.refined))
        return None if tried[-1] else solve_from(active, *args, **options)

    for module in (refinement, shortening):
        monkeypatch.setattr(module, "solve_from", without_answer)
    monkeypatch.setattr(refinement, "_with_modes", lambda *_: None)
    scene = load("bracket-tray")
    one = {"cargo": scene.source["cargo"][:1], "planning.intervals": 20, "planning.slosh_modes": 3}
    found = plan(scene.changed(_NONLINEAR | one))
    assert any(tried) and not tried[-1] and found.certificate.ok
    assert "by smoothness" in found.report.fallbacks[0]
