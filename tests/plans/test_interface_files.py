"""Files of plans, judged as the interface of the arm's controller reads them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.export import EXPORTERS
from nospill.export.joint_csv import csv_exporter
from nospill.motion.interpolation import QUINTIC_HERMITE, QUINTIC_SPLINE, JointSamples
from nospill.plans.handover import hand_over
from nospill.plans.plan import Plan
from nospill.plans.played import done_by, planned_samples
from nospill.robots.interfaces import INTERFACES
from nospill.scenario import scene_from_table
from nospill.scene.controller import Controller
from tests.franka_plans import drawn_tables


def asked_by(plan: Plan, name: str, rate: float, points: int | None = None) -> Plan:
    """The plan with an interface, joints that are not late."""
    none = np.zeros(len(plan.scene.robot.joints))
    controller = Controller(none, none, interface=INTERFACES[name], update_rate=rate, points=points)
    return replace(plan, scene=replace(plan.scene, controller=controller))


def test_between_the_positions_that_are_read_the_joints_move_on_their_spline(gentle_plan: Callable[..., Plan]) -> None:
    plan = asked_by(gentle_plan("matrix-rigid", 1), "jtc", 100.0)
    samples = planned_samples(plan, 500.0)
    motion = QUINTIC_HERMITE.motion(samples)
    t = np.arange(np.ceil(samples.t[-1] * 100.0) + 1) / 100.0
    read = QUINTIC_SPLINE.motion(JointSamples(t, motion(t)))
    fine = np.linspace(0.0, samples.t[-1], 3000)
    assert done_by(plan, samples, motion)(fine, 2) == pytest.approx(read(fine, 2), abs=1e-9)
    assert np.max(np.abs(read(fine, 2) - motion(fine, 2))) > 1e-3, "a coarse rate rounds the motion"


@pytest.mark.slow
@pytest.mark.parametrize("rate", [500.0, 125.0])
def test_a_file_of_an_interface_is_certified_at_its_rate(
    gentle_plan: Callable[..., Plan], tmp_path: Path, rate: float
) -> None:
    plan = asked_by(gentle_plan("matrix-rigid", 1), "jtc", rate)
    done = hand_over(plan, EXPORTERS["joint-trajectory"], tmp_path / "motion.yaml", rate=rate)
    assert done.certificate.ok


@pytest.mark.slow
def test_files_have_no_more_points_than_the_controller_takes(gentle_plan: Callable[..., Plan], tmp_path: Path) -> None:
    plan, path = gentle_plan("matrix-rigid", 1), tmp_path / "motion.yaml"
    done = hand_over(asked_by(plan, "jtc", 500.0, points=200), EXPORTERS["joint-trajectory"], path)
    assert done.certificate.ok and not done.even and done.samples <= 200
    with pytest.raises(ScenarioError, match=r"controller\.points 5: \d+ points are the fewest"):
        hand_over(asked_by(plan, "jtc", 500.0, points=5), EXPORTERS["joint-trajectory"], path)


def test_a_file_for_a_franka_says_where_the_checks_of_its_interface_are_left_out() -> None:
    table = next(drawn_tables())
    plain, checked = (scene_from_table(table | {"controller": own}, name="own") for own in ({}, {"interface": "fci"}))
    said = csv_exporter("franka").caution(plain, 1000.0)
    assert said is not None and 'plan with [controller] interface = "fci"' in said
    assert csv_exporter("franka").caution(checked, 1000.0) is None
    assert csv_exporter().caution(plain, 1000.0) is None


@pytest.mark.slow
def test_the_example_of_a_franka_has_files_for_its_clients(example_plan: Callable[[str], Plan], tmp_path: Path) -> None:
    done = hand_over(example_plan("shelf-to-table"), csv_exporter("franka"), tmp_path / "shelf.joints.csv")
    assert done.rate == pytest.approx(1000.0) and done.certificate.ok
