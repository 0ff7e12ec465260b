"""A constraint of a user's own class, from planning to the report, and without its class."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import nospill as ns
from nospill.certification.certificate import judge
from nospill.cli import app
from nospill.errors import ScenarioError
from nospill.export import EXPORTERS
from nospill.margins import margins
from nospill.plans.handover import hand_over
from nospill.plans.plan import Plan
from nospill.plots.evidence import evidence_of
from nospill.report.task import task_table
from tests.own_limits import Sideways

pytestmark = pytest.mark.slow

MOST = 1.5


LIMIT = Sideways(MOST, objects=("c1",))
SCENE = ns.load("matrix-liquid").changed({"planning.intervals": 40})


@pytest.fixture(scope="module")
def limited() -> Plan:
    return ns.plan(SCENE, constraints=[LIMIT])


@pytest.fixture(scope="module")
def saved(limited: Plan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("own") / "plan"
    limited.save(folder)
    return folder


def rows_of(certificate: ns.Certificate, name: str = "sideways") -> dict[str, float]:
    return {row.subject: row.use for row in certificate.rows if row.constraint == name}


def test_it_binds_on_the_object_that_it_names(limited: Plan, example_plan: Any) -> None:
    free = example_plan("matrix-liquid")
    assert limited.certificate.ok and limited.duration > 1.1 * free.duration
    assert list(rows_of(limited.certificate)) == ["c1"]
    assert 0.985 < rows_of(limited.certificate)["c1"] <= 1.0
    assert "sideways of c1 is at its limit" in limited.limiting_text
    again = ns.certify(free.trajectory, free.scene, constraints=[LIMIT])
    assert not again.ok and again.worst.constraint == "sideways"


def test_what_the_judge_finds_is_the_specific_force_of_the_motion(limited: Plan) -> None:
    judgement = judge(limited.trajectory, limited.scene)
    (trace,) = [item for item in judgement.traces if item.constraint == "sideways"]
    played, place = judgement.replay, limited.scene.cargo[0].place
    omega, alpha, force = (played.body[rows].T for rows in (slice(0, 3), slice(3, 6), slice(6, 9)))
    at = force + np.cross(alpha, place) + np.cross(omega, np.cross(omega, place))
    np.testing.assert_allclose(trace.value, np.linalg.norm(at[:, :2], axis=1), atol=1e-9)


def test_figures_and_report_show_it(limited: Plan) -> None:
    evidence = evidence_of(limited, judge(limited.trajectory, limited.scene))
    assert "sideways" in evidence.by_constraint(ns.EvaluationPoint.OBJECT)
    assert any(item.row.constraint == "sideways" for item in evidence.limiting)
    stated = "Sideways(most=1.5, objects=['c1'], name='sideways')"
    assert ("limit: sideways", stated) in task_table(limited.scene).rows


def test_another_number_is_planned_warm(limited: Plan) -> None:
    planner = ns.Planner(limited, constraints=[replace(LIMIT, most=1.6)])
    looser = planner.plan(SCENE)
    assert looser.report.starts.tried == 1
    assert looser.certificate.ok and looser.duration < limited.duration
    assert looser.duration == pytest.approx(ns.plan(SCENE, constraints=planner.constraints).duration, rel=1e-3)
    free = planner.plan(SCENE, constraints=[])
    assert not rows_of(free.certificate) and free.duration < looser.duration


def test_the_folder_names_it_and_nothing_is_certified_without_it(saved: Path) -> None:
    (entry,) = json.loads((saved / "summary.json").read_text())["constraints"]
    values = {"most": MOST, "objects": ["c1"], "name": "sideways"}
    assert entry == {"name": "sideways", "class": "Sideways", "values": values}
    plan = ns.load_plan(saved)
    assert plan.status == "uncertified" and not plan.certificate.ok and not rows_of(plan.certificate)
    assert (
        'the constraint "sideways" was not judged' in plan.message and "constraints=[Sideways(most=1.5" in plan.message
    )
    assert not ns.certify(plan.trajectory, plan.scene).ok
    checked = CliRunner().invoke(app, ["check", str(saved)])
    assert checked.exit_code == 1
    assert 'Not certified: the constraint "sideways" was not judged' in " ".join(checked.stderr.split())


def test_its_scenario_is_not_planned_again_without_it(saved: Path) -> None:
    result = CliRunner().invoke(app, ["plan", str(saved)])
    assert result.exit_code == 2
    assert "limits of your own classes (sideways)" in result.stderr and "scenario.toml to plan without" in result.stderr


def test_a_plan_saved_again_without_the_class_still_names_it(saved: Path, tmp_path: Path) -> None:
    ns.load_plan(saved).save(tmp_path / "again")
    assert ns.load_plan(tmp_path / "again").scene.unjudged == ns.load_plan(saved).scene.unjudged != ()


def test_with_the_class_all_is_judged(saved: Path) -> None:
    plan = ns.load_plan(saved, constraints=[LIMIT])
    assert plan.certificate.ok and rows_of(plan.certificate)["c1"] > 0.985
    tighter = ns.load_plan(saved, constraints=[replace(LIMIT, most=0.9 * MOST)])
    assert not tighter.certificate.ok and tighter.certificate.worst.constraint == "sideways"
    other = ns.load_plan(saved, constraints=[])
    assert not other.certificate.ok and other.certificate.unjudged


def test_exports_are_judged_by_it_and_not_certified_without(limited: Plan, saved: Path, tmp_path: Path) -> None:
    done = hand_over(limited, EXPORTERS["lab-csv"], tmp_path / "with.csv")
    assert done.certificate.ok and rows_of(done.certificate)["c1"] > 0.985
    bare = hand_over(ns.load_plan(saved), EXPORTERS["lab-csv"], tmp_path / "without.csv")
    assert not bare.certificate.ok and bare.certificate.unjudged


def test_margins_draw_it_too_and_refuse_without(limited: Plan, saved: Path) -> None:
    report = margins(limited, samples=20)
    (risk,) = [item for item in report.constraints if item.constraint == "sideways"]
    assert risk.largest_use == pytest.approx(rows_of(limited.certificate)["c1"], abs=0.05)
    with pytest.raises(ScenarioError, match='cannot be studied: the constraint "sideways" was not judged'):
        margins(ns.load_plan(saved), samples=20)


def test_a_scene_with_one_that_is_not_at_hand_is_not_planned(saved: Path) -> None:
    scene = ns.load_plan(saved).scene
    with pytest.raises(ScenarioError, match=r'saved with the constraint "sideways", .* constraints=\[\] for none'):
        ns.plan(scene)
