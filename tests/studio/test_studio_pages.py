"""What is written in the browser: progress, verdict, certificate, faults; and that no text becomes markup."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from nospill.certification.verdict import Row
from nospill.plans.plan import Plan
from nospill.plans.warnings.record import PlanWarning
from nospill.studio.checks import Fault
from nospill.studio.page_script import field_note
from nospill.studio.pages import (
    certificate_table,
    details,
    fault_list,
    file_note,
    headline,
    obstacle_note,
    warning_list,
)
from nospill.studio.planning import PlanningState, Stage

MARKUP = "<script>alert('1')</script> & \"so\""


@pytest.mark.parametrize(
    "page",
    [
        field_note([MARKUP], ""),
        fault_list([Fault(("tray",), MARKUP, MARKUP)]),
        obstacle_note(MARKUP),
        warning_list([PlanWarning("crest", "c1", MARKUP)]),
        details(PlanningState("failed", message=MARKUP), None, previous=True),
        headline(PlanningState("planning", phase=MARKUP), None, previous=True, before=None),
        file_note(MARKUP, wrong=True),
    ],
)
def test_texts_stay_texts(page: str) -> None:
    assert "<script" not in page and "&lt;script" in page


def test_nothing_to_say_is_nothing_written() -> None:
    assert fault_list([]) == file_note("") == obstacle_note("") == warning_list([]) == ""
    assert not "".join(ET.fromstring(details(PlanningState(), None, previous=True)).itertext())
    assert "nothing is planned yet" in headline(PlanningState(), None, previous=True, before=None)


def test_progress_tells_phase_iteration_duration_and_violation() -> None:
    def page(state: PlanningState) -> str:
        return headline(state, None, previous=True, before=None)

    found = page(PlanningState("planning", 1.24, "solve", 12, 1.8642, 3.21e-4))
    for part in ("solving", "1.2 s", "iteration 12", "duration 1.864 s", "violation 3.2e-04"):
        assert part in found
    assert "waiting for another plan" in page(PlanningState("waiting"))
    assert "stopping" in page(PlanningState("stopping", phase="solve"))


def test_a_field_says_what_holds_while_it_is_empty() -> None:
    note = ET.fromstring(field_note([], "20 s"))
    assert (note.attrib["data-default"], note.attrib["data-wrong"], len(note)) == ("20 s", "0", 0)
    assert ET.fromstring(field_note(["too long"], "20 s")).attrib["data-wrong"] == "1"


def test_an_old_answer_is_never_taken_for_the_new_one(gentle_plan: Callable[..., Plan]) -> None:
    plan = gentle_plan("matrix-rigid")

    def page(stage: Stage, **known: Any) -> ET.Element:
        return ET.fromstring(headline(PlanningState(stage), plan, before=None, **known).replace("&nbsp;", " "))

    def ids(found: ET.Element) -> list[str]:
        return [node.attrib["id"] for node in found.iter() if "id" in node.attrib]

    assert ids(page("planned", previous=False)) == ["nospill-headline", "nospill-verdict", "nospill-status"]
    assert ids(page("idle", previous=True)) == ["nospill-headline", "nospill-previous"]
    failed = page("failed", previous=True)
    assert ids(failed) == ["nospill-headline", "nospill-status", "nospill-previous"]
    assert "no motion" in "".join(failed.itertext()) and "font-size:24px" in failed[0].attrib["style"]
    assert "previous: " in "".join(failed.itertext())
    assert "does not reach" in "".join(page("idle", previous=True, reach=False).itertext())
    assert "2 values to correct" in "".join(page("idle", previous=True, faults=2).itertext())
    assert "Of the previous plan" in certificate_table(plan, previous=True)


def test_many_faults_are_counted() -> None:
    faults = [Fault(("tray",), f"size {number}", "[tray]") for number in range(11)]
    page = fault_list(faults)
    assert "and 3 more" in page and "[tray]: size 0" in page
    assert "liquid height 3" in fault_list([Fault(("cargo",), "liquid_height 3", "")])  # as the label has it


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
    page = headline(PlanningState("planned"), plan, previous=False, before=plan.duration - 0.25)
    assert f"{plan.duration:.3f} s" in page and "(+0.250 s)" in page and ">certified as published<" in page
    assert "changed since" in details(PlanningState(), plan, previous=True, about="two cups")
    assert "two cups" in details(PlanningState(), None, previous=True, about="two cups")
    assert plan.message[:20] in details(PlanningState("planned"), plan, previous=False)
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
    broken_plan = replace(plan, certificate=certificate)
    assert ">not certified<" in headline(PlanningState("planned"), broken_plan, previous=False, before=None)
