"""A plan with its approach: certified as a whole, kept in its folder, judged again, handed over, and stated of."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from nospill.certification.certificate import judge
from nospill.certification.verdict import APPROACH
from nospill.certification.wording import describe
from nospill.cli import app
from nospill.core.shapes import sphere_shape
from nospill.errors import MissingExtraError, NoSolutionError, PlanFolderError, ScenarioError
from nospill.export import EXPORTERS
from nospill.planning.planner import plan as find_plan
from nospill.plans.approach import (
    hand_over_approach,
    judge_whole,
    require_ruckig_if_needed,
    starts_alike,
    with_approach,
)
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan
from nospill.plans.records import PlanningReport, Starts, motion_maxima
from nospill.plans.settling import AFTER_APPROACH, settling_time
from nospill.plans.summary import failed_summary
from nospill.robots.kinematics.forward import kinematics
from nospill.scene.obstacles import Obstacle
from tests.builders import plan_for

EXAMPLE = "matrix-liquid-soft-end"
FORMATS = pytest.mark.parametrize("name", sorted(EXPORTERS))


@pytest.fixture(scope="module")
def moved(smooth_motion, changed_scene):
    """A slow motion of one cup whose scene asks for an approach; no solver is involved."""

    @cache
    def made(shift: tuple[float, ...] | None, table: frozenset) -> Plan:
        motion = smooth_motion(EXAMPLE, cargo=1, stretch=1.3)
        start = motion.trajectory.joint_position[0]
        came = "home" if shift is None else [float(value) for value in start + np.array(shift)]
        entry = {"from": came, "tray": "empty", "acceleration": "6 rad/s^2"} | dict(table)
        scene = motion.scene.changed({"approach": entry, "planning.slosh_modes": None})
        judgement = judge(motion.trajectory, scene)
        report = PlanningReport(1.0, 0.5, 10, 1, Starts(1, 1, 1, (2.0,)), {}, "none", {}, "start (1, 2) deg")
        maxima = motion_maxima(judgement, scene)
        return Plan(scene, motion.trajectory, judgement.certificate, maxima, report, judgement)

    def make(*, shift: list[float] | None = None, **table) -> Plan:
        return made(None if shift is None else tuple(shift), frozenset(table.items()))

    return make


@pytest.fixture(scope="module")
def whole(moved) -> Plan:
    return with_approach(moved())


@pytest.fixture(scope="module")
def loaded(moved) -> Plan:
    return with_approach(moved(shift=[0.5, 0, 0, 0, 0, 0], tray="loaded"))


@pytest.mark.slow
def test_a_plan_that_asks_for_none_is_left_alone(moved):
    plan = moved()
    bare = replace(plan, scene=replace(plan.scene, approach=None))
    assert with_approach(bare) is bare


@pytest.mark.slow
def test_the_certificate_has_the_rows_of_both(whole, moved):
    assert whole.approach is not None and whole.certificate.ok
    own = [row for row in whole.certificate.rows if row.constraint.startswith(APPROACH)]
    assert {row.constraint.removeprefix(APPROACH) for row in own} >= {
        "joint position",
        "joint speed",
        "joint acceleration",
        "joint jerk",
        "start",
        "end",
        "rest at the ends",
    }
    assert whole.certificate.rows[: -len(own)] == moved().certificate.rows
    assert whole.duration == moved().duration
    for row in own:
        assert "approach" in describe(row)


def test_a_broken_row_of_the_approach_breaks_the_certificate(whole):
    assert whole.approach is not None
    position = whole.approach.samples.position.copy()
    position[50, 0] += 1e-3
    spoilt = replace(
        whole, approach=replace(whole.approach, samples=replace(whole.approach.samples, position=position))
    )
    verdict = judge_whole(spoilt).certificate
    assert not verdict.ok and verdict.worst.constraint.startswith(APPROACH)


@pytest.mark.slow
def test_it_comes_back_from_its_folder_and_is_judged_the_same(loaded, tmp_path):
    loaded = loaded.with_second_looks()
    loaded.save(tmp_path / "out")
    back = load_plan(tmp_path / "out")
    assert back.approach is not None and loaded.approach is not None
    assert back.approach.loaded and back.approach.stretch == loaded.approach.stretch
    assert np.array_equal(back.approach.samples.position, loaded.approach.samples.position)
    assert back.summary() == loaded.summary()
    assert back.certificate == loaded.certificate == judge_whole(back).certificate
    stated = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert stated["approach"] == {
        "file": "approach.csv",
        "duration_s": loaded.approach.duration,
        "tray": "loaded",
        "stretch": loaded.approach.stretch,
    }
    assert stated["branch"] == "start (1, 2) deg" and stated["base_yaw"] is None
    loaded.save(tmp_path / "out")  # a folder with an approach may be replaced
    (tmp_path / "out" / "approach.csv").unlink()
    with pytest.raises(PlanFolderError, match=r"approach\.csv"):
        load_plan(tmp_path / "out")


@pytest.mark.slow
def test_folders_of_earlier_versions_are_read(moved, tmp_path):
    plan = moved()
    old = replace(plan, scene=plan.scene.changed({"approach": None}))
    old.save(tmp_path / "out")
    file = tmp_path / "out" / "summary.json"
    stated = json.loads(file.read_text())
    for key in ("branch", "base_yaw", "approach"):
        del stated[key]
    file.write_text(json.dumps(stated))
    back = load_plan(tmp_path / "out")
    assert back.report.branch == "" and back.report.base_yaw is None and back.approach is None
    assert back.certificate == plan.certificate


def test_a_failed_summary_has_the_new_keys(whole):
    assert list(failed_summary("x", "no")) == list(whole.summary())


@pytest.mark.slow
def test_a_loaded_tray_that_leans_too_far_is_refused_and_the_constraint_named(moved):
    with pytest.raises(NoSolutionError, match=r"No approach found: .*c1.*start nearer") as caught:
        with_approach(moved(shift=[0.3, 0, 0, 0, 0.8, 0], tray="loaded"))
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == 3


def test_the_liquid_needs_time_after_a_loaded_approach(whole, loaded):
    assert settling_time(whole.scene, whole.certificate, AFTER_APPROACH) == 0.0
    wait = settling_time(loaded.scene, loaded.certificate, AFTER_APPROACH)
    row = next(item for item in loaded.certificate.rows if item.constraint == AFTER_APPROACH)
    cargo = loaded.scene.cargo[0]
    assert cargo.filling is not None
    decay = min(mode.damping * mode.frequency for mode in cargo.filling.modes.oscillators)
    assert wait > 0.0
    assert row.worst_value * np.exp(-decay * wait) == pytest.approx(0.02 * cargo.filling.max_slosh_height)


@FORMATS
def test_it_is_handed_over_as_a_file_of_its_own(whole, tmp_path, name):
    exporter, whole = EXPORTERS[name], plan_for(whole, name)
    done = hand_over_approach(whole, exporter, tmp_path / f"a{exporter.suffixes[0]}")
    assert done.certificate.ok, [row for row in done.certificate.rows if not row.ok]
    assert done.joint_deviation < 1e-6
    assert whole.approach is not None and done.samples == len(whole.approach.samples.t)
    read = exporter.read(done.path, whole.scene).position
    assert np.allclose(read[-1], whole.trajectory.joint_position[0], atol=1e-6)


def test_a_loaded_approach_is_handed_over_with_its_cargo_rows(loaded, tmp_path):
    done = hand_over_approach(loaded, EXPORTERS["mat"], tmp_path / "a.mat", rate=250.0)
    assert done.rate == pytest.approx(250.0)
    assert "approach slosh height" in {row.constraint for row in done.certificate.rows}


def test_a_plan_without_one_has_none_to_hand_over(moved, tmp_path):
    with pytest.raises(ScenarioError, match="has no approach"):
        hand_over_approach(moved(), EXPORTERS["mat"], tmp_path / "a.mat")


def test_without_ruckig_nothing_is_begun(whole, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "ruckig", None)
    with pytest.raises(MissingExtraError):
        require_ruckig_if_needed(whole.scene)
    with pytest.raises(MissingExtraError):
        find_plan(whole.scene)
    require_ruckig_if_needed(replace(whole.scene, approach=None))


@pytest.mark.slow
def test_export_and_check_tell_of_it(whole, tmp_path):
    runner = CliRunner()
    whole.save(tmp_path / "out")
    answer = runner.invoke(app, ["check", str(tmp_path / "out")])
    assert answer.exit_code == 0 and "approach joint speed" in answer.stdout
    answer = runner.invoke(app, ["export", str(tmp_path / "out"), "--format", "mat"])
    assert answer.exit_code == 0 and not (tmp_path / "out-approach.mat").exists()
    answer = runner.invoke(app, ["export", str(tmp_path / "out"), "--format", "mat", "--with-approach"])
    assert answer.exit_code == 0, answer.output
    assert (tmp_path / "out.mat").exists() and (tmp_path / "out-approach.mat").exists()
    assert "collisions with what is around are not checked" in answer.stdout


@pytest.mark.slow
def test_export_refuses_what_is_not_there(moved, tmp_path):
    plan = moved()
    replace(plan, scene=plan.scene.changed({"approach": None})).save(tmp_path / "out")
    answer = CliRunner().invoke(app, ["export", str(tmp_path / "out"), "--format", "mat", "--with-approach"])
    assert answer.exit_code == 2 and "this plan has no approach" in answer.stderr
    assert not (tmp_path / "out.mat").exists()


def test_what_was_assumed_of_the_arm_is_said_once_on_stderr(changed_scene, tmp_path):
    changes = {"robot.limits": {"upper": [2.9, 2.5, -1.9, 9.0, 2.2, 9.0]}, "path.offset": [3.0, 0.0, 0.0]}
    scene = changed_scene("matrix-rigid", changes)
    scene.save(tmp_path / "task.toml")
    answer = CliRunner().invoke(app, ["plan", str(tmp_path / "task.toml"), "--json"])
    assert answer.exit_code == 2 and answer.stdout == ""
    (note,) = scene.robot.notes
    assert answer.stderr.count(note) == 1 and "out of reach" in answer.stderr


def test_scenes_start_alike_where_they_say_the_same(whole, changed_scene):
    silent, same = changed_scene(EXAMPLE, {}), replace(whole.scene, start_near=whole.scene.start_near.copy())
    assert starts_alike(silent, changed_scene("mixed-tray", {})) and starts_alike(whole.scene, same)
    assert not starts_alike(silent, same) and not starts_alike(same, silent)
    assert not starts_alike(same, replace(same, start_near=same.start_near + 0.1))


@pytest.mark.slow
def test_plan_says_what_it_took_and_the_folder_holds_it(changed_scene, tmp_path: Path):
    home = [0.0, -0.26, -1.83, -3.1, 1.57, 3.0]
    changes = {
        "approach": {"from": "home", "tray": "empty", "acceleration": 6},
        "robot.home": home,
        "robot.base_yaw": "free",
        "motion.hold_after": "0.2 s",
    }
    changed_scene("matrix-rigid", changes).save(tmp_path / "task.toml")
    answer = CliRunner().invoke(app, ["plan", str(tmp_path / "task.toml"), "-o", str(tmp_path / "out"), "--no-figures"])
    assert answer.exit_code == 0, answer.output
    plan = load_plan(tmp_path / "out")
    assert plan.certificate.ok and judge_whole(plan).certificate.ok
    # the flipped wrist is taken, since the arm stands there
    assert plan.trajectory.joint_position[0, 4] > 0.0
    assert f"branch: {plan.report.branch}" in answer.stdout
    assert plan.report.base_yaw == "0 deg" == plan.scene.source["robot"]["base_yaw"]  # type: ignore[index]
    assert "base yaw: 0 deg (left free)" in answer.stdout
    assert "with the tray empty; collisions with what is around are not checked" in answer.stdout
    assert {"approach", "base yaw"} <= set(plan.report.phases)
    assert np.array_equal(plan.approach.samples.position[0], home)  # type: ignore[union-attr]


@pytest.mark.slow
def test_an_obstacle_between_is_named(moved) -> None:
    """A ball where the flange is half-way to the start, and the same out of the way."""
    plan = moved()
    robot = plan.scene.robot
    halfway = (plan.scene.approach.start + plan.trajectory.joint_position[0]) / 2
    place, _ = kinematics(robot).poses(halfway[None])
    ball = Obstacle("ball", sphere_shape(0.03), place[0], np.zeros(3), 0.005)
    with pytest.raises(
        NoSolutionError, match=r"No approach found: approach clearance of .* to ball .*not led round"
    ) as e:
        with_approach(replace(plan, scene=replace(plan.scene, obstacles=(ball,))))
    assert e.value.reason is not None and e.value.reason.constraint == "approach clearance"
    aside = replace(ball, position=np.array([0.0, 0.0, 3.0]))
    found = with_approach(replace(plan, scene=replace(plan.scene, obstacles=(aside,))))
    assert any(row.constraint == "approach clearance" for row in found.certificate.rows) and found.certificate.ok
