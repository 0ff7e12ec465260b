"""Runs of a sweep: whatever becomes of a process there is a line, and a run goes on where it stopped."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

from nospill.errors import PlanFolderError, ScenarioError
from nospill.sweeps import groups
from nospill.sweeps.definition import define_sweep
from nospill.sweeps.lines import lines_file, read_lines
from nospill.sweeps.processes import WorkerPool
from nospill.sweeps.run import LINES_FILE, SweepProgress, run_sweep
from nospill.sweeps.sweeping import sweep
from tests.sweeps.stand_in import stand_ins

BASE = "matrix-rigid"


@pytest.fixture
def pool(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> WorkerPool:
    found = stand_ins(tmp_path_factory.mktemp("program"))
    monkeypatch.setattr(groups, "WORKERS", found)
    monkeypatch.setattr("nospill.sweeps.run.WORKERS", found)
    return found


def same(lines: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Lines without what differs from run to run, in one order."""
    return sorted(
        ({key: value for key, value in line.items() if key not in ("plan_s", "nospill")} for line in lines),
        key=lambda line: (line["key"], line["cold"]),
    )


def test_whatever_a_process_does_is_a_line_with_its_reason(pool: WorkerPool) -> None:
    axes = {"tray.friction": [0.3, 0.31, 0.33, 0.34, 0.35, 0.36]}
    # whatever ends by itself has all the time that a busy machine needs
    found = sweep(BASE, axes, time_limit=60.0, memory_limit="300 MB")
    endings = {line.values["tray.friction"]: (line.ending, line.reason) for line in found.lines}
    assert endings == {
        0.3: ("planned", ""),
        0.31: ("crash", "the planning process ended with signal 9"),
        0.33: ("out of memory", endings[0.33][1]),
        0.34: ("crash", "the planning process ended with exit code 1: ValueError: no such thing"),
        0.35: ("no motion", "No motion found: slip of c1"),
        0.36: ("planned", ""),
    }
    assert endings[0.33][1].endswith("MB of memory were in use; at most 300 MB are allowed")
    assert found.best is not None and found.best.values == {"tray.friction": 0.36}
    # the head, in the middle, has no plan to start from
    assert all(not line.warm_from for line in found.lines)


def test_a_process_without_an_answer_is_a_line_after_its_time(pool: WorkerPool) -> None:
    found = sweep(BASE, {"tray.friction": [0.32]}, time_limit=1.0)
    assert [(line.ending, line.reason) for line in found.lines] == [("out of time", "no answer within 1 s")]


def test_lines_are_the_same_with_any_number_of_processes_and_a_run_goes_on(pool: WorkerPool, tmp_path: Path) -> None:
    definition = define_sweep(
        BASE, {"tray.friction": {"from": 0.4, "to": 0.6, "count": 20}, "motion.tilt": ["fixed", "free"]}
    )
    one = run_sweep(definition, folder=tmp_path / "one", jobs=1)
    two = run_sweep(definition, folder=tmp_path / "two", jobs=2)
    whole = read_lines(tmp_path / "one" / LINES_FILE)
    assert same(whole) == same(read_lines(tmp_path / "two" / LINES_FILE))
    assert len({line["nospill"] for line in whole}) == 1  # the pid of the stand-in: a process plans point after point
    assert one.csv() == two.csv() and len(one.lines) == 40
    assert len(one.cold) == 10 + (one.best in [line for line in one.lines if line.warm_from])
    assert one.cold_text.endswith("agree within 0.1 %")
    # a run that was killed in the middle of a line
    half = tmp_path / "half" / LINES_FILE
    half.parent.mkdir()
    text = (tmp_path / "one" / LINES_FILE).read_bytes()
    half.write_bytes(text[: len(text) // 2])
    reports: list[SweepProgress] = []
    run_sweep(definition, folder=half.parent, jobs=2, progress=reports.append)
    assert same(read_lines(half)) == same(whole)
    assert reports[0].total == 40 and 0 < reports[0].done < 40 and reports[0].left_s is None
    assert reports[-1].done == 40 and reports[-1].again
    before = half.read_bytes()
    run_sweep(definition, folder=half.parent)
    assert half.read_bytes() == before


def test_points_are_planned_again_where_the_machine_was_to_blame_and_that_is_asked(
    pool: WorkerPool, tmp_path: Path
) -> None:
    axes = {"tray.friction": [0.31, 0.35, 0.4]}
    sweep(BASE, axes, folder=tmp_path)
    count = len(read_lines(tmp_path / LINES_FILE))
    sweep(BASE, axes, folder=tmp_path)
    assert len(read_lines(tmp_path / LINES_FILE)) == count
    again = sweep(BASE, axes, folder=tmp_path, retry=True)
    assert len(read_lines(tmp_path / LINES_FILE)) == count + 1 and again.endings["crash"] == 1


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"axes": {"tray.fricton": [0.3]}}, r'axis tray.fricton: .*did you mean "?friction'),
        ({"axes": {"cargo.nobody.mass": [0.3]}}, 'axis cargo.nobody.mass: .*no object on the tray is called "nobody"'),
        ({"axes": {}}, "axes: there is none"),
        ({"axes": {"tray.friction": []}}, "axis tray.friction: is empty"),
        ({"columns": {"x": "y"}}, "column x: there is no column y"),
        ({"goals": {"duration": "least"}}, "did you mean duration_s"),
        ({"goals": {"duration_s": "low"}}, 'must be "least" or "greatest"'),
        ({"time_limit": "1 m"}, 'time_limit: "1 m" is a length'),
        ({"time_limit": 0}, "must be above 0"),
        ({"memory_limit": "4"}, "give MB or GB"),
        ({"seed": -1}, "seed = -1 must be a whole number"),
        ({"jobs": 0}, "jobs = 0 must be a whole number from 1"),
    ],
)
def test_what_is_no_sweep_is_refused_before_anything_is_planned(options: dict[str, Any], words: str) -> None:
    with pytest.raises(ScenarioError, match=words) as caught:
        given: dict[str, Any] = {"axes": {"tray.friction": [0.3]}} | options
        sweep(BASE, **given)
    assert "\n" not in str(caught.value)


def test_a_value_that_does_not_fit_is_no_unknown_key() -> None:
    definition = define_sweep(BASE, {"tray.friction": [-1.0, 0.3]})
    assert [point.values["tray.friction"] for point in definition.points] == [-1.0, 0.3]


def test_half_a_line_is_cut_off_and_a_full_disk_leaves_whole_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "lines.jsonl"
    file.write_bytes(b'{"n": 0}\n{"n": 1, "ki')
    write = os.write
    with lines_file(file) as lines:
        assert lines.known == [{"n": 0}]
        lines.append({"n": 2})
        with pytest.raises(PlanFolderError, match="another run is writing into it"), lines_file(file):
            pass
        monkeypatch.setattr(os, "write", lambda descriptor, data: write(descriptor, data[:5]))
        with pytest.raises(PlanFolderError, match="only a part"):
            lines.append({"n": 3})
        monkeypatch.undo()
        lines.append({"n": 4})
    assert read_lines(file) == [{"n": 0}, {"n": 2}, {"n": 4}]
    file.write_text("[1]\n")
    with pytest.raises(PlanFolderError, match="no file of JSON objects"):
        read_lines(file)
    file.write_text(json.dumps({"other": 1}) + "\n")
    with pytest.raises(PlanFolderError, match="lines that no sweep wrote"):
        sweep(BASE, {"tray.friction": [0.3]}, folder=tmp_path)
