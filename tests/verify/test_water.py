"""A plan's liquids by their nonlinear flow: the report, its verdict, and the command."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from nospill.certification.certificate import judge
from nospill.cli import app
from nospill.plans.plan import Plan
from nospill.plans.records import PlanningReport, motion_maxima
from nospill.verify import CupReport, Peak, WaterReport, verify_water
from tests.builders import with_few_speeds


def gentle(smooth_motion: Callable[..., Any], cups: int) -> Plan:
    """A gentle motion with some cups, made without a solver."""
    made = smooth_motion("matrix-liquid", cargo=cups, stretch=1.0)
    judgement = judge(made.trajectory, made.scene)
    report = PlanningReport.empty()
    motion = Plan(made.scene, made.trajectory, judgement.certificate, motion_maxima(judgement, made.scene), report)
    return with_few_speeds(motion)


@pytest.fixture(scope="module")
def plan(smooth_motion: Callable[..., Any]) -> Plan:
    return gentle(smooth_motion, cups=2)


@pytest.fixture(scope="module")
def report(plan: Plan) -> WaterReport:
    return verify_water(plan)


def test_gentle_water_is_as_certified(plan: Plan, report: WaterReport) -> None:
    assert [cup.name for cup in report.cups] == [cargo.name for cargo in plan.scene.cargo]
    for cup in report.cups:
        # one mode in the certificate, all of them here
        assert cup.linear.value == pytest.approx(cup.certified.value, rel=0.25)
        assert cup.full.value == pytest.approx(cup.second.value, rel=0.02)
        assert cup.crests.doubt is None
        assert np.max(cup.history[1]) == cup.certified.value
    assert report.ok and report.message == "The water keeps its limits."


def _changed(cup: CupReport, **limits: Any) -> WaterReport:
    return WaterReport((replace(cup, **limits),), (), "trajectory")


def test_water_over_its_limit_is_said_with_figure_and_time(report: WaterReport) -> None:
    cup = report.cups[0]
    found = _changed(cup, limit=0.8 * cup.full.value, residual_limit=None)
    over = 0.2e3 * cup.full.value
    assert not found.ok
    assert found.message == (
        f"{cup.name}: crest of {1e3 * cup.full.value:.1f} mm at {cup.full.at_s:.2f} s, {over:.1f} mm over the limit."
    )


def test_what_is_left_after_the_end_is_held_against_its_limit(report: WaterReport) -> None:
    cup = report.cups[0]
    left = cup.residual[2]
    assert left is not None
    assert not _changed(cup, residual_limit=0.5 * left).ok
    assert _changed(cup, residual_limit=0.95 * left).ok  # less than the flow's own error


def test_a_flow_that_breaks_down_is_no_verdict(report: WaterReport) -> None:
    cup = report.cups[0]
    broken = _changed(cup, crests=replace(cup.crests, full=cup.crests.full[:100]))
    assert not broken.ok
    assert "break down at 0.20 s" in broken.message and "no verdict" in broken.message
    assert broken.to_dict()["liquids"][0]["residual_full_mm"] is None
    assert broken.verdict == "the flow is in doubt: no verdict" and report.verdict == "the water keeps its limits"
    assert _changed(cup, limit=0.5 * cup.full.value).verdict == "the water does not keep every limit"


def test_records_are_json(report: WaterReport) -> None:
    table = json.loads(json.dumps(report.to_dict(), allow_nan=False))
    assert table["liquids"][0]["full_mm"] == pytest.approx(1e3 * report.cups[0].full.value)
    assert isinstance(report.cups[0].second, Peak)


def test_command_follows_the_water_and_draws_it(smooth_motion: Callable[..., Any], tmp_path: Path) -> None:
    gentle(smooth_motion, cups=1).save(tmp_path / "plan")
    done = CliRunner().invoke(app, ["verify", str(tmp_path / "plan"), "--water", "--save"], prog_name="nospill")
    assert done.exit_code == 0, done.output
    assert "the water keeps its limits" in done.stdout
    assert json.loads((tmp_path / "plan.water.json").read_text(encoding="utf-8"))["ok"] is True
    assert (tmp_path / "plan.water.png").stat().st_size > 10_000
    refused = CliRunner().invoke(app, ["verify", str(tmp_path / "plan"), "--water", "--video", str(tmp_path / "a.mp4")])
    assert refused.exit_code == 2
    assert "leave out --water or --video" in refused.output
