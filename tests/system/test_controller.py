"""Plans for an arm whose controller is late."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from nospill.certification.certificate import certify
from nospill.certification.run import run_of
from nospill.export import EXPORTERS
from nospill.export.plan_files import compare_plan_files
from nospill.planning.planner import plan
from nospill.plans.handover import hand_over
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan
from nospill.scenario import read_scenario
from nospill.scene.controller import Controller
from tests.builders import one_mode

DELAY, LAG = 0.008, 0.015
LATE = Controller(np.full(6, DELAY), np.full(6, LAG))
FEW = "planning.intervals=50"
LINEAR = "motion.slosh_height=linear"
"""So that liquids hold the motion back as closely as joints do."""


@pytest.fixture(scope="module")
def late_plan() -> Plan:
    """Planned with one mode for the controller: delay 8 ms, lag 15 ms."""
    settings = [f"controller.delay={DELAY}", f"controller.lag={LAG}", "planning.slosh_modes=1", LINEAR, FEW]
    return plan(read_scenario("matrix-liquid-tilt", settings=settings))


@pytest.mark.slow
def test_the_naive_plan_breaks_limits_where_the_compensated_one_keeps_them(late_plan: Plan) -> None:
    naive = plan(one_mode("matrix-liquid-tilt", LINEAR, FEW))
    played = certify(naive.trajectory, replace(naive.scene, controller=replace(LATE, compensate=False)))
    assert not played.ok
    assert {row.constraint for row in played.rows if not row.ok} >= {"slosh height"}
    assert late_plan.certificate.ok
    assert late_plan.duration < 1.03 * naive.duration


@pytest.mark.slow
def test_its_command_played_through_the_controller_by_hand_keeps_them(late_plan: Plan) -> None:
    """Whatever the judge does with a controller: the command as a file holds it, delayed and lagged in small steps."""
    command = run_of(late_plan.trajectory, LATE).command
    assert command is not None
    step = 1e-4
    t = np.arange(0.0, late_plan.trajectory.t[-1] + 0.3, step)
    asked = np.column_stack([np.interp(t - DELAY, command.t, own) for own in command.position.T])
    found, slope, decay = asked.copy(), np.diff(asked, axis=0) / step, np.exp(-step / LAG)
    for index in range(1, len(t)):
        before = found[index - 1] - asked[index - 1] + LAG * slope[index - 1]
        found[index] = asked[index] - LAG * slope[index - 1] + before * decay
    planned = np.column_stack(
        [np.interp(t - DELAY, late_plan.trajectory.t, own) for own in late_plan.trajectory.joint_position.T]
    )
    assert np.max(np.abs(found - planned)) < 2e-5


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(EXPORTERS))
def test_every_file_holds_the_command_and_is_certified_through_the_controller(
    late_plan: Plan, name: str, tmp_path: Path
) -> None:
    exporter = EXPORTERS[name]
    if exporter.reason_against(late_plan.scene, 500.0) is not None:
        pytest.skip("the format does not take this arm")
    done = hand_over(late_plan, exporter, tmp_path / f"file{exporter.suffixes[0]}")
    assert done.joint_deviation < 1e-5
    assert all(row.ok or row.use < 1.002 for row in done.certificate.rows)


@pytest.mark.slow
def test_a_plan_that_is_its_own_command_is_tightened_until_the_joints_keep_the_limits(late_plan: Plan) -> None:
    found = plan(late_plan.scene.changed({"controller.compensate": False}))
    assert found.certificate.ok
    assert found.duration < 1.03 * late_plan.duration


@pytest.mark.slow
def test_a_plan_folder_comes_back_with_its_controller(late_plan: Plan, tmp_path: Path) -> None:
    late_plan.save(tmp_path / "late")
    again = load_plan(tmp_path / "late")
    assert again.scene.controller is not None
    assert certify(again.trajectory, again.scene).ok
    assert compare_plan_files(again.trajectory, again.scene, tmp_path / "late") == {"robot.csv": None}


@pytest.mark.slow
def test_a_controller_that_would_stop_is_warned_of(late_plan: Plan) -> None:
    strict = late_plan.scene.changed({"controller.tracking_tolerance": 0.01})
    found = plan(strict, warm=late_plan)
    texts = [warning.text for warning in found.warnings if warning.name == "tracking"]
    assert texts
    assert "mrad behind its command" in texts[0]
