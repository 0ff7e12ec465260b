"""The commands export and check on real plan folders: what they print, write and return."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from nospill.certification.certificate import certify
from nospill.cli import app
from nospill.errors import PlanFolderError
from nospill.export import EXPORTERS
from nospill.export.plan_files import compare_plan_files
from nospill.scenario import read_scenario


@pytest.fixture
def folder(gentle_plan, tmp_path: Path) -> Path:
    """A saved plan, alone in its parent folder."""
    place = tmp_path / "plans" / "tea"
    gentle_plan("matrix-rigid").save(place)
    return place


def nospill(*arguments: str) -> Any:
    return CliRunner().invoke(app, list(arguments), catch_exceptions=False, prog_name="nospill")


def joints_changed(path: Path, row: int, column: int, change: float) -> None:
    rows = [line.split(";") for line in path.read_text().splitlines()]
    rows[row][column] = f"{float(rows[row][column]) + change:.12f}"
    path.write_text("\n".join(";".join(cells) for cells in rows) + "\n")


def test_list_names_every_format():
    result = nospill("export", "--list")
    assert result.exit_code == 0
    for exporter in EXPORTERS.values():
        assert exporter.name in result.stdout
        assert exporter.suffixes[0] in result.stdout


@pytest.mark.parametrize("name", sorted(set(EXPORTERS) - {"urscript"}))
def test_a_file_beside_the_plan_with_its_verdict(folder, name):
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    result = nospill("export", str(folder), "--format", name)
    assert result.exit_code == 0, result.output
    target = folder.parent / f"tea{EXPORTERS[name].suffixes[0]}"
    assert target.exists()
    assert sorted(folder.parent.iterdir()) == sorted([folder, target])
    assert result.stdout.startswith(f"written to {target}: ")
    assert "certified as published: all" in result.stdout
    assert result.stderr == ""
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before, "the plan folder is left as it is"


def test_a_program_of_another_maker_is_refused(gentle_plan, folder):
    result = nospill("export", str(folder), "--format", "urscript")
    assert result.exit_code == 2
    assert "urscript: URScript is read by arms of Universal Robots; this one is comau-smart-six" in result.stderr
    assert result.stderr.count("\n") == 1 and not list(folder.parent.glob("*.script"))
    scene, urscript = gentle_plan("matrix-rigid").scene, EXPORTERS["urscript"]
    own = [f"left_{name}" for name in read_scenario("coffee-to-go").robot.joints]
    theirs = replace(scene, robot=replace(scene.robot, joints=tuple(own)))
    assert urscript.reason_against(theirs, 500.0) is None, "the maker's description behind a prefix"
    for name in ("ur3e", "my-ur5", "UR10e_cell"):
        assert urscript.reason_against(replace(scene, robot=replace(scene.robot, name=name)), 500.0) is None
    for name in ("burr5", "your7axis", "comau-racer-5-080"):
        assert urscript.reason_against(replace(scene, robot=replace(scene.robot, name=name)), 500.0) is not None


def test_a_rate_that_no_control_box_has(gentle_plan):
    scene = gentle_plan("matrix-rigid").scene
    named = replace(scene, robot=replace(scene.robot, name="ur5e"))
    reason = EXPORTERS["urscript"].reason_against(named, 250.0)
    assert reason is not None and "runs at 500 Hz (e-Series) or 125 Hz (CB3); use --rate 500" in reason


def test_only_an_arm_of_unknown_generation_is_cautioned(gentle_plan):
    scene = gentle_plan("matrix-rigid").scene
    urscript = EXPORTERS["urscript"]
    named = replace(scene, robot=replace(scene.robot, name="ur5e"))
    assert urscript.caution(named, 500.0) is None
    assert urscript.caution(scene, 125.0) == (
        "125 Hz is for CB3 controllers; e-Series ones play it at another pace and need --rate 500"
    )


def test_the_file_is_named_as_the_folder_was(folder, monkeypatch):
    monkeypatch.chdir(folder.parent)
    assert nospill("export", "tea", "--format", "mat").stdout.startswith("written to tea.mat: ")
    monkeypatch.chdir(folder)
    assert nospill("export", ".", "--format", "mat").stdout.startswith(f"written to {folder.parent / 'tea.mat'}: ")


def test_rate_and_place_as_given(folder, tmp_path):
    result = nospill(
        "export", str(folder), "--format", "joint-trajectory", "--rate", "125", "-o", str(tmp_path / "a.json")
    )
    assert result.exit_code == 0
    points = json.loads((tmp_path / "a.json").read_text())["msg"]["points"]
    assert points[1]["time_from_start"] == {"sec": 0, "nanosec": 8_000_000}
    assert "at 125 Hz (joint-trajectory)" in result.stdout


def test_a_file_that_is_not_certified_is_written_and_said_to_be_so(gentle_plan, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    gentle_plan("matrix-rigid").save("tea")
    result = nospill("export", "tea", "--format", "tray-csv", "--rate", "10", "-o", "coarse.csv")
    assert result.exit_code == 1
    assert Path("coarse.csv").exists()
    assert "not certified: " in result.stdout
    assert result.stderr.startswith("coarse.csv is not certified as tray-csv: ")
    assert result.stderr.endswith(" would do.\n") and result.stderr.count("\n") == 1
    advised = result.stderr.split("--rate ")[1].split(" ")[0]
    assert nospill("export", "tea", "--format", "tray-csv", "--rate", advised, "-o", "coarse.csv").exit_code == 0


def test_when_no_rate_would_do_the_scenario_is_named(folder, tmp_path, monkeypatch):
    monkeypatch.setattr("nospill.plans.handover.rate_that_would_do.__defaults__", ((10.0,),))
    result = nospill("export", str(folder), "--format", "tray-csv", "--rate", "10", "-o", str(tmp_path / "a.csv"))
    assert result.exit_code == 1
    assert 'none of the usual rates would do; plan with rate = "10 Hz" under [output].' in result.stderr


def test_a_plan_that_is_not_certified_has_no_certified_file(gentle_plan, tmp_path):
    plan = gentle_plan("matrix-rigid")
    fast = replace(plan.trajectory, joint_position=plan.trajectory.joint_position + 0.01)
    replace(plan, trajectory=fast, certificate=certify(fast, plan.scene)).save(tmp_path / "tea")
    result = nospill("export", str(tmp_path / "tea"), "--format", "mat")
    assert result.exit_code == 1
    assert "not certified as mat: " in result.stderr and result.stderr.endswith("; nor is the plan itself.\n")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "wants a plan folder and --format NAME"),
        (["DIR"], "wants a plan folder and --format NAME"),
        (["DIR", "--format", "dxf"], "no format 'dxf'; there are lab-csv"),
        (["DIR", "--format", "KRL"], "use --format csv --profile rsi-4ms"),
        (["DIR", "--format", "rapid"], "use --format csv --profile egm"),
        (["DIR", "--format", "mat", "--rate", "0"], "rate is 0 Hz; allowed are 10 to 1000 Hz"),
        (["DIR", "--format", "mat", "--rate", "nan"], "rate is nan Hz"),
        (["DIR", "--format", "lab-csv", "--rate", "250"], "the lab's controller plays 500 rows a second"),
        (["DIR", "--format", "mat", "-o", "DIR/a.mat"], "a plan folder holds nothing but the plan"),
        (["DIR", "--format", "mat", "-o", "DIR"], "a plan folder holds nothing but the plan"),
        (["DIR", "--format", "joint-trajectory", "-o", "a.csv"], "written as .yaml, .yml or .json"),
        (["missing", "--format", "mat"], "no such folder"),
    ],
)
def test_what_does_not_go_is_one_line(folder, monkeypatch, arguments, message):
    monkeypatch.chdir(folder.parent)
    result = nospill("export", *(argument.replace("DIR", str(folder)) for argument in arguments))
    assert result.exit_code == 2
    assert message in result.stderr and result.stderr.count("\n") == 1
    assert result.stdout == ""
    assert [path.name for path in folder.parent.iterdir()] == ["tea"]


# --- check ------------------------------------------------------------------------------------------------------------


def test_check_reads_the_robots_file(folder):
    result = nospill("check", str(folder))
    assert result.exit_code == 0
    assert "robot.csv holds the motion of the trajectory" in result.stdout


def test_check_notices_a_changed_joint_and_names_it(folder):
    joints_changed(folder / "robot.csv", row=900, column=2, change=0.01)
    result = nospill("check", str(folder))
    assert result.exit_code == 1
    assert "certified as published: all" in result.stdout, "the trajectory itself is as it was"
    # Row 901 of the file is instant 401: 500 rows of rest, then the first sample.
    assert "robot.csv is not the motion of the trajectory: joint_3 differs by 0.01 rad at t = 0.80" in result.stderr
    assert result.stderr.count("\n") == 1


def test_check_notices_rows_that_are_missing(folder):
    lines = (folder / "robot.csv").read_text().splitlines()
    (folder / "robot.csv").write_text("\n".join(lines[:-5]))
    result = nospill("check", str(folder))
    assert result.exit_code == 1
    assert "robot.csv holds " in result.stderr and "samples of the motion, the trajectory" in result.stderr


def test_check_refuses_a_file_in_no_format(folder):
    (folder / "robot.csv").write_text("hello\n")
    result = nospill("check", str(folder))
    assert result.exit_code == 2
    assert 'robot.csv, line 1: "hello" is not six finite numbers' in result.stderr


def test_every_single_joint_of_the_file_is_compared(gentle_plan, folder):
    plan, path = gentle_plan("matrix-rigid"), folder / "robot.csv"
    whole = path.read_text()
    random = np.random.default_rng(3)
    for column in range(6):
        path.write_text(whole)
        joints_changed(path, row=int(random.integers(550, 1500)), column=column, change=-2e-9)
        difference = compare_plan_files(plan.trajectory, plan.scene, folder)["robot.csv"]
        assert difference is not None and f"joint_{column + 1} differs by 2e-09 rad" in difference
    path.write_text(whole)
    assert compare_plan_files(plan.trajectory, plan.scene, folder) == {"robot.csv": None}
    path.unlink()
    assert compare_plan_files(plan.trajectory, plan.scene, folder) == {}
    path.mkdir()
    assert compare_plan_files(plan.trajectory, plan.scene, folder) == {}
    path.rmdir()
    path.write_bytes(b"\xff")
    with pytest.raises(PlanFolderError, match="not a text file"):
        compare_plan_files(plan.trajectory, plan.scene, folder)
