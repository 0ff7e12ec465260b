"""Records judged through the arm's controller."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.certificate import certify, judge
from nospill.certification.run import COMMAND
from nospill.certification.verdict import Certificate
from nospill.plans.plan import Plan
from nospill.plans.warnings import plan_warnings
from nospill.robots.kinematics.forward import kinematics
from nospill.scene.controller import Controller
from nospill.scene.scene import Scene

DELAY, LAG = np.full(6, 0.008), np.full(6, 0.015)


@pytest.fixture(scope="module")
def plan(gentle_plan: Callable[..., Plan]) -> Plan:
    return gentle_plan("matrix-liquid", cargo=1)


def through(plan: Plan, *, compensate: bool, factor: float = 1.0) -> Scene:
    return replace(plan.scene, controller=Controller(DELAY, factor * LAG, compensate=compensate))


def by_row(certificate: Certificate) -> dict[tuple[str, str], float]:
    return {(row.constraint, row.subject): row.worst_value for row in certificate.rows}


def test_a_compensated_plan_is_judged_as_if_there_were_no_controller(plan: Plan) -> None:
    without, within = certify(plan.trajectory, plan.scene), certify(plan.trajectory, through(plan, compensate=True))
    assert within.ok
    ours, theirs = by_row(within), by_row(without)
    assert ours.keys() == theirs.keys()
    for row in without.rows:
        key = row.constraint, row.subject
        if row.constraint not in ("joint speed", "joint position"):
            assert ours[key] == pytest.approx(theirs[key], abs=2e-3 * abs(row.limit) + 1e-6), key


def test_rows_of_position_and_speed_are_of_the_command_where_that_is_nearer(plan: Plan) -> None:
    rows = certify(plan.trajectory, through(plan, compensate=True)).rows
    within, without = (
        {row.subject: row for row in found if row.constraint == "joint speed"}
        for found in (rows, plan.certificate.rows)
    )
    assert within["joint_1"].variant == COMMAND
    assert within["joint_1"].use > without["joint_1"].use


def test_what_is_not_compensated_is_judged_as_the_joints_do_it(plan: Plan) -> None:
    """The arm comes later, and rests later; the checks of the record are about the command."""
    found = judge(plan.trajectory, through(plan, compensate=False, factor=4.0))
    straight = judge(plan.trajectory, plan.scene)
    assert found.replay.t[-1] > straight.replay.t[-1] + 0.3
    assert all(row.ok for row in found.certificate.record_rows())
    assert [row.constraint for row in found.certificate.record_rows()] == [
        row.constraint for row in straight.certificate.record_rows()
    ]
    ours, theirs = by_row(found.certificate), by_row(straight.certificate)
    assert ours.keys() == theirs.keys()
    assert ours["slosh height", "c1"] != pytest.approx(theirs["slosh height", "c1"], rel=1e-3)
    assert ours["path jerk", "path"] == pytest.approx(theirs["path jerk", "path"])


# --- the tray that follows ----------------------------------------------------------------------------------------


UNLIKE = Controller(np.array([0.0, 0.02, 0.0, 0.02, 0.0, 0.0]), np.array([0.06, 0.02, 0.05, 0.02, 0.02, 0.02]), False)


def follower(plan: Plan, controller: Controller) -> np.ndarray:
    """Joints behind the command by delay and lag, by small steps: lag q' + q = command(t - delay)."""
    step = 2e-4
    t = np.arange(0.0, plan.duration + 0.6, step)
    q = np.repeat(plan.trajectory.joint_position[:1], len(t), axis=0)
    asked = np.column_stack(
        [plan.trajectory.motion(t + 0.5 * step - own)[:, joint] for joint, own in enumerate(controller.delay)]
    )
    for index in range(1, len(t)):
        q[index] = asked[index - 1] + (q[index - 1] - asked[index - 1]) * np.exp(-step / controller.lag)
    return q


def test_rows_about_the_path_are_of_the_command_and_say_so(plan: Plan) -> None:
    late = replace(plan.scene, controller=UNLIKE)
    certificate = certify(plan.trajectory, late)
    of_command = {row.constraint for row in certificate.rows if row.variant == COMMAND}
    assert {"path position", "path attitude", "tilt", "path jerk"} <= of_command
    assert not of_command & {"slip", "slosh height", "lift", "tip", "twist"}
    straight = certify(plan.trajectory, plan.scene)
    assert all(row.variant != COMMAND for row in straight.rows)


def test_the_tray_that_follows_is_said_to_leave_its_path_and_to_lean(plan: Plan) -> None:
    """Against joints integrated step by step, and distances from a fine row of points on the path."""
    late = replace(plan.scene, controller=UNLIKE)
    said = {item.name: item for item in plan_warnings(late, judge(plan.trajectory, late), {})}
    q = follower(plan, UNLIKE)[::10]
    tray = kinematics(late.robot).motions(q, 0.0 * q, 0.0 * q, tool=late.tray.tool)
    path = late.path.at(np.linspace(0.0, 1.0, 20001))[:, :3]
    off = max(float(np.min(np.linalg.norm(path - place, axis=1))) for place in tray.position)
    lean = float(np.max(np.arccos(np.clip(tray.rotation[:, 2, 2], -1.0, 1.0))))
    assert off > 1e-3 and lean > 1e-3
    assert said["off the path"].value == pytest.approx(off, rel=2e-2)
    assert said["not level"].value == pytest.approx(lean, rel=2e-2)
    for controller in (None, replace(UNLIKE, compensate=True)):
        kept = replace(plan.scene, controller=controller)
        names = {item.name for item in plan_warnings(kept, judge(plan.trajectory, kept), {})}
        assert not names & {"off the path", "not level"}


def test_a_tray_that_follows_keeps_to_its_tilt_and_its_corridor(smooth_motion) -> None:
    """Limits that are stated bind the tray itself: joints that lag differently lean it farther than they should."""
    tilting = smooth_motion("matrix-liquid-tilt")
    late = replace(tilting.scene, controller=UNLIKE)
    rows = {row.subject: row for row in certify(tilting.trajectory, late).rows if row.constraint == "tilt"}
    asked = {row.subject: row for row in certify(tilting.trajectory, tilting.scene).rows if row.constraint == "tilt"}
    assert any(rows[name].variant != COMMAND and rows[name].use > asked[name].use for name in rows)
    beside = smooth_motion("matrix-liquid-corridor")
    whole = judge(beside.trajectory, replace(beside.scene, controller=UNLIKE))
    corridor = next(row for row in whole.certificate.rows if row.constraint == "corridor")
    path = beside.scene.path.at(np.linspace(0.0, 1.0, 20001))[:, :3]
    places = whole.replay.tray.position[::20]
    off = max(float(np.min(np.linalg.norm(path - place, axis=1))) for place in places)
    assert corridor.worst_value == pytest.approx(off, abs=1e-4), "from the path, not from its start"
