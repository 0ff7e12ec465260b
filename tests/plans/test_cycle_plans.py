"""Plans of cycles: legs in a row, one certificate over motions, dwells and seams, and a folder that nobody changes."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import nospill as ns
from nospill.certification.certificate import judge_motion
from nospill.certification.full_model import full_scene
from nospill.cli import app
from nospill.errors import PlanFolderError, ScenarioError
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.motion.holds import held_trajectory
from nospill.plans.cycle import leg_folder
from nospill.plans.handover import exporter_named
from nospill.plots.cycle import cycle_figure
from tests.cycles import small_plan, there_and_back

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("cycle") / "out"
    small_plan().save(place)
    return place


@pytest.fixture
def copied(folder: Path, tmp_path: Path) -> Path:
    return shutil.copytree(folder, tmp_path / "copy")


def test_legs_follow_each_other_and_the_time_is_all_of_it() -> None:
    plan = small_plan()
    assert plan.certificate.ok and plan.certificate.word == "certified as published"
    assert [leg.dwell for leg in plan.times] == [0.3, 0.2]
    assert plan.duration == pytest.approx(sum(one.trajectory.t[-1] for one in plan.legs) + 0.5, abs=1e-9)
    assert plan.times[1].begins == pytest.approx(plan.times[0].motion + 0.3)
    for one, other in zip(plan.legs, (*plan.legs[1:], plan.legs[0]), strict=True):
        np.testing.assert_allclose(one.trajectory.joint_position[-1], other.trajectory.joint_position[0], atol=1e-6)
    (near,) = plan.legs[1].scene.cargo
    assert near.filling is not None and near.filling.initial_swing is not None
    # the cup that stays swings on, so the cycle does not begin again at once
    assert plan.wait > 0.0 and "does not end as it began" in plan.repeats_text
    assert plan.cycles_per_hour == pytest.approx(3600.0 / (plan.duration + plan.wait))


def test_the_legs_in_a_row_are_the_motion_of_the_whole_from_rest() -> None:
    """Second opinion: all joints as one record, judged from rest, see the heights that the legs' certificates have."""
    plan = small_plan()
    scene = full_scene(plan.legs[1].scene.changed({"cargo.near.initial_swing": None}))
    parts = [held_trajectory(one.trajectory, one.scene.motion).joint_position for one in plan.legs]
    q = np.concatenate([parts[0], *(part[1:] for part in parts[1:])])
    t = np.arange(len(q)) / plan.legs[0].trajectory.rate
    assert t[-1] == pytest.approx(plan.duration)
    whole = ns.certify_joints(t, q, scene)
    height = next(row for row in whole.rows if row.constraint == SloshHeight.name).worst_value
    own = [
        row.worst_value
        for one in plan.legs
        for row in judge_motion(one.trajectory, full_scene(one.scene)).certificate.rows
        if row.constraint == SloshHeight.name and row.subject == "near"
    ]
    assert height == pytest.approx(max(own), rel=2e-3)


def test_a_folder_is_read_and_judged_again(folder: Path) -> None:
    read = ns.load_cycle_plan(folder)
    assert read.certificate.ok and read.duration == small_plan().duration
    again = ns.judge_cycle(read)
    assert again.certificate.ok and not again.certificate.changed
    summary = json.loads((folder / "cycle.json").read_text())
    assert summary["duration_s"] == read.duration and summary["legs"][0]["unload"] == ["far"]
    result = CliRunner().invoke(app, ["check", str(folder)])
    assert result.exit_code == 0, result.output
    assert "certified as published" in result.stdout and "cycles an hour" in result.stdout


def edit(file: Path, old: str, new: str) -> None:
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))


def test_another_dwell_is_caught_wherever_it_is_stated(copied: Path) -> None:
    leg = copied / leg_folder(0, "out") / "scenario.toml"
    edit(leg, "hold_after = 0.3", "hold_after = 0.5")
    verdict = ns.judge_cycle(ns.load_cycle_plan(copied)).certificate
    assert not verdict.ok and any("dwell is 0.5 s in the files" in fault for fault in verdict.changed)
    assert any("motion.hold_after is 0.5 in its folder and 0.3 by the cycle" in fault for fault in verdict.changed)
    # in the cycle's scenario and its summary too: what the next leg begins with is then another swing
    edit(copied / "scenario.toml", "dwell = 0.3", "dwell = 0.5")
    edit(copied / "cycle.json", '"dwell_s": 0.3', '"dwell_s": 0.5')
    verdict = ns.judge_cycle(ns.load_cycle_plan(copied)).certificate
    assert not verdict.ok and "cargo.near.initial_swing" in verdict.changed[0]
    result = CliRunner().invoke(app, ["check", str(copied)])
    assert result.exit_code == 1 and "cargo.near.initial_swing" in result.stderr


def test_another_leg_is_caught(copied: Path) -> None:
    edit(copied / leg_folder(1, "back") / "scenario.toml", 'max_slosh_height = "8 mm"', 'max_slosh_height = "9 mm"')
    verdict = ns.judge_cycle(ns.load_cycle_plan(copied)).certificate
    assert not verdict.ok and "cargo.near.max_slosh_height" in verdict.finding
    shutil.rmtree(copied / leg_folder(1, "back"))
    with pytest.raises(PlanFolderError, match="2-back: no such folder"):
        ns.load_cycle_plan(copied)


def test_a_leg_that_begins_in_other_joints_is_caught(copied: Path) -> None:
    """The way back turned in time: it is a motion, and begins where the way out begins."""
    file = copied / leg_folder(1, "back") / "trajectory.csv"
    shutil.copy(copied / leg_folder(0, "out") / "trajectory.csv", file)
    with pytest.raises((PlanFolderError, ScenarioError)):
        ns.judge_cycle(ns.load_cycle_plan(copied))


def test_a_swing_that_late_joints_leave_is_not_known() -> None:
    before, on = small_plan().legs
    late = before.scene.changed(
        {"fidelity": "full", "planning.slosh_modes": 1, "tolerance": {"tracking": {"delay": "4 ms"}}}
    )
    with pytest.raises(ScenarioError, match=r"tolerance\.tracking in there-and-back-out, the motion before: how late"):
        ns.with_residual_slosh(on.scene, replace(before, scene=late))


def test_commands_about_one_motion_name_the_folder_of_a_leg(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(PlanFolderError, match=r"holds a cycle, and one motion is meant here: .*legs/1-out"):
        ns.load_plan(folder)
    for command in ("report", "stops"):
        result = CliRunner().invoke(app, [command, str(folder)])
        assert result.exit_code == 2, result.output
    result = CliRunner().invoke(app, ["plan", "matrix-cycle", "--compare"])
    assert result.exit_code == 2 and "a cycle is planned without --compare" in result.stderr


def test_the_shortest_dwell_is_none_where_the_next_leg_bears_it() -> None:
    plan = ns.plan_cycle(there_and_back(out={"dwell": "shortest"}, back={"dwell": "shortest"}))
    assert plan.certificate.ok
    assert plan.times[0].dwell == 0.0
    assert plan.wait == 0.0  # the last dwell lasts until the cup that stays is at rest
    assert "dwell = 0.0" in plan.cycle.text


@pytest.mark.parametrize(("name", "suffix"), [("csv", ".csv"), ("joint-trajectory", ".yaml")])
def test_one_file_holds_the_whole_cycle_and_each_leg_is_judged_in_it(folder: Path, name: str, suffix: str) -> None:
    file = folder.with_name(f"whole{suffix}")
    result = CliRunner().invoke(app, ["export", str(folder), "--format", name, "-o", str(file)])
    assert result.exit_code == 0, result.output
    plan = small_plan()
    samples = exporter_named(name).read(file, plan.legs[0].scene)
    assert samples.t[-1] == pytest.approx(plan.duration, abs=1e-6)
    begins = plan.times[1].begins
    at_seam = samples.position[round(begins * samples.rate)]
    np.testing.assert_allclose(at_seam, plan.legs[1].trajectory.joint_position[0], atol=1e-6)
    assert result.stdout.count("certified as published: all") == 2


def test_a_program_that_states_one_payload_is_refused_for_a_load_that_changes(folder: Path) -> None:
    result = CliRunner().invoke(app, ["export", str(folder), "--format", "urscript"])
    assert result.exit_code == 2 and "states one payload for the file" in result.stderr
    result = CliRunner().invoke(app, ["export", str(folder), "--format", "csv", "--points", "50"])
    assert result.exit_code == 2 and "without --points" in result.stderr


def test_the_figure_has_every_liquid_on_every_leg_that_carries_it() -> None:
    plan = small_plan()
    heights, speeds = cycle_figure(plan).axes
    drawn = [np.array(line.get_xydata()) for line in heights.lines]
    lines = [line for line in drawn if len(line) > 2]  # the limit has two points
    assert len(lines) == 3 and len(speeds.lines) == 2  # two cups out, one back
    t = lines[-1][:, 0]
    assert t[0] >= plan.times[1].begins and t[-1] == pytest.approx(plan.duration, abs=0.01)
    assert max(line[:, 1].max() for line in lines) <= 100.0
