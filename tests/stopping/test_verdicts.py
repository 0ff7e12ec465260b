"""A stop has one verdict, that of plan and stop as one motion from rest: its liquids begin with nobody's push."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.certificate import Judgement
from nospill.certification.verdict import worst_row
from nospill.laws.constraints.base import RowId
from nospill.motion.interpolation import QUINTIC_SPLINE, JointSamples
from nospill.motion.trajectory import Trajectory
from nospill.plans.plan import Plan
from nospill.stopping.controller import SlowedClock, judged_to_rest
from nospill.stopping.solving import splice_at, stopping_scene
from nospill.stopping.splices import states_with_leads
from nospill.stopping.verdicts import Verdict, judged_stop, looked_at, swinging_on

AT, SLOWING = 1.2, 0.2
"""s; in so short a time the acceleration jumps by much from one sample to the next."""
HEIGHT, SLIP = RowId("slosh height", "c1"), RowId("slip", "c1")


@pytest.fixture(scope="module", params=["deliverable", "full"])
def plan(request: pytest.FixtureRequest, gentle_plan: Callable[[str, int], Plan]) -> Plan:
    """With heights as published and to the second order."""
    made = gentle_plan("matrix-liquid-soft-end", 1)
    return replace(made, scene=replace(made.scene, fidelity=request.param))


@pytest.fixture(scope="module")
def halted(plan: Plan) -> Trajectory:
    """A motion that comes to rest in no time, as samples of the plan's rate on a clock of its own."""
    motion = SlowedClock(plan.trajectory.motion, AT, SLOWING)
    t = np.arange(int(SLOWING * plan.trajectory.rate) + 2) / plan.trajectory.rate
    record = Trajectory.of_joints(t, plan.trajectory.joints, *(motion(AT + t, order) for order in range(3)))
    return replace(record, in_motion=True)


@pytest.fixture(scope="module")
def whole(plan: Plan, halted: Trajectory) -> Judgement:
    """The verdict on plan and stop from rest to rest."""
    rate = plan.trajectory.rate
    q = np.concatenate([plan.trajectory.joint_position[: round(AT * rate)], halted.joint_position])
    motion = QUINTIC_SPLINE.motion(JointSamples(np.arange(len(q)) / rate, q))
    return judged_to_rest(motion, (len(q) - 1) / rate, rate, plan.scene)


def _verdict(plan: Plan, halted: Trajectory, *, joined: bool) -> Verdict:
    (state,), (lead,) = states_with_leads(plan, np.array([AT]))
    scene = swinging_on(stopping_scene(plan.scene, state))
    verdict = judged_stop(halted, scene, splice_at(plan, state, lead) if joined else None)
    assert verdict is not None
    return verdict


def _difference(verdict: Verdict, whole: Judgement, row: RowId) -> float:
    """Between the uses of a limit at the instants of both, at most, from 20 ms after the beginning on."""
    (own,) = [trace for trace in verdict.judgement.traces if trace.id == row]
    (other,) = [trace for trace in whole.traces if trace.id == row]
    late = (own.t > 0.02) & (own.t + AT < other.t[-1])
    return float(np.max(np.abs(own.use - np.interp(own.t + AT, other.t, other.use))[late]))


def test_liquids_move_as_in_the_motion_from_rest(plan: Plan, halted: Trajectory, whole: Judgement) -> None:
    together = _verdict(plan, halted, joined=True)
    assert _difference(together, whole, HEIGHT) < 1e-5
    assert _difference(_verdict(plan, halted, joined=False), whole, HEIGHT) < 1e-4  # 6e-3 with a push


def test_it_is_about_the_stop_on_its_own_clock(plan: Plan, halted: Trajectory, whole: Judgement) -> None:
    verdict = _verdict(plan, halted, joined=True)
    judgement, record = verdict.judgement, verdict.record
    np.testing.assert_array_equal(record.t, halted.t)
    assert judgement.end_time == pytest.approx(halted.end_time)
    assert all(trace.t[0] >= -1e-9 for trace in judgement.traces)
    (slip,) = [row for row in judgement.certificate.rows if row.id == SLIP]
    expected = worst_row(next(trace for trace in whole.traces if trace.id == SLIP))
    assert (slip.use, slip.at_s + AT) == pytest.approx((expected.use, expected.at_s), abs=1e-3)


def test_what_breaks_where_a_stop_takes_over_is_told(plan: Plan, halted: Trajectory) -> None:
    verdict = _verdict(plan, halted, joined=True)
    assert not verdict.ok and verdict.at_splice
    assert all(use > 1.0 for use in verdict.at_splice.values())


def test_a_rough_look_finds_what_a_verdict_finds(plan: Plan, halted: Trajectory) -> None:
    """The stop breaks limits: all rows but distances and checks of the record, within what it is said to be off by."""
    (state,), (lead,) = states_with_leads(plan, np.array([AT]))
    splice, scene = splice_at(plan, state, lead), swinging_on(stopping_scene(plan.scene, state))
    rough, full = looked_at(halted, scene, splice), judged_stop(halted, scene, splice)
    assert rough is not None and full is not None and not rough.ok and not full.ok
    uses, found = ({row.id: row.use for row in verdict.judgement.certificate.rows} for verdict in (full, rough))
    assert uses.keys() == found.keys()
    assert not {row: (found[row], use) for row, use in uses.items() if abs(found[row] - use) >= 2e-2}
    assert rough.judgement.replay.rate < 0.6 * full.judgement.replay.rate
