"""What callers ask for from Python: names of scenarios, altered scenes, one name where several are wanted."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nospill as ns
from nospill.errors import NospillError, ScenarioError
from nospill.planning.request import ignored_constraints, requested_scene
from nospill.plans.plan import Plan
from nospill.scenario import read_scenario


def test_a_scenario_goes_by_its_name(tmp_path: Path) -> None:
    scene = read_scenario("matrix-liquid")
    (tmp_path / "scenario.toml").write_text(scene.text(), encoding="utf-8")
    for named in ("matrix-liquid", tmp_path / "scenario.toml", tmp_path, scene.source, scene):
        assert requested_scene(named).name == "matrix-liquid"


def test_one_name_may_stand_alone() -> None:
    for asked in ("slosh height", ["slosh height"]):
        assert ignored_constraints(asked, read_scenario("matrix-liquid")) == {"slosh height"}


SCENE = read_scenario("matrix-liquid")
COPY = replace(SCENE, cargo=SCENE.cargo[:1])


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: ns.plan("nowhere.toml"), "nowhere.toml: no such file"),
        (lambda: ns.plan(3), "a scenario is a TOML file"),  # type: ignore[arg-type]
        (lambda: ns.plan(COPY), r"matrix-liquid: this scene is a copy .*; use scene\.changed\("),
        (lambda: ns.Planner().plan(COPY), r"matrix-liquid: this scene is a copy .*; use scene\.changed\("),
        (lambda: ns.plan(SCENE, ignore="slosh heigth"), 'no constraint; there are: .*; did you mean "slosh height"'),
        (lambda: ns.plan(SCENE, ignore=3), r"ignore: 3 is no list of constraints"),  # type: ignore[arg-type]
        (lambda: ns.plan(SCENE, warm="out/tea"), r"an earlier plan is needed here, as load_plan"),  # type: ignore[arg-type]
        (lambda: ns.Planner("x.toml"), r"not 'x.toml' of type str; a scenario goes to"),  # type: ignore[arg-type]
        (lambda: ns.certify(np.zeros((9, 6)), SCENE), r"ndarray of shape \(9, 6\): for times and"),  # type: ignore[arg-type]
    ],
)
def test_what_is_wanted_is_said_in_one_sentence(call: Any, told: str) -> None:
    with pytest.raises(ScenarioError, match=told) as caught:
        call()
    assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_a_plan_is_no_scene_and_a_name_no_scene_to_judge_by(gentle_plan) -> None:
    plan: Plan = gentle_plan("matrix-liquid", 1)
    with pytest.raises(NospillError, match=r"its scene is plan\.scene"):
        ns.plan(plan)  # type: ignore[arg-type]
    with pytest.raises(NospillError, match=r"not by a value of type str"):
        ns.certify(plan.trajectory, "matrix-liquid")  # type: ignore[arg-type]
