"""The command `identify`."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from nospill.cli import app
from nospill.plans.plan import Plan
from tests.execution.logs import log_of, write_log


@pytest.fixture(scope="module")
def place(gentle_plan: Callable[..., Plan], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a plan of one cup and its log."""
    folder = tmp_path_factory.mktemp("learn")
    plan = gentle_plan("matrix-liquid", cargo=1)
    plan.save(folder / "plan")
    write_log(log_of(plan, delays=0.004), folder / "run.csv")
    return folder


def run(place: Path, *arguments: str) -> Result:
    return CliRunner().invoke(app, ["identify", *(text.replace("@", f"{place}/") for text in arguments)])


@pytest.mark.slow
def test_tables_are_printed_and_written(place: Path, tmp_path: Path) -> None:
    result = run(place, "@run.csv", "--plan", "@plan", "--stayed", "c1", "-o", str(tmp_path / "learnt.toml"))
    assert result.exit_code == 0, result.output
    for phrase in ("delays are against the joint that begins first", "[controller]", "c1 stayed", "± "):
        assert phrase in result.output, phrase
    tables = tomllib.loads((tmp_path / "learnt.toml").read_text(encoding="utf-8"))
    assert len(tables["controller"]["delay"]) == 6


@pytest.mark.slow
def test_the_record_as_json(place: Path) -> None:
    result = run(place, "@run.csv", "--plan", "@plan", "--json")
    assert json.loads(result.stdout)["joints"]["joint_1"]["lag"]["identifiable"] is True


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["@run.csv"], "give either --plan DIR or --scenario SCENARIO"),
        (["@run.csv", "--scenario", "matrix-liquid"], "nothing to learn from"),
        (["@run.csv", "--plan", "@plan", "--slid", "c7"], "--stayed or --slid c7: no such object"),
        (["@run.csv", "--plan", "@plan", "--measured", "c1"], "--measured c1: one NAME=FILE.csv for each name"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(place: Path, arguments: list[str], message: str) -> None:
    result = run(place, *arguments)
    assert result.exit_code == 2, result.output
    assert message in result.output
    assert len(result.output.strip().splitlines()) == 1


def test_help_names_the_tables() -> None:
    """Square brackets would be markup to the help's printer, and vanish."""
    assert 'tables "controller" and "tolerance"' in " ".join(
        CliRunner().invoke(app, ["identify", "--help"]).output.split()
    )
