"""The report's section on stops: the table of the plan folder, of this plan and whole, or a line that says why not."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from nospill.errors import PlanFolderError
from nospill.plans.names import STOPS_FILE
from nospill.plans.plan import Plan
from nospill.report import Report, read_stopping_table
from nospill.report.page import html_page


def _record(plan: Plan) -> dict[str, object]:
    instants = [0.1, 0.2]
    return {
        "duration_s": plan.duration,
        "longest_stop": {"t_s": 0.2, "stops_in_s": 0.4},
        "stops": [{"t_s": t, "stops_in_s": 2.0 * t, "left_s": 1.0 - t} for t in instants],
        "controller": [
            {"t_s": t, "kind": kind, "text": f"crest <{kind}>"} for t in instants for kind in ("joints", "path")
        ],
    }


def test_stops_stand_beside_the_controller_s_own(slow_plan: Plan, slow_report: Report, folder: Path) -> None:
    assert read_stopping_table(folder, slow_plan) is None
    (folder / STOPS_FILE).write_text(json.dumps(_record(slow_plan)), encoding="utf-8")
    table = read_stopping_table(folder, slow_plan)
    assert table is not None
    assert table.rows[1] == ("0.20", "0.400", "0.800", "crest <joints>", "crest <path>")
    assert "no safety function" in table.note
    page = html_page(replace(slow_report, stops=table), {})
    assert "<h2>If it is stopped</h2>" in page and "crest &lt;joints&gt;" in page
    assert "If it is stopped" not in html_page(slow_report, {})


def test_stops_of_another_plan_and_damaged_ones_are_not_shown(slow_plan: Plan, folder: Path) -> None:
    (folder / STOPS_FILE).write_text(json.dumps(_record(slow_plan) | {"duration_s": 9.0}), encoding="utf-8")
    table = read_stopping_table(folder, slow_plan)
    assert table is not None and "another plan" in table.rows[0][0]
    (folder / STOPS_FILE).write_text('{"duration_s": ', encoding="utf-8")
    with pytest.raises(PlanFolderError, match="nospill stops DIR"):
        read_stopping_table(folder, slow_plan)
