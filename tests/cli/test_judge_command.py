"""judge: files of others and plan folders, in words, as JSON, and by exit code."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from nospill.export import EXPORTERS
from nospill.motion.resampling import resampled
from tests.cli.commands import nospill


@pytest.fixture(scope="module")
def motion(gentle_plan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    plan = gentle_plan("pp-two-cups", 1)
    place = tmp_path_factory.mktemp("motion") / "motion.yaml"
    EXPORTERS["joint-trajectory"].write(resampled(plan.trajectory, 50.0), plan.scene, place)
    return place


def test_a_motion_is_judged_in_words(motion: Path) -> None:
    result = nospill("judge", str(motion), "--scenario", "pp-two-cups")
    assert result.exit_code in (0, 1), result.stderr
    assert result.stdout.startswith("read: ") and "joints by name, time from time_from_start" in result.stdout
    assert "played as a quintic polynomial per segment" in result.stdout
    assert "not judged: path, corridor, tilt and goal of the plan, jerks" in result.stdout
    assert "integrity of the file" not in result.stdout


def test_json_has_codes_and_first_points(motion: Path) -> None:
    result = nospill("judge", str(motion), "--scenario", "pp-two-cups", "--as", "linear", "--json")
    table = json.loads(result.stdout)
    assert result.exit_code == (0 if table["ok"] else 1) == 1
    assert table["played_as"] == "lines at 500 Hz"
    failing = {row["constraint"].replace(" ", "-") for row in table["certificate"]["rows"] if not row["ok"]}
    assert {failure["code"] for failure in table["failures"]} == failing != set()


def test_verdict_figures_and_a_page_are_written(motion: Path, tmp_path: Path) -> None:
    folder = tmp_path / "judged"
    folder.mkdir()
    (folder / "verdict.json").write_text("of an earlier one, which is replaced")
    result = nospill("judge", str(motion), "--scenario", "pp-two-cups", "-o", str(folder))
    assert f"written to {folder}" in result.stdout
    assert {item.name for item in folder.iterdir()} == {"verdict.json", "figures", "motion.html"}
    table = json.loads((folder / "verdict.json").read_text())
    assert table["ok"] == (result.exit_code == 0)
    assert {"summary.png", "joints.png", "slosh-heights.png"} <= {item.name for item in (folder / "figures").iterdir()}
    page = (folder / "motion.html").read_text()
    assert "the fastest motion found" not in page and "pp-two-cups" in page
    (folder / "notes.txt").write_text("mine")
    result = nospill("judge", str(motion), "--scenario", "pp-two-cups", "-o", str(folder))
    assert result.exit_code == 2 and (folder / "notes.txt").read_text() == "mine"


def test_a_plan_folder_is_checked_by_its_own_scenario(gentle_plan, tmp_path: Path) -> None:
    gentle_plan("pp-two-cups", 1).save(tmp_path / "plan")
    result = nospill("judge", str(tmp_path / "plan"))
    assert result.exit_code == 0 and "robot.csv holds the motion of the trajectory" in result.stdout
    result = nospill("judge", str(tmp_path / "plan"), "--scenario", "pp-two-cups")
    assert result.exit_code == 2 and "leave --scenario, --as and -o out" in result.stderr


def test_what_is_missing_is_asked_for(motion: Path) -> None:
    result = nospill("judge", str(motion))
    assert result.exit_code == 2 and "--scenario SCENARIO is needed" in result.stderr
    result = nospill("judge", str(motion), "--scenario", "coffee-to-go")
    assert result.exit_code == 2 and "motion of another arm" in result.stderr and result.stderr.count("\n") == 1
