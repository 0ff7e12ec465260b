"""`nospill plan`, with stand-ins: what it prints where, what it writes, and with which exit code it ends."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from nospill.errors import NoSolutionError, ScenarioError
from nospill.plans.plan import SUMMARY_KEYS
from nospill.plots import FIRST_FIGURES
from tests.cli.stand_in import StandIn, nospill, raising, row
from tests.waiting import finished, wait_until


def test_certified_plan_is_written_with_its_figures(stand_in: StandIn, folder: Path) -> None:
    result = nospill("plan", "tea.toml", "-o", "out/tea")
    assert result.exit_code == 0
    assert stand_in.calls == ["read tea.toml", "plan"]
    assert sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()) == [
        "out/tea/figures/sheet.png",
        "out/tea/summary.json",
    ]
    for expected in ("certified: all 3 rows hold on a grid of 2000 Hz", "duration: 1.843 s", "written to out/tea"):
        assert expected in result.stdout
    assert result.stdout.splitlines()[0] == "certified: all 3 rows hold on a grid of 2000 Hz"
    assert result.stdout.splitlines()[-1] == "certified: 1.843 s"
    assert "look: nospill view out/tea" in result.stdout
    assert "held back: friction of c1 is at its limit for 31 % of the time" in result.stdout
    assert result.stderr.splitlines() == [
        "1 of 6: load the optimiser ...",
        "4 of 6: solve on the fine grid ...",
        "5 of 6: certificate ...",
        "6 of 6: files and figures ...",
    ]


@pytest.mark.parametrize("ok", [True, False])
def test_report_of_a_plan_certified_or_not(
    stand_in: StandIn, folder: Path, ok: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def write(found: StandIn, place: Path) -> Path:
        assert found is stand_in and (place / "summary.json").exists()  # the plan is safe before the report is made
        return place.with_name("tea.report.html")

    monkeypatch.setattr("nospill.cli.planning.write_plan_report", write)
    stand_in.ok = ok
    stand_in.rows[1] = row("slip", "c2", 0.1, ok=ok)
    result = nospill("plan", "tea.toml", "-o", "out/tea", "--report")
    assert result.exit_code == (0 if ok else 1)
    assert "written to out/tea.report.html" in result.stdout.splitlines()
    assert nospill("plan", "tea.toml", "-o", "out/tea", "--report", "--json").stdout.startswith("{")


def test_report_without_a_folder_plans_nothing(stand_in: StandIn) -> None:
    result = nospill("plan", "tea.toml", "--report")
    assert result.exit_code == 2 and "name one with -o DIR" in result.stderr
    assert stand_in.calls == []


def test_table_shows_the_worst_row_of_each_constraint(stand_in: StandIn) -> None:
    stand_in.rows.append(row("slip", "c9", -5.0, ok=True))
    stand_in.rows.append(row("slip", "c3", 0.2, ok=False))
    stand_in.ok = False
    result = nospill("plan", "tea.toml")
    lines = result.stdout.splitlines()
    slip = [line.split() for line in lines if line.strip().startswith("slip")]
    # As it fails, though another uses more.
    assert slip == [["slip", "c3", "100.1", "%", "FAILS", "0.8", "1", "N", "0.500", "s"]]
    assert any("[c1]" in line and "99.9 %" in line for line in lines)
    assert lines[0].startswith("not certified: 1 of 5 rows fail") and lines[-1] == "not certified: 1.843 s"


def test_few_figures_unless_all_are_wanted(stand_in: StandIn, folder: Path) -> None:
    nospill("plan", "tea.toml", "-o", "tea")
    assert stand_in.figures == FIRST_FIGURES
    nospill("plan", "tea.toml", "-o", "tea", "--all-figures")
    assert stand_in.figures == ()


def test_pdf_on_request(stand_in: StandIn, folder: Path) -> None:
    assert nospill("plan", "tea.toml", "-o", "tea", "--pdf").exit_code == 0
    assert sorted(os.listdir(folder / "tea" / "figures")) == ["sheet.pdf", "sheet.png"]


def test_without_folder_nothing_is_written(stand_in: StandIn, folder: Path) -> None:
    result = nospill("plan", "tea.toml")
    assert result.exit_code == 0
    assert "nothing written; -o DIR keeps the plan" in result.stdout
    assert list(folder.iterdir()) == []


def test_without_figures(stand_in: StandIn, folder: Path) -> None:
    assert nospill("plan", "tea.toml", "-o", "tea", "--no-figures").exit_code == 0
    assert os.listdir(folder / "tea") == ["summary.json"]


def test_uncertified_plan_is_kept_and_exits_1(stand_in: StandIn, folder: Path) -> None:
    stand_in.ok = False
    stand_in.message = "slip of c2 fails\nby 0.1 N"
    result = nospill("plan", "tea.toml", "-o", "tea")
    assert result.exit_code == 1
    assert (folder / "tea" / "summary.json").exists()
    assert result.stderr.splitlines()[-1] == "slip of c2 fails by 0.1 N"


@pytest.mark.parametrize("ok", [True, False])
def test_json_is_the_summary_alone(stand_in: StandIn, ok: bool) -> None:
    stand_in.ok = ok
    result = nospill("plan", "tea.toml", "--json", "-o", "tea")
    assert result.exit_code == (0 if ok else 1)
    assert json.loads(result.stdout) == stand_in.summary()


def test_json_stays_clean_whatever_the_solvers_print(outside: Callable[..., subprocess.Popen[str]]) -> None:
    work = "print('python'); os.write(1, b'system'); ctypes.CDLL(None).printf(b'buffered by C')"
    process = outside(work, "plan", "tea", "--json")
    out, err = finished(process, "nospill plan --json")
    assert process.returncode == 0, err
    assert list(json.loads(out)) == list(SUMMARY_KEYS)
    if os.name == "posix":
        assert all(word in err for word in ("python", "system", "buffered by C"))


@pytest.mark.parametrize("as_json", [True, False])
def test_no_solution_exits_3_and_writes_nothing(stand_in: StandIn, folder: Path, as_json: bool) -> None:
    stand_in.planning = raising(NoSolutionError("slosh height of c1\n stands in the way"))
    result = nospill("plan", "tea.toml", "-o", "deep/tea", *(["--json"] if as_json else []))
    assert result.exit_code == 3
    assert result.stderr.splitlines()[-1] == "tea.toml: slosh height of c1 stands in the way"
    assert list(folder.iterdir()) == []
    if as_json:
        summary = json.loads(result.stdout)
        assert tuple(summary) == SUMMARY_KEYS
        stated = {key: value for key, value in summary.items() if value is not None}
        assert stated == {"scenario": "tea", "status": "failed", "message": "slosh height of c1 stands in the way"}
    else:
        assert result.stdout == ""


def test_settings_reach_the_reader(stand_in: StandIn) -> None:
    assert nospill("plan", "tea.toml", "--set", "motion.tilt=free", "--set", "tray.mass=1").exit_code == 0
    assert stand_in.calls[0] == "read tea.toml motion.tilt=free tray.mass=1"


@pytest.mark.parametrize("as_json", [True, False])
def test_bad_input_is_one_line_as_written(stand_in: StandIn, monkeypatch: pytest.MonkeyPatch, as_json: bool) -> None:
    message = 'tea.toml: [[cargo]] "c1": radius is "-35 mm"; [bold]give[/bold] a length above 0'

    def fail(_: str, *, settings: object) -> None:
        raise ScenarioError(message)

    monkeypatch.setattr(sys.modules["nospill.scenario"], "read_scenario", fail)
    result = nospill("plan", "tea.toml", *(["--json"] if as_json else []))
    assert (result.exit_code, result.stdout, result.stderr) == (2, "", message + "\n")


def test_foreign_folder_is_refused_before_the_work(stand_in: StandIn, folder: Path) -> None:
    (folder / "thesis").mkdir()
    (folder / "thesis" / "a.tex").write_text("dear")
    result = nospill("plan", "tea.toml", "-o", "thesis")
    assert result.exit_code == 2
    assert "did not write" in result.stderr
    assert stand_in.calls == []
    assert (folder / "thesis" / "a.tex").read_text() == "dear"


def test_fault_of_our_own_is_one_line(stand_in: StandIn, monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in.planning = raising(ZeroDivisionError("in\nside"))
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


def test_stopped_by_the_user(stand_in: StandIn, folder: Path) -> None:
    stand_in.planning = raising(KeyboardInterrupt())
    result = nospill("plan", "tea.toml", "-o", "tea")
    assert result.exit_code == 130
    assert result.stderr.splitlines()[-1] == "stopped; nothing was written"
    assert list(folder.iterdir()) == []


def test_interrupt_signal_leaves_the_old_plan(outside: Callable[..., subprocess.Popen[str]], folder: Path) -> None:
    (folder / "tea").mkdir()
    (folder / "tea" / "summary.json").write_text("old")
    process = outside("open('started', 'w').close(); time.sleep(60)", "plan", "x", "--json", "-o", "tea")
    wait_until((folder / "started").exists, "the planner has started")
    process.send_signal(signal.SIGINT)
    out, err = finished(process, "a plan that was stopped")
    assert (process.returncode, out) == (130, "")
    assert err.splitlines()[-1] == "stopped; nothing was written"
    assert (folder / "tea" / "summary.json").read_text() == "old"
