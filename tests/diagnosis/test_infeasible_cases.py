"""Of the thirty tasks that cannot be done, one of each sort; and that the bases of all are what they are said to be."""

from __future__ import annotations

import json

import pytest

from benchmarks.infeasible import run as infeasible
from benchmarks.infeasible.cases import BASES, CASES, Case, Table, spoiled_table
from nospill.errors import Reason
from nospill.scenario import scene_from_table

ONE_OF_EACH = (
    "over the tray's edge",
    "starts out of reach",
    "turn beyond the wrist",
    "approach from outside the limits",
    "slippery tray",
    "bowl still too soon",
    "loaded approach",
    "no time to solve",
)


def case_of(name: str) -> Case:
    return next(case for case in CASES if case.name == name)


def test_there_are_thirty_of_all_four_kinds() -> None:
    assert len(CASES) == len({case.name for case in CASES}) == 30
    kinds = [case.kind for case in CASES]
    assert {kind: kinds.count(kind) for kind in set(kinds)} == {
        "at rest": 5,
        "robot": 10,
        "in motion": 14,
        "not converged": 1,
    }


@pytest.mark.parametrize("name", BASES)
def test_the_bases_are_scenarios(name: str) -> None:
    assert scene_from_table(BASES[name], name="base").cargo


@pytest.mark.slow
@pytest.mark.parametrize("name", ONE_OF_EACH)
def test_the_reason_is_the_built_one_and_every_change_is_enough(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def coarse(case: Case) -> Table:
        table = spoiled_table(case)
        return table | {"planning": {"intervals": 30} | table.get("planning", {})}

    monkeypatch.setattr(infeasible, "spoiled_table", coarse)
    line = infeasible.run(case_of(name))
    assert line["named"], line["said"]
    assert "\n" not in line["said"]
    assert line["changes"]
    for change in line["changes"]:
        assert change["duration"] is not None, change
        assert change["text"] in line["said"]


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({}, True),
        ({"kind": "in motion"}, False),
        ({"constraint": "joint position"}, False),
        ({"subject": "ur10e"}, False),
        ({"at_s": 0.3}, False),
        ({"at_s": None}, False),
    ],
)
def test_a_reason_is_named_only_where_all_of_it_is_right(changed: dict[str, object], named: bool) -> None:
    right: dict[str, object] = {"kind": "robot", "constraint": "reach", "subject": "ur5e", "at_s": 0.0}
    told = Reason(**(right | changed))  # type: ignore[arg-type][reportArgumentType]
    assert infeasible.is_named(case_of("starts out of reach"), told) is named
    assert not infeasible.is_named(case_of("starts out of reach"), None)


def test_the_report_counts_what_was_found() -> None:
    good = {"name": "a", "kind": "robot", "constraint": "reach", "said": "out of reach", "named": True, "seconds": 1.0}
    line = good | {"changes": [{"place": "p", "text": "base 1 mm elsewhere", "duration": 1.25, "why": ""}]}
    vain = good | {"name": "b", "named": False, "changes": [{"place": "p", "text": "x", "duration": None, "why": "no"}]}
    page = infeasible.report([line, vain, good | {"changes": []}])
    assert "| built reason named | 2 of 3 |" in page
    assert "| planned and certified with the first change | 1 of 3 |" in page
    assert "| all suggested changes that are enough | 1 of 2 |" in page
    assert "base 1 mm elsewhere: 1.25" in page and "x: not enough" in page and "**no**" in page


@pytest.mark.slow
def test_one_case_is_printed_as_json(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("sys.argv", ["run", "--only", "over the tray's edge"])
    infeasible.main()
    assert json.loads(capsys.readouterr().out)["named"] is True
