"""Files of real plans, read back and judged as their receivers play them; and every way to spoil one is noticed."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nospill.certification.certificate import certify
from nospill.errors import NospillError, PlanFolderError, ScenarioError
from nospill.export import EXPORTERS
from nospill.export.base import Exporter
from nospill.motion.interpolation import QUINTIC_HERMITE, JointSamples
from nospill.motion.resampling import resampled
from nospill.plans.handover import (
    certified,
    exporter_named,
    hand_over,
    judge_exported_file,
    rate_that_would_do,
)
from nospill.plans.plan import Plan
from nospill.plans.played import OF_CONTROLS
from nospill.robots.description.catalog import load_robot
from tests.builders import plan_for

FORMATS = pytest.mark.parametrize("name", sorted(EXPORTERS))
RATES = (100.0, 125.0, 250.0, 500.0, 1000.0)


def file_of(exporter: Exporter, folder: Path) -> Path:
    return folder / f"motion{exporter.suffixes[0]}"


def rewritten(plan: Plan, name: str, folder: Path, **changes: Any) -> tuple[Exporter, Path]:
    """A file that holds other samples than the plan's."""
    exporter, plan = EXPORTERS[name], plan_for(plan, name)
    path = file_of(exporter, folder)
    exporter.write(replace(resampled(plan.trajectory, 500.0), **changes), plan.scene, path)
    return exporter, path


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "example", "rate"),
    [
        # every format at the rate at which what lies between its samples counts most, on a tray that is level
        *((name, "matrix-liquid-soft-end", RATES[0]) for name in sorted(EXPORTERS)),
        # a table, and what states speeds: at every rate
        *((name, "matrix-liquid-soft-end", rate) for name in ("csv", "joint-trajectory") for rate in RATES[1:]),
        # what is played a row a period, at another rate than its own and at its own
        *((name, "matrix-liquid-soft-end", rate) for name in ("lab-csv", "tray-csv") for rate in RATES[2:4]),
        # a tray that tilts: poses, and joints
        *((name, "mixed-tray", RATES[-1]) for name in ("tray-csv", "joint-trajectory")),
    ],
)
def test_every_format_at_rates_it_takes_is_certified(gentle_plan, tmp_path, name, rate, example):
    plan, exporter = plan_for(gentle_plan(example, 1), name), EXPORTERS[name]
    if exporter.reason_against(plan.scene, rate):
        with pytest.raises(ScenarioError, match=f"^{name}: rate is {rate:g} Hz"):
            hand_over(plan, exporter, file_of(exporter, tmp_path), rate=rate)
        assert not list(tmp_path.iterdir())
        return
    done = hand_over(plan, exporter, file_of(exporter, tmp_path), rate=rate)
    assert done.certificate.ok, [row for row in done.certificate.rows if not row.ok]
    assert done.rate == pytest.approx(rate, rel=1e-6)
    assert done.samples == np.ceil(plan.trajectory.t[-1] * rate - 1e-6) + 1
    assert done.joint_deviation < 1e-4 / rate
    assert {row.constraint for row in done.certificate.rows} == {
        row.constraint for row in plan.certificate.rows
    } - OF_CONTROLS
    assert done.certificate.grid_hz >= 2000.0 * (1 - 1e-9)


@pytest.mark.slow
@FORMATS
@pytest.mark.parametrize("example", ["matrix-rigid"])
def test_optimal_plans_are_certified_in_every_format_at_their_own_rate(example_plan, tmp_path, name, example):
    plan, exporter = plan_for(example_plan(example), name), EXPORTERS[name]
    done = hand_over(plan, exporter, file_of(exporter, tmp_path))
    assert done.rate == pytest.approx(plan.scene.output_rate)
    assert done.certificate.ok, [row for row in done.certificate.rows if not row.ok]


@pytest.mark.slow
def test_an_optimal_plan_at_a_coarse_rate_is_not_certified_and_a_rate_that_would_do_is_found(example_plan, tmp_path):
    plan, exporter = example_plan("matrix-rigid"), EXPORTERS["joint-trajectory"]
    done = hand_over(plan, exporter, file_of(exporter, tmp_path), rate=50.0)
    assert not done.certificate.ok
    assert done.path.exists()
    rate = rate_that_would_do(plan, exporter)
    assert rate is not None and rate > 50.0
    assert hand_over(plan, exporter, done.path, rate=rate).certificate.ok


def test_no_rate_would_do_for_a_motion_that_is_too_fast(gentle_plan):
    plan = gentle_plan("matrix-rigid", 1)
    slow = replace(plan.scene, robot=replace(plan.scene.robot, max_speed=plan.scene.robot.max_speed / 100))
    assert rate_that_would_do(replace(plan, scene=slow), EXPORTERS["mat"]) is None


@pytest.mark.slow
def test_the_planned_motion_as_its_own_receiver_changes_no_verdict(gentle_plan):
    plan = gentle_plan("matrix-liquid-soft-end", 1)
    record = plan.trajectory
    assert certify(record, plan.scene, motion=record.motion) == certify(record, plan.scene)
    own = JointSamples(record.t, record.joint_position)
    assert certified(plan, own, record.motion).ok


def test_jerk_of_a_file_is_that_of_its_own_samples(gentle_plan):
    """At twice the rate the third difference of the file itself is the value, and not that of every second sample."""
    plan = gentle_plan("matrix-rigid", 1)
    robot = replace(plan.scene.robot, max_jerk=np.full(6, 1e3))
    limited = replace(plan, scene=replace(plan.scene, robot=robot))
    samples = resampled(plan.trajectory, 1000.0)
    rows = certified(limited, samples, plan.trajectory.motion).rows
    position = np.pad(samples.position, ((2, 2), (0, 0)), mode="edge")
    jerks = np.max(np.abs(np.diff(position, n=3, axis=0)), axis=0) * 1000.0**3
    found = {row.subject: abs(row.worst_value) for row in rows if row.constraint == "joint jerk"}
    assert list(found.values()) == pytest.approx(list(jerks), rel=1e-5)


@pytest.mark.slow
def test_what_the_receiver_does_between_the_samples_is_judged(gentle_plan):
    """Positions of the plan at every sample, but a swing of 200 Hz between them: only the interpolation shows it."""
    plan = gentle_plan("matrix-liquid-soft-end", 1)
    samples = resampled(plan.trajectory, 100.0)
    assert samples.speed is not None
    swinging = replace(samples, speed=samples.speed + 0.3 * (-1.0) ** np.arange(len(samples.t))[:, None])
    verdict = certified(plan, swinging, QUINTIC_HERMITE.motion(swinging))
    assert "slip" in {row.constraint for row in verdict.rows if not row.ok}
    positions = EXPORTERS["lab-csv"].interpolation.motion(swinging)
    assert certified(plan, swinging, positions).ok


@FORMATS
def test_one_sample_off_by_a_millirad_is_noticed(gentle_plan, tmp_path, name):
    plan = gentle_plan("matrix-rigid", 1)
    position = resampled(plan.trajectory, 500.0).position.copy()
    position[401, 2] += 1e-3
    exporter, path = rewritten(plan, name, tmp_path, position=position)
    done = judge_exported_file(plan, exporter, path)
    assert not done.certificate.ok
    assert done.joint_deviation == pytest.approx(1e-3, rel=0.1)
    assert "path position" in {row.constraint for row in done.certificate.rows if not row.ok}


@FORMATS
def test_a_file_of_another_length_is_refused(gentle_plan, tmp_path, name):
    plan = gentle_plan("matrix-rigid", 1)
    samples = resampled(plan.trajectory, 500.0)
    cut = {field: getattr(samples, field)[:-20] for field in ("t", "position", "speed", "acceleration")}
    exporter, path = rewritten(plan, name, tmp_path, **cut)
    with pytest.raises(PlanFolderError, match=r"lasts .* s; the plan lasts"):
        judge_exported_file(plan, exporter, path)


@FORMATS
def test_a_file_that_ends_elsewhere_is_refused(gentle_plan, tmp_path, name):
    plan = gentle_plan("matrix-rigid", 1)
    position = resampled(plan.trajectory, 500.0).position.copy()
    position[-1, 1] += 1e-4
    exporter, path = rewritten(plan, name, tmp_path, position=position)
    with pytest.raises(PlanFolderError, match=r"joint_2 ends 0\.0001 rad from where it ends in the plan"):
        judge_exported_file(plan, exporter, path)


def test_samples_must_come_evenly_to_whom_plays_a_row_a_period(gentle_plan, tmp_path):
    plan = gentle_plan("matrix-rigid", 1)
    t = resampled(plan.trajectory, 500.0).t.copy()
    t[100] += 2e-6
    exporter, path = rewritten(plan, "tray-csv", tmp_path, t=t)
    with pytest.raises(PlanFolderError, match=r"samples 10[01] and 10[12] are .* s apart"):
        judge_exported_file(plan, exporter, path)


@pytest.mark.parametrize("name", ["joint-trajectory", "action-goal", "rosbag2", "csv", "mat"])
def test_uneven_points_may_not_hide_between_instants_of_the_judge(gentle_plan, tmp_path, name):
    plan = gentle_plan("matrix-rigid", 1)
    t = resampled(plan.trajectory, 500.0).t.copy()
    t[100] = t[99] + 5e-4
    exporter, path = rewritten(plan, name, tmp_path, t=t)
    with pytest.raises(PlanFolderError, match=r"samples 100 and 101 are 0\.5 ms apart; at least 1 ms can be judged"):
        judge_exported_file(plan, exporter, path)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["joint-trajectory", "csv"])
def test_the_fewest_points_are_certified_and_one_fewer_is_refused(gentle_plan, tmp_path, name):
    plan, exporter = gentle_plan("matrix-rigid", 1), EXPORTERS[name]
    path = file_of(exporter, tmp_path)
    done = hand_over(plan, exporter, path, points=200)
    assert done.certificate.ok and not done.even and 5 < done.samples <= 120
    found = exporter.read(path, plan.scene)
    assert set(np.round(found.t * 500.0).astype(int)) <= set(range(len(plan.trajectory.t))), "some of the plan's own"
    assert done.joint_deviation < 5e-4
    path.unlink()
    with pytest.raises(ScenarioError, match=rf"--points 5: {done.samples} points are the fewest .* would do"):
        hand_over(plan, exporter, path, points=5)
    assert not path.exists()


def test_a_format_by_its_name_and_a_file_by_its_text(gentle_plan, tmp_path):
    plan = gentle_plan("matrix-rigid", 1)
    done = hand_over(plan, "joint-trajectory", str(tmp_path / "motion.yaml"), rate=250.0, prefix="left_")
    assert done.exporter.name == "joint-trajectory" and done.rate == 250.0
    assert 'joint_names: ["left_joint_1", ' in done.path.read_text(encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"no format 'ur'; there are lab-csv, .*; did you mean 'urscript'"):
        hand_over(plan, "ur", tmp_path / "motion.script")
    with pytest.raises(ScenarioError, match="joint-trajectory: no option --gain; its options are --prefix"):
        hand_over(plan, "joint-trajectory", tmp_path / "motion.yaml", gain=300)


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("lab-csv", {"points": 50}, "lab-csv: is played a row a period, evenly spaced; leave --points out"),
        ("mat", {"points": 50, "rate": 250.0}, "few points are some of the plan's own; leave --rate or --points out"),
    ],
)
def test_points_where_there_are_none(gentle_plan, tmp_path, name, options, message):
    exporter = EXPORTERS[name]
    with pytest.raises(ScenarioError, match=message):
        hand_over(gentle_plan("matrix-rigid", 1), exporter, file_of(exporter, tmp_path), **options)
    assert not list(tmp_path.iterdir())


def test_bounds_of_the_plans_own_controls_are_no_rows_of_a_file(gentle_plan):
    """A jerk of the tilt angles, or of the path parameter, is nothing that a controller knows."""
    plan = gentle_plan("matrix-rigid", 1)
    strict = replace(plan, scene=replace(plan.scene, motion=replace(plan.scene.motion, path_jerk_limit=1e-3)))
    samples = resampled(plan.trajectory, 500.0)
    assert not certify(plan.trajectory, strict.scene).ok
    assert certified(strict, samples, QUINTIC_HERMITE.motion(samples)).ok


def test_what_lies_closer_together_than_the_judge_looks_is_refused(gentle_plan, tmp_path):
    plan, path = gentle_plan("matrix-rigid", 1), tmp_path / "dense.mat"
    motion, t = plan.trajectory.motion, np.arange(round(plan.trajectory.t[-1] * 4000) + 1) / 4000
    dense = JointSamples(t, motion(t), motion(t, 1), motion(t, 2))
    EXPORTERS["mat"].write(dense, plan.scene, path)
    with pytest.raises(PlanFolderError, match="4000 samples per second; at most 1000 can be judged"):
        judge_exported_file(plan, EXPORTERS["mat"], path)


@pytest.mark.parametrize("name", ["csv", "joint-trajectory", "action-goal", "rosbag2", "mat"])
def test_seven_joints_are_handed_over_whole(gentle_plan, samples, tmp_path, name):
    """The motion leads nowhere near the path, which the verdict says; what is played is all seven joints."""
    plan, motion = gentle_plan("matrix-rigid", 1), samples(200, joints=7)
    scene = replace(plan.scene, robot=load_robot("franka-fr3"))
    record = {
        field.name: getattr(plan.trajectory, field.name)[:200]
        for field in fields(plan.trajectory)
        if field.name not in ("joints", "slosh", "in_motion")
    }
    record |= {
        "joint_position": motion.position,
        "joint_speed": motion.speed,
        "joint_acceleration": motion.acceleration,
    }
    seven = replace(plan, scene=scene, trajectory=replace(plan.trajectory, joints=scene.robot.joints, **record))
    done = hand_over(seven, EXPORTERS[name], file_of(EXPORTERS[name], tmp_path), rate=250.0)
    assert done.joint_deviation < 1e-5
    assert {row.subject for row in done.certificate.rows} >= set(scene.robot.joints)
    assert "path position" in {row.constraint for row in done.certificate.rows if not row.ok}


def test_formats_that_do_not_exist_are_named():
    with pytest.raises(ScenarioError, match="no format 'dxf'; there are lab-csv, csv, joint-trajectory"):
        exporter_named("dxf")


@FORMATS
def test_a_file_that_is_missing_is_an_error_in_words(gentle_plan, tmp_path, name):
    with pytest.raises(NospillError, match="write it again with nospill"):
        judge_exported_file(gentle_plan("matrix-rigid", 1), EXPORTERS[name], file_of(EXPORTERS[name], tmp_path))
