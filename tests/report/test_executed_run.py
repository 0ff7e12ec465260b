"""The section of a report on what was executed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from nospill.cli import app
from nospill.execution.executed import executed
from nospill.plans.plan import Plan
from nospill.report import make_report
from nospill.report.executed_run import executed_run
from nospill.report.writing import pdf_tables
from tests.execution.logs import log_of, write_log

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def plan(gentle_plan: Callable[..., Plan]) -> Plan:
    return gentle_plan("matrix-liquid", cargo=1)


def test_planned_and_executed_stand_side_by_side(plan: Plan) -> None:
    found = executed(log_of(plan), plan.scene, plan=plan)
    shown = executed_run(found)
    # with noise the end of the motion is known within milliseconds, and so is the swing there
    assert shown.ok  # no row fails
    assert shown.verdict == "executed: cannot be told at this noise"
    assert "2000 Hz" in shown.detail or "Hz" in shown.detail
    slosh = next(row for row in shown.rows.rows if row[0] == "slosh height")
    assert slosh[2] != "-"
    assert slosh[4].startswith("± ")
    assert "Tracking: at most" in shown.rows.note
    assert shown.heights.rows[0][0] == "c1"
    assert shown.figure.startswith("<?xml")
    assert executed_run(found) == shown
    report = make_report(plan, executed=found)
    assert [table.title for table in pdf_tables(report)[1][:2]] == ["Executed", "Executed: peaks of the liquids"]


def test_the_command_puts_it_on_the_page(plan: Plan, tmp_path: Path) -> None:
    plan.save(tmp_path / "plan")
    log = write_log(log_of(plan, noise=0.0, jitter=0.0), tmp_path / "run.csv")
    page = tmp_path / "page.html"
    result = CliRunner().invoke(app, ["report", str(tmp_path / "plan"), "--executed", str(log), "-o", str(page)])
    assert result.exit_code == 0, result.output
    text = page.read_text(encoding="utf-8")
    assert "EXECUTED: CERTIFIED AS PUBLISHED" in text
    assert "<h2>Executed</h2>" in text
