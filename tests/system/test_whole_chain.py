"""The command line with nothing stood in for: real plans, damaged plans, impossible tasks, Ctrl-C."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from nospill.cli import app
from nospill.cli.progress import CERTIFICATE, COARSE, FINE
from nospill.plans.summary import SUMMARY_KEYS
from nospill.scenario.examples import example_path
from tests.waiting import finished, run_python

pytestmark = pytest.mark.slow


def real(*arguments: str) -> subprocess.CompletedProcess[str]:
    return run_python("-c", "from nospill.cli import main; main()", *arguments)


def changed_example(name: str, place: Path, changes: dict[str, str]) -> str:
    text = example_path(name).read_text(encoding="utf-8")
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    place.write_text(text, encoding="utf-8")
    return str(place)


def one_line(result: subprocess.CompletedProcess[str]) -> str:
    """The last line on stderr; before it there are only phases."""
    *phases, last = result.stderr.splitlines()
    assert all(line.endswith(" ...") for line in phases), result.stderr
    assert "Traceback" not in result.stderr
    return last


@pytest.fixture(scope="module")
def rigid(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, subprocess.CompletedProcess[str]]:
    place = tmp_path_factory.mktemp("real") / "rigid"
    return place, real("plan", "matrix-rigid", "-o", str(place), "--json", "--no-figures")


def test_a_real_plan(rigid: tuple[Path, subprocess.CompletedProcess[str]]) -> None:
    place, result = rigid
    assert result.returncode == 0, result.stderr
    summary = json.loads(result.stdout)
    assert tuple(summary) == SUMMARY_KEYS
    assert result.stdout == (place / "summary.json").read_text()
    assert (summary["scenario"], summary["status"]) == ("matrix-rigid", "certified as published")
    assert summary["duration_s"] == pytest.approx(1.40, rel=0.01)
    assert set(summary["certificate"]) == {"ok", "worst_constraint", "worst_margin", "full_model"}
    assert sorted(os.listdir(place)) == [
        "certificate.json",
        "robot.csv",
        "scenario.toml",
        "summary.json",
        "trajectory.csv",
    ]
    certificate = json.loads((place / "certificate.json").read_text())
    assert list(certificate) == ["ok", "grid_hz", "rows", "published", "modes", "self_collision", "full_model"]
    keys = ["constraint", "subject", "unit", "limit", "worst_value", "worst_margin", "at_s", "ok"]
    # of a distance a row says with what capsules, or which pair is the nearest of many
    distances = [row for row in certificate["rows"] if row["constraint"] == "clearance"]
    assert all(list(row) == [*keys, "variant"] for row in distances)
    assert all(list(row) == keys for row in certificate["rows"] if row not in distances)
    judged = certificate["self_collision"]
    assert (judged["on"], judged["estimated"]) == (True, True) and judged["judged"] > 0
    assert (
        distances[-1]["subject"] == "all other pairs of arm, tray and cargo" and 0 < len(distances) < judged["judged"]
    )


def test_a_real_plan_is_checked_and_drawn_again(
    rigid: tuple[Path, subprocess.CompletedProcess[str]], tmp_path: Path
) -> None:
    copy = shutil.copytree(rigid[0], tmp_path / "copy")
    checked = CliRunner().invoke(app, ["check", str(copy)])
    assert checked.exit_code == 0 and checked.stderr == ""
    rows = len(json.loads((copy / "certificate.json").read_text())["rows"])
    assert f"certified as published: all {rows} rows hold on a grid of 2000 Hz" in checked.stdout
    drawn = CliRunner().invoke(app, ["plot", str(copy)])
    assert drawn.exit_code == 0, drawn.stderr
    assert {Path(line).name for line in drawn.stdout.splitlines()} == {
        f"{name}.png" for name in ("joints", "limits", "margins", "other-speeds", "summary", "tilt")
    }


@pytest.mark.parametrize(
    ("column", "change", "told"),
    [
        # One sample of a joint, a thousandth of a radian off.
        ("joint_2_rad", lambda value, row: value + 1e-3 * (row == 300), "path position of tray"),
        ("joint_6_rad", lambda value, row: value + 0.01, "path attitude of tray"),
        ("t_s", lambda value, row: 0.95 * value, "even sampling of time"),
        ("joint_1_rad_s", lambda value, row: 0.9 * value, "recorded speed of joints"),
    ],
)
def test_a_corrupted_trajectory_fails_its_row(
    rigid: tuple[Path, subprocess.CompletedProcess[str]],
    tmp_path: Path,
    column: str,
    change: Callable[[float, int], float],
    told: str,
) -> None:
    copy = shutil.copytree(rigid[0], tmp_path / "copy")
    file = copy / "trajectory.csv"
    head, *lines = file.read_text().splitlines()
    place = head.split(",").index(column)
    for index, line in enumerate(lines):
        cells = line.split(",")
        cells[place] = repr(change(float(cells[place]), index))
        lines[index] = ",".join(cells)
    file.write_text("\n".join([head, *lines]) + "\n")
    result = CliRunner().invoke(app, ["check", str(copy)])
    assert result.exit_code == 1, result.stderr
    assert result.stderr.startswith("Not certified: ") and result.stderr.count("\n") == 1
    constraint, _, subject = told.partition(" of ")
    failing = [line for line in result.stdout.splitlines() if "FAILS" in line.split()]
    assert any(line.split("  ")[0] == constraint and subject in line for line in failing), result.stdout


@pytest.mark.parametrize(
    ("changes", "told", "as_json"),
    [
        ({"[motion]\n": '[motion]\nmax_duration = "1 s"\n'}, r"held back by slosh height of c\d", True),
    ],
)
def test_impossible_limits_exit_3_and_name_the_constraint(
    tmp_path: Path, changes: dict[str, str], told: str, as_json: bool
) -> None:
    scenario = changed_example("matrix-liquid", tmp_path / "tea.toml", changes)
    result = real("plan", scenario, "-o", str(tmp_path / "out"), *(["--json"] if as_json else []))
    assert result.returncode == 3
    assert re.search(told, one_line(result))
    assert not (tmp_path / "out").exists()
    if as_json:
        summary = json.loads(result.stdout)
        assert tuple(summary) == SUMMARY_KEYS
        assert (summary["status"], summary["message"]) == ("failed", one_line(result).removeprefix(f"{scenario}: "))
    else:
        assert result.stdout == ""


@pytest.mark.parametrize(
    ("changes", "alone"),
    [
        ({'name = "arc"': 'name = "sl3d"'}, True),
        ({'name = "arc"': 'name = "arc"\noffset = ["2 m", 0, 0]'}, False),
    ],
    ids=["in a process of its own", "in this one"],
)
def test_paths_out_of_reach_exit_2_and_say_where(tmp_path: Path, changes: dict[str, str], alone: bool) -> None:
    words = ["plan", changed_example("matrix-liquid", tmp_path / "tea.toml", changes), "-o", str(tmp_path / "out")]
    if alone:
        result = real(*words)
        code, out, said = result.returncode, result.stdout, one_line(result)
    else:
        here = CliRunner().invoke(app, words)
        code, out, said = here.exit_code, here.stdout, here.stderr.splitlines()[-1]
    assert (code, out) == (2, "")
    assert re.search(r"tea\.toml: path: out of reach of robot 'comau-smart-six' .* s = \d\.\d{3}.* mm", said)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("step", "delay"), [(COARSE, 0.0), (COARSE, 0.3), (FINE, 0.0), (CERTIFICATE, 0.05)])
def test_an_interrupt_stops_a_real_plan_at_once(tmp_path: Path, step: str, delay: float) -> None:
    command = [sys.executable, "-c", "from nospill.cli import main; main()", "plan", "matrix-liquid"]
    process = subprocess.Popen(
        [*command, "--json", "-o", "tea"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path
    )
    try:
        assert process.stderr is not None
        for line in process.stderr:
            if step in line:
                break
        time.sleep(delay)
        process.send_signal(signal.SIGINT)
        out, err = finished(process, "a plan that was stopped")
    finally:
        process.kill()
    assert (process.returncode, out) == (130, "")
    assert err.splitlines()[-1] == "stopped; nothing was written"
    assert "Traceback" not in err
    assert os.listdir(tmp_path) == []
