"""`nospill check` and `nospill plot` on a real plan folder: what they print and write."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from nospill.plans.loading import load_plan
from tests.cli.commands import nospill
from tests.waiting import run_python


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_check_judges_again_and_writes_nothing(plan_folder: Path) -> None:
    before = contents(plan_folder)
    result = nospill("check", "tea")
    assert (result.exit_code, result.stderr) == (0, "")
    lines = result.stdout.splitlines()
    assert lines[0].startswith("certified as published: all ") and lines[-1] == "certified as published"
    assert "robot.csv holds the motion of the trajectory" in lines
    assert any(line.startswith("warning: joint acceleration: ") for line in lines)  # no limit of it is known
    assert contents(plan_folder) == before


def test_a_plan_says_in_python_what_check_prints(plan_folder: Path) -> None:
    printed = {_words(line) for line in nospill("check", "tea").stdout.splitlines()}
    said = [_words(line) for line in load_plan(plan_folder).text().splitlines() if not line.startswith("---")]
    own = said.index(next(line for line in said if line[:1] == ("duration:",)))
    warnings = [line for line in said[:own] if line[:1] == ("warning:",)]  # the folder has others than are found now
    assert set(said[:own]) - set(warnings) <= printed and own > 15 and warnings
    assert {"duration:", "branch:"} <= {line[0] for line in said[own:]}


def _words(line: str) -> tuple[str, ...]:
    return tuple(line.split())


def test_check_believes_the_trajectory_and_not_the_certificate(plan_folder: Path) -> None:
    """The same folder, certificate and all, with a scenario of a smoother tray."""
    scenario = plan_folder / "scenario.toml"
    text = scenario.read_text(encoding="utf-8")
    assert text.count("friction = 0.466308") == 1
    scenario.write_text(text.replace("friction = 0.466308", "friction = 0.09"), encoding="utf-8")
    before = contents(plan_folder)
    result = nospill("check", "tea")
    assert result.exit_code == 1
    assert result.stdout.startswith("not certified: 1 of ") and "FAILS" in result.stdout
    assert result.stderr.startswith("Not certified: slip of c1 uses ") and result.stderr.count("\n") == 1
    assert contents(plan_folder) == before


def test_plot_replaces_the_figures_whole_and_neither_command_loads_the_optimiser(plan_folder: Path) -> None:
    (plan_folder / "figures").mkdir()
    (plan_folder / "figures" / "old.pdf").write_text("old")
    script = (
        "import sys\n"
        "from typer.testing import CliRunner\n"
        "from nospill.cli import app\n"
        "for name in ('check', 'plot'):\n"
        "    result = CliRunner().invoke(app, [name, 'tea'])\n"
        "    assert result.exit_code == 0, result.output\n"
        "print(result.stdout, end='')\n"
        "print([m for m in sys.modules if m.startswith(('nospill.transcription', 'nospill.planning'))])\n"
    )
    before = contents(plan_folder)
    done = run_python("-c", script)
    *drawn, loaded = done.stdout.splitlines()
    assert loaded == "[]", done.stderr
    assert "tea/figures/summary.png" in drawn
    assert sorted(os.listdir(plan_folder / "figures")) == sorted(Path(name).name for name in drawn)
    assert contents(plan_folder).items() >= {name: text for name, text in before.items() if "old" not in name}.items()


def test_plot_leaves_foreign_files_alone(plan_folder: Path) -> None:
    (plan_folder / "figures").mkdir()
    (plan_folder / "figures" / "notes.txt").write_text("dear")
    result = nospill("plot", "tea")
    assert result.exit_code == 2
    assert "figures holds files that nospill did not write" in result.stderr
    assert os.listdir(plan_folder / "figures") == ["notes.txt"]


@pytest.mark.parametrize("command", ["check", "plot"])
def test_not_a_plan_folder(command: str) -> None:
    result = nospill(command, "nowhere")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith("nowhere: no such folder") and result.stderr.count("\n") == 1
