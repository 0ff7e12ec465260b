"""What is written in the browser: progress, verdict, certificate, faults; and that no text becomes markup."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace

import pytest

from nospill.judge.verdict import Row
from nospill.plans.plan import Plan
from nospill.studio.checks import Fault
from nospill.studio.pages import certificate_table, fault_list, fault_note, file_note, progress_note, verdict
from nospill.studio.planning import PlanningState

MARKUP = "<script>alert('1')</script> & \"so\""


@pytest.mark.parametrize(
    "page",
    [
        fault_note([MARKUP]),
        fault_list([Fault(("tray",), MARKUP, MARKUP)]),
        progress_note(PlanningState("failed", message=MARKUP)),
        progress_note(PlanningState("planning", phase=MARKUP)),
        file_note(MARKUP, wrong=True),
    ],
)
def test_texts_stay_texts(page: str) -> None:
    assert "<script" not in page and "&lt;script" in page


def test_nothing_to_say_is_nothing_written() -> None:
    assert fault_note([]) == fault_list([]) == file_note("") == progress_note(PlanningState()) == ""


def test_progress_tells_phase_iteration_duration_and_violation() -> None:
    page = progress_note(PlanningState("planning", 1.24, "solve", 12, 1.8642, 3.21e-4))
    for part in ("solving", "1.2 s", "iteration 12", "duration 1.864 s", "violation 3.2e-04"):
        assert part in page
    assert "waiting for another plan" in progress_note(PlanningState("waiting"))
    assert "stopping" in progress_note(PlanningState("stopping", phase="solve"))


def test_many_faults_are_counted() -> None:
    faults = [Fault(("tray",), f"size {number}", "[tray]") for number in range(11)]
    page = fault_list(faults)
    assert "11 values to correct" in page and "and 3 more" in page and "[tray]: size 0" in page
    assert "1 value to correct" in fault_list(faults[:1])


@pytest.mark.slow
def test_the_certificate_is_shown_whole_and_the_worst_row_first(example_plan: Callable[[str], Plan]) -> None:
    plan = example_plan("matrix-rigid")
    table = certificate_table(plan)
    body = ET.fromstring(table).find(".//tbody")
    assert body is not None and len(body) == sum(not row.of_record for row in plan.certificate.rows)
    uses = [float(text) for row in body for text in re.findall(r"^([\d.]+) %$", row[2].text or "")]
    assert uses == sorted(uses, reverse=True) and max(uses) <= 100.0
    worst = plan.certificate.worst
    assert [cell.text for cell in body[0]][:2] == [worst.constraint, worst.subject]
    page = verdict(plan, before=plan.duration - 0.25, stale=False)
    assert f"{plan.duration:.3f} s" in page and "(+0.250 s)" in page and ">certified as published<" in page
    assert "changed since" not in page and "changed since" in verdict(plan, before=None, stale=True)
    assert float(re.findall(r"data-duration='([^']*)'", page)[0]) == plan.duration


@pytest.mark.slow
def test_a_broken_row_is_marked(example_plan: Callable[[str], Plan]) -> None:
    plan = example_plan("matrix-rigid")
    broken = Row("slip", "<c1>", "1", 1.0, 1.0004, -0.0004, 0.5, False)
    certificate = replace(plan.certificate, ok=False, rows=(*plan.certificate.rows, broken))
    table = certificate_table(replace(plan, certificate=certificate))
    first = ET.fromstring(table).find(".//tbody/tr")
    assert first is not None and [cell.text for cell in first][:2] == ["slip", "<c1>"]
    assert "font-weight:600" in first.attrib["style"] and "100.1 %" in table
    assert ">not certified<" in verdict(replace(plan, certificate=certificate), before=None, stale=False)
