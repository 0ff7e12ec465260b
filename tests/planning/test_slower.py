"""A plan at a lower speed on its own way: time laws, records in another time, what is taken and what is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.certificate import certify, judge_motion
from nospill.core.attitudes import matrices
from nospill.errors import NoSolutionError, ScenarioError
from nospill.motion.at_speed import at_speed
from nospill.motion.time_law import RetimedMotion, TimeLaw, retimed
from nospill.planning.slower import SAME_ATTITUDE, SAME_PLACE, apart, slower
from nospill.plans.plan import Plan
from nospill.scene.limits import LimitRecord

LAW = TimeLaw(1.5, 4.0, np.array([0.4, 1.3, 0.9, 1.1, 1.6, 0.7, 0.3, 0.5]))


@pytest.fixture(scope="module")
def plan(gentle_plan: Callable[..., Plan]) -> Plan:
    return gentle_plan("matrix-liquid", cargo=1)


def test_a_law_runs_through_all_planned_times_forwards_and_its_rates_are_its_derivatives() -> None:
    t = np.linspace(0.0, 4.0, 40001)
    rows = LAW(t)
    assert rows[0][0] == 0.0 and rows[0][-1] == pytest.approx(1.5, abs=1e-12)
    assert np.min(rows[1]) > 0.0
    for order in range(3):
        slope = np.gradient(rows[order], t, edge_order=2)
        np.testing.assert_allclose(rows[order + 1][5:-5], slope[5:-5], atol=2e-3)
    assert LAW.fastest == pytest.approx(np.max(rows[1]), rel=1e-3)


def test_motions_in_another_time_by_the_chain_rule() -> None:
    """sin(3 tau) of every joint, against differences."""

    def planned(t: np.ndarray, order: int = 0, /) -> np.ndarray:
        return np.column_stack([3.0**order * np.sin(3.0 * t + 0.5 * np.pi * order)] * 2)

    motion, t = RetimedMotion(planned, LAW), np.linspace(0.01, 3.99, 40001)
    for order in range(3):
        slope = np.gradient(motion(t, order), t, axis=0, edge_order=2)
        np.testing.assert_allclose(motion(t, order + 1)[5:-5], slope[5:-5], atol=5e-3)


def test_an_even_law_is_what_an_override_does(plan: Plan) -> None:
    record, length = plan.trajectory, plan.trajectory.rest_time
    slow = retimed(record, plan.scene, TimeLaw.even(length, 2.0 * length))
    half = at_speed(record, 0.5)
    for name in ("s", "s_rate", "joint_position", "joint_speed", "joint_acceleration"):
        ours, theirs = getattr(slow, name)[::2], getattr(half, name)[: len(slow.t[::2])]
        np.testing.assert_allclose(ours, theirs, atol=2e-3 if name == "joint_acceleration" else 1e-5)


def test_a_record_in_another_time_keeps_its_way_and_agrees_with_itself(plan: Plan) -> None:
    law = TimeLaw(plan.trajectory.rest_time, 2.5 * plan.trajectory.rest_time, LAW.shape)
    record = retimed(plan.trajectory, plan.scene, law)
    rows = judge_motion(record, plan.scene).certificate.rows
    assert all(row.ok for row in rows if row.of_record), [row for row in rows if not row.ok]
    planned = plan.trajectory.motion(np.linspace(0.0, law.length, 40001))
    for q in record.joint_position[:: len(record.t) // 50]:
        assert np.min(np.max(np.abs(planned - q), axis=1)) < 1e-4
    up = matrices(record.tray_quaternion)[:, 2, 2]
    assert np.min(up) == pytest.approx(np.min(matrices(plan.trajectory.tray_quaternion)[:, 2, 2]), abs=1e-9)


@pytest.mark.parametrize("speed", [1.0, 0.8, 0.5])
def test_slower_is_certified_and_on_the_way_of_the_plan(plan: Plan, speed: float) -> None:
    made = slower(plan, speed)
    assert made.certificate.ok and certify(made.trajectory, made.scene).ok
    assert 0.69 * speed < plan.trajectory.rest_time / made.trajectory.rest_time <= speed * (1.0 + 1e-9)
    gaps = apart(plan, made)
    assert gaps.is_same and gaps.joints < 2e-3
    fastest = [np.max(np.abs(each.trajectory.joint_speed), axis=0) for each in (made, plan)]
    assert np.all(fastest[0] <= 1.01 * fastest[1] + 1e-9)


def test_a_plan_whose_limit_is_not_at_hand_is_not_slowed_down(plan: Plan) -> None:
    scene = plan.scene.with_constraints((), (LimitRecord("sway", "Sway"),))
    with pytest.raises(ScenarioError, match='"sway", whose class is not at hand'):
        slower(replace(plan, scene=scene), 0.5)


def test_distances_of_two_ways_are_told(plan: Plan) -> None:
    """Joint 1 turned by 2 mrad moves the tray about the base, joint 6 about itself."""
    q = plan.trajectory.joint_position
    turned = replace(plan, trajectory=replace(plan.trajectory, joint_position=q + 5e-3 * np.eye(6)[5]))
    gaps = apart(plan, turned)
    assert gaps.angle == pytest.approx(5e-3, rel=0.05) and gaps.distance < 3e-3 and not gaps.is_same
    raised = apart(plan, replace(plan, trajectory=replace(plan.trajectory, joint_position=q + 5e-3 * np.eye(6)[1])))
    assert raised.distance > 2e-3 > SAME_PLACE and raised.angle > SAME_ATTITUDE
    assert apart(plan, plan).distance < 1e-9


def test_a_way_on_which_nothing_holds_is_refused_with_the_limit(plan: Plan, monkeypatch) -> None:
    monkeypatch.setattr("nospill.planning.slower._TRIES", 12)
    strict = replace(plan, scene=plan.scene.changed({"cargo.*.max_slosh_height": 2e-4}))
    with pytest.raises(
        NoSolutionError, match=r"no motion of 50 to 35 % of its speed was found that holds; .* slosh height of c1"
    ):
        slower(strict, 0.5)
