"""`nospill check` and `nospill plot`, with stand-ins: what they print and write."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from nospill.plans.warnings.record import PlanWarning
from tests.cli.stand_in import StandIn, nospill, row
from tests.waiting import run_python


@pytest.mark.parametrize("ok", [True, False])
def test_check_judges_again_and_writes_nothing(stand_in: StandIn, plan_folder: Path, ok: bool) -> None:
    stand_in.ok = ok
    stand_in.rows[1] = row("slip", "c2", 0.1 if ok else -0.25, ok=ok)
    result = nospill("check", "tea")
    assert result.exit_code == (0 if ok else 1)
    assert stand_in.calls == ["judge trajectory tea"]
    assert ("certified: all 3 rows" if ok else "not certified: 1 of 3 rows fail") in result.stdout
    message = "Not certified: slip of c2 is 1.25 N against a limit of 1 N (125.0 % of it) at t = 0.500 s.\n"
    assert result.stderr == ("" if ok else message)
    assert os.listdir(plan_folder) == ["summary.json"]


def test_check_prints_warnings_and_leaves_the_verdict(stand_in: StandIn, plan_folder: Path) -> None:
    stand_in.warnings = tuple(PlanWarning("crest", name, "it is high.") for name in ("c1", "c2"))
    result = nospill("check", "tea")
    assert result.exit_code == 0
    assert "\nwarning: crest: c1: it is high. Likewise: c2.\n" in result.stdout


def test_check_and_plot_do_not_load_the_optimiser(stand_in: StandIn, plan_folder: Path) -> None:
    script = (
        f"import sys; sys.path.insert(0, {str(Path(__file__).parents[2])!r})\n"
        "from tests.cli.stand_in import StandIn\n"
        "modules = StandIn().modules(); del modules['nospill.planning.planner']; sys.modules.update(modules)\n"
        "from typer.testing import CliRunner\n"
        "from nospill.cli import app\n"
        "for name in ('check', 'plot'):\n"
        "    assert CliRunner().invoke(app, [name, 'tea']).exit_code == 0, name\n"
        "print([m for m in sys.modules if m.startswith(('nospill.transcription', 'nospill.planning.planner'))])\n"
    )
    done = run_python("-c", script)
    assert done.stdout == "[]\n", done.stderr


def test_plot_replaces_the_figures_whole(stand_in: StandIn, plan_folder: Path) -> None:
    (plan_folder / "figures").mkdir()
    (plan_folder / "figures" / "old.pdf").write_text("old")
    result = nospill("plot", "tea")
    assert result.exit_code == 0
    assert result.stdout == "tea/figures/sheet.png\n"
    assert os.listdir(plan_folder / "figures") == ["sheet.png"]
    assert (plan_folder / "summary.json").read_text() == "old"


def test_plot_leaves_foreign_files_alone(stand_in: StandIn, plan_folder: Path) -> None:
    (plan_folder / "figures").mkdir()
    (plan_folder / "figures" / "notes.txt").write_text("dear")
    result = nospill("plot", "tea")
    assert result.exit_code == 2
    assert "figures holds files that nospill did not write" in result.stderr
    assert os.listdir(plan_folder / "figures") == ["notes.txt"]


@pytest.mark.parametrize("command", ["check", "plot"])
def test_not_a_plan_folder(stand_in: StandIn, command: str) -> None:
    result = nospill(command, "nowhere")
    assert (result.exit_code, result.stdout, result.stderr) == (2, "", "nowhere is not a plan folder\n")
