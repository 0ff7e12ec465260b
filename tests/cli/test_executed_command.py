"""The command `executed`: what it prints, writes and refuses."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from nospill.certification.certificate import judge
from nospill.cli import app
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.plans.plan import Plan
from nospill.simulation.motion_file import Heights, write_heights
from tests.execution.logs import log_of, write_log


@pytest.fixture(scope="module")
def place(gentle_plan: Callable[..., Plan], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a plan of one cup, its log, and a height as a camera would see it."""
    folder = tmp_path_factory.mktemp("run")
    plan = gentle_plan("matrix-liquid", cargo=1)
    plan.save(folder / "plan")
    write_log(log_of(plan, noise=0.0), folder / "run.csv")
    write_log(log_of(plan, noise=1e-4), folder / "noisy.csv")
    write_log(log_of(plan, noise=0.0), folder / "degrees.csv", degrees=True)
    t = np.arange(0.0, plan.duration + 2.0, 1 / 60)
    trace = next(one for one in judge(plan.trajectory, plan.scene).traces if one.constraint == SloshHeight.name)
    write_heights(folder / "c1.csv", Heights(t, np.interp(t - 1.0, trace.t, trace.value, left=0.0, right=0.0)))
    return folder


def run(place: Path, *arguments: str) -> Result:
    return CliRunner().invoke(app, ["executed", *(text.replace("@", f"{place}/") for text in arguments)])


def test_a_run_as_planned(place: Path, tmp_path: Path) -> None:
    result = run(place, "@run.csv", "--plan", "@plan", "--measured", "c1=@c1.csv", "-o", str(tmp_path / "out"))
    assert result.exit_code == 0, result.output
    for phrase in (
        "executed: certified as published: all",
        "planned: certified as published: all",
        "stamps are off by",
        "the samples are even; 0 samples missing, 0 doubled",
        "the plan begins at 0.500",
        "tracking: at most",
        "measured mm",
    ):
        assert phrase in result.output, phrase
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"executed.json", "heights.png"}
    table = json.loads((tmp_path / "out" / "executed.json").read_text(encoding="utf-8"))
    assert table["measured"]["c1"]["correlation"] > 0.99


@pytest.mark.slow
def test_columns_in_degrees_are_the_same_run(place: Path) -> None:
    first, second = (
        json.loads(run(place, name, "--plan", "@plan", "--json").stdout) for name in ("@run.csv", "@degrees.csv")
    )
    assert first["peak_height_m"]["c1"] == pytest.approx(second["peak_height_m"]["c1"], abs=1e-6)


def test_exit_code_1_where_a_row_fails(place: Path) -> None:
    """The laboratory's scenario with a lower limit of the height."""
    table = (place / "plan" / "scenario.toml").read_text(encoding="utf-8")
    strict = place / "strict.toml"
    strict.write_text(table.replace('"15 mm"', '"2 mm"').replace("0.015", "0.002"), encoding="utf-8")
    result = run(place, "@run.csv", "--scenario", "@strict.toml")
    assert result.exit_code == 1, result.output
    assert "Not certified as executed: " in result.output
    assert "FAILS" in result.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["@run.csv"], "give either --plan DIR or --scenario SCENARIO"),
        (["@none.csv", "--plan", "@plan"], "none.csv: no such file; give a joint log as CSV or as a ROS bag"),
        (["@run.csv", "--plan", "@plan", "--offset", "joint_6"], '--offset joint_6: one NAME="180 deg" for each name'),
        (["@run.csv", "--plan", "@plan", "--unit", "grad"], '--unit "grad" is not known; choose rad or deg'),
        (["@run.csv", "--plan", "@plan", "--rate", "-5"], "--rate -5: rows a second are needed"),
        (["@run.csv", "--scenario", "coffee-to-go"], "run.csv: "),
        (["@c1.csv", "--plan", "@plan"], "no columns of the 6 joints"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(place: Path, arguments: list[str], message: str) -> None:
    result = run(place, *arguments)
    assert result.exit_code == 2, result.output
    assert message in result.output
    assert len(result.output.strip().splitlines()) == 1
