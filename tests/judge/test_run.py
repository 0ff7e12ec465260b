"""Records judged through the arm's controller."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from nospill.judge.certificate import certify, judge
from nospill.judge.run import COMMAND
from nospill.judge.verdict import Certificate
from nospill.plans.plan import Plan
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
