"""`nospill plan` with a plan that is there already: what it prints where, writes, and with which code it ends."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from unittest.mock import create_autospec

import pytest

from nospill import plots
from nospill.certification.verdict import Certificate, Row
from nospill.cli import planning
from nospill.errors import NoSolutionError
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan
from nospill.plans.summary import SUMMARY_KEYS
from tests.cli.commands import nospill
from tests.cli.conftest import Boundary
from tests.waiting import finished, wait_until


def files(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def test_certified_plan_is_written_with_its_figures(boundary: Boundary, tea: Plan, folder: Path) -> None:
    result = nospill("plan", "tea.toml", "-o", "out/tea")
    assert result.exit_code == 0
    assert [scene.cargo[0].name for scene in boundary.scenes] == ["c1"]
    saved = load_plan(folder / "out" / "tea")
    assert saved.certificate == tea.certificate and saved.duration == tea.duration
    assert files(folder / "out" / "tea" / "figures") == ["summary.png"]
    lines, verdict = result.stdout.splitlines(), f"certified as published: all {len(tea.certificate.rows)} rows hold"
    assert lines[0] == f"{verdict} on a grid of {tea.certificate.grid_hz:g} Hz"
    assert lines[-1] == f"certified as published: {tea.duration:.3f} s"
    for expected in (
        "warning: crest: c1: it is high.",
        f"duration: {tea.duration:.3f} s",
        "held back: friction of c1 is at its limit for 31 % of the time",
        tea.savings_text,
        *tea.comparison,
        "branch: start (0, 0) deg",
        "written to out/tea",
        "look: nospill view out/tea",
    ):
        assert expected and expected in lines
    assert result.stderr.splitlines() == [
        "1 of 6: load the optimiser ...",
        "4 of 6: solve on the fine grid ...",
        "5 of 6: certificate ...",
        "6 of 6: files and figures ...",
    ]


@pytest.mark.parametrize("ok", [True, False])
def test_report_of_a_plan_certified_or_not(
    boundary: Boundary, failing: Plan, folder: Path, ok: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def write(found: Plan, place: Path) -> Path:
        assert found.trajectory is boundary.plan.trajectory
        assert load_plan(place).certificate.ok == ok  # the plan is safe before the report is made
        return place.with_name("tea.report.html")

    monkeypatch.setattr(planning, "write_plan_report", create_autospec(planning.write_plan_report, side_effect=write))
    boundary.plan = boundary.plan if ok else failing
    result = nospill("plan", "tea.toml", "-o", "out/tea", "--report", "--no-figures")
    assert result.exit_code == (0 if ok else 1)
    assert "written to out/tea.report.html" in result.stdout.splitlines()
    again = nospill("plan", "tea.toml", "-o", "out/tea", "--report", "--json", "--no-figures")
    assert again.stdout.startswith("{")


def test_report_without_a_folder_plans_nothing(boundary: Boundary) -> None:
    result = nospill("plan", "tea.toml", "--report")
    assert result.exit_code == 2 and "name one with -o DIR" in result.stderr
    assert boundary.scenes == []


def row(constraint: str, subject: str, margin: float, *, ok: bool = True) -> Row:
    return Row(constraint, subject, "N", limit=1.0, worst_value=1.0 - margin, worst_margin=margin, at_s=0.5, ok=ok)


def test_table_shows_the_worst_row_of_each_constraint(boundary: Boundary) -> None:
    rows = (
        row("slip", "c1", 0.3),
        row("slip", "c2", 0.1),
        row("slosh height", "[c1]", 1e-5),
        row("slip", "c9", -5.0, ok=True),
        row("slip", "c3", 0.2, ok=False),
    )
    boundary.plan = replace(boundary.plan, certificate=Certificate(ok=False, grid_hz=2000.0, rows=rows))
    result = nospill("plan", "tea.toml")
    lines = result.stdout.splitlines()
    slip = [line.split() for line in lines if line.strip().startswith("slip")]
    # As it fails, though another uses more.
    assert slip == [["slip", "c3", "100.1", "%", "FAILS", "0.8", "1", "N", "0.500", "s"]]
    assert any("[c1]" in line and "99.9 %" in line for line in lines)
    assert lines[0].startswith("not certified: 1 of 5 rows fail")
    assert lines[-1] == f"not certified: {boundary.plan.duration:.3f} s"


@pytest.mark.parametrize(
    ("options", "names", "pdf"),
    [((), plots.FIRST_FIGURES, False), (("--all-figures",), (), False), (("--pdf",), plots.FIRST_FIGURES, True)],
)
def test_few_figures_unless_all_are_wanted(
    boundary: Boundary, monkeypatch: pytest.MonkeyPatch, options: tuple[str, ...], names: tuple[str, ...], pdf: bool
) -> None:
    drawing = create_autospec(plots.save_figures)
    monkeypatch.setattr(plots, "save_figures", drawing)
    assert nospill("plan", "tea.toml", "-o", "tea", *options).exit_code == 0
    (_, place), asked = drawing.call_args
    assert (place.name, asked["names"], asked["pdf"]) == ("figures", names, pdf)


def test_without_folder_nothing_is_written(boundary: Boundary, folder: Path) -> None:
    result = nospill("plan", "tea.toml")
    assert result.exit_code == 0
    assert "nothing written; -o DIR keeps the plan" in result.stdout
    assert os.listdir(folder) == ["tea.toml"]


def test_without_figures(boundary: Boundary, folder: Path) -> None:
    assert nospill("plan", "tea.toml", "-o", "tea", "--no-figures").exit_code == 0
    assert not (folder / "tea" / "figures").exists() and load_plan(folder / "tea").certificate.ok


def test_uncertified_plan_is_kept_and_exits_1(boundary: Boundary, failing: Plan, folder: Path) -> None:
    boundary.plan = failing
    result = nospill("plan", "tea.toml", "-o", "tea", "--no-figures")
    assert result.exit_code == 1
    assert not load_plan(folder / "tea").certificate.ok
    last = result.stderr.splitlines()[-1]
    assert last == failing.message and last.startswith("Not certified: slip of c1 uses ")


@pytest.mark.parametrize("ok", [True, False])
def test_json_is_the_summary_alone(boundary: Boundary, failing: Plan, ok: bool) -> None:
    boundary.plan = boundary.plan if ok else failing
    result = nospill("plan", "tea.toml", "--json", "-o", "tea", "--no-figures")
    assert result.exit_code == (0 if ok else 1)
    printed = json.loads(result.stdout)
    assert printed == json.loads(Path("tea/summary.json").read_text(encoding="utf-8"))
    assert set(printed["phases_s"]) >= {"import", "write", *boundary.plan.report.phases}
    stated = json.loads(json.dumps(boundary.plan.with_second_looks().summary()))
    assert printed == stated | {"phases_s": printed["phases_s"]}


def test_json_stays_clean_whatever_the_solvers_print(outside: Callable[..., subprocess.Popen[str]]) -> None:
    work = "print('python'); os.write(1, b'system'); ctypes.CDLL(None).printf(b'buffered by C')"
    process = outside(work, "plan", "matrix-liquid", "--json")
    out, err = finished(process, "nospill plan --json")
    assert process.returncode == 0, err
    assert list(json.loads(out)) == list(SUMMARY_KEYS)
    if os.name == "posix":
        assert all(word in err for word in ("python", "system", "buffered by C"))


@pytest.mark.parametrize("as_json", [True, False])
def test_no_solution_exits_3_and_writes_nothing(boundary: Boundary, folder: Path, as_json: bool) -> None:
    boundary.fails(NoSolutionError("slosh height of c1\n stands in the way"))
    result = nospill("plan", "tea.toml", "-o", "deep/tea", *(["--json"] if as_json else []))
    assert result.exit_code == 3
    assert result.stderr.splitlines()[-1] == "tea.toml: slosh height of c1 stands in the way"
    assert os.listdir(folder) == ["tea.toml"]
    if as_json:
        summary = json.loads(result.stdout)
        assert tuple(summary) == SUMMARY_KEYS
        stated = {key: value for key, value in summary.items() if value is not None}
        name = boundary.scenes[0].name
        assert stated == {"scenario": name, "status": "failed", "message": "slosh height of c1 stands in the way"}
    else:
        assert result.stdout == ""


def test_settings_reach_the_reader(boundary: Boundary) -> None:
    assert nospill("plan", "tea.toml", "--set", "motion.tilt=free", "--set", "tray.mass=1 kg").exit_code == 0
    (scene,) = boundary.scenes
    assert scene.motion.tilt_free and scene.tray.mass == 1.0


@pytest.mark.parametrize("as_json", [True, False])
def test_bad_input_is_one_line_as_written(boundary: Boundary, folder: Path, as_json: bool) -> None:
    """What the terminal's library takes for a style is printed too."""
    text = (folder / "tea.toml").read_text(encoding="utf-8")
    assert text.count('name = "c1"') == 1
    text = text.replace('name = "c1"', 'name = "[bold]c1[/bold]"')
    (folder / "tea.toml").write_text(text, encoding="utf-8")
    result = nospill("plan", "tea.toml", *(["--json"] if as_json else []))
    assert (result.exit_code, result.stdout, boundary.scenes) == (2, "", [])
    assert "[bold]c1[/bold]" in result.stderr and result.stderr.count("\n") == 1


def test_foreign_folder_is_refused_before_the_work(boundary: Boundary, folder: Path) -> None:
    (folder / "thesis").mkdir()
    (folder / "thesis" / "a.tex").write_text("dear")
    result = nospill("plan", "thesis.toml", "-o", "thesis")  # not even the scenario is read, which there is not
    assert result.exit_code == 2
    assert "did not write" in result.stderr
    assert boundary.scenes == []
    assert (folder / "thesis" / "a.tex").read_text() == "dear"


def test_fault_of_our_own_is_one_line(boundary: Boundary, monkeypatch: pytest.MonkeyPatch) -> None:
    boundary.fails(ZeroDivisionError("in\nside"))
    result = nospill("plan", "tea.toml")
    assert result.exit_code == 70
    last = result.stderr.splitlines()[-1]
    assert last.startswith("internal error: ZeroDivisionError: in side; please report it")
    assert "Traceback" not in result.stderr
    monkeypatch.setenv("NOSPILL_TRACEBACK", "1")
    result = nospill("plan", "tea.toml")
    assert result.exit_code == 70
    assert "Traceback" in result.stderr
    assert result.stderr.splitlines()[-1] == last


def test_stopped_by_the_user(boundary: Boundary, folder: Path) -> None:
    boundary.fails(KeyboardInterrupt())
    result = nospill("plan", "tea.toml", "-o", "tea")
    assert result.exit_code == 130
    assert result.stderr.splitlines()[-1] == "stopped; nothing was written"
    assert os.listdir(folder) == ["tea.toml"]


def test_interrupt_signal_leaves_the_old_plan(outside: Callable[..., subprocess.Popen[str]], folder: Path) -> None:
    (folder / "tea").mkdir()
    (folder / "tea" / "summary.json").write_text("old")
    process = outside("open('started', 'w').close(); time.sleep(60)", "plan", "matrix-liquid", "--json", "-o", "tea")
    wait_until((folder / "started").exists, "the planner has started")
    process.send_signal(signal.SIGINT)
    out, err = finished(process, "a plan that was stopped")
    assert (process.returncode, out) == (130, "")
    assert err.splitlines()[-1] == "stopped; nothing was written"
    assert (folder / "tea" / "summary.json").read_text() == "old"
