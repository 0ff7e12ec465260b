"""Which limits hold a motion back: shares of time against closed forms, and the words for them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.certificate import Judgement, judge
from nospill.certification.limiting import (
    AT_LIMIT,
    NEAR,
    limiting_names,
    limiting_rows,
    limiting_text,
    savings_text,
    share_without_limit,
)
from nospill.certification.verdict import Trace
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.constraints.base import RowId
from tests.motions import SmoothMotion


@pytest.fixture(scope="module")
def motion(smooth_motion) -> SmoothMotion:
    return smooth_motion("matrix-rigid", cargo=1, stretch=1.3, tilt=(0.05, -0.03))


@pytest.fixture(scope="module")
def judgement(motion: SmoothMotion) -> Judgement:
    return judge(motion.trajectory, motion.scene)


def trace(constraint: str, subject: str, t: np.ndarray, use: np.ndarray) -> Trace:
    return Trace(constraint, subject, "1", t, use, np.ones_like(use), 1.0 - use)


def made_of(judgement: Judgement, *traces: Trace) -> Judgement:
    return replace(judgement, traces=traces, corner_use={})


def test_share_of_a_ramp_and_of_a_sine(motion: SmoothMotion, judgement: Judgement) -> None:
    t, end = judgement.replay.t, judgement.end_time
    ramp, wave = t / end, np.sin(np.pi * t / end)
    made = made_of(
        judgement, trace("tip", "c1", t, ramp), trace("slip", "c1", t, wave), trace("lift", "c1", t, 0.89 * wave)
    )
    rows = limiting_rows(made, motion.scene)
    assert [item.row for item in rows] == [RowId("slip", "c1"), RowId("tip", "c1")]
    assert rows[0].share == pytest.approx(1 - 2 * np.arcsin(AT_LIMIT) / np.pi, abs=2e-3)
    assert rows[1].share == pytest.approx(1 - AT_LIMIT, abs=2e-3)
    assert share_without_limit(rows) == pytest.approx(1 - rows[0].share - rows[1].share, abs=2e-3)
    assert all(item.t[0] >= 0.0 and item.t[-1] <= end for item in rows)


def test_coarse_traces_are_read_between_their_instants_and_single_ones_left_out(
    motion: SmoothMotion, judgement: Judgement
) -> None:
    end = judgement.end_time
    coarse = trace("tilt jerk", "theta_x", np.array([0.0, end / 2, end]), np.array([1.0, 0.0, 1.0]))
    single = trace("residual height", "c1", np.array([end]), np.array([1.0]))
    (only,) = limiting_rows(made_of(judgement, coarse, single), motion.scene)
    assert only.row.constraint == "tilt jerk"
    assert only.share == pytest.approx(1 - AT_LIMIT, abs=2e-3)


def test_tolerances_count(motion: SmoothMotion, judgement: Judgement) -> None:
    t = judgement.replay.t
    stated = trace("slip", "c1", t, np.full(len(t), 0.8))
    made = replace(made_of(judgement, stated), corner_use={RowId("slip", "c1"): np.full(len(t), 0.99)})
    assert limiting_rows(made_of(judgement, stated), motion.scene) == ()
    assert limiting_rows(made, motion.scene)[0].share == 1.0


def test_distances_hold_back_only_what_may_move_otherwise(motion: SmoothMotion, judgement: Judgement) -> None:
    """A tray on its path under six joints passes an obstacle at the same distance however slow it is."""
    t = judgement.replay.t
    made = made_of(judgement, trace("clearance", "tray to column", t, np.full(len(t), 0.99)))
    tilting, level = (
        replace(motion.scene, motion=replace(motion.scene.motion, tilt_free=free)) for free in (True, False)
    )
    assert level.leaves_time_alone and limiting_rows(made, level) == ()
    assert [item.row.subject for item in limiting_rows(made, tilting)] == ["tray to column"]


def test_sentence_names_the_longest_three() -> None:
    joints = ("shoulder_pan_joint", "wrist_1_joint")
    shares = {
        "slosh height | c1": 0.216,
        "joint speed | shoulder_pan_joint": 0.279,
        "slip | c1": 0.185,
        "tilt | theta_x": 0.06,
    }
    sentence = (
        "speed of shoulder pan is at its limit for 28 % of the time, liquid of c1 for 22 %, friction of c1 for 18 %"
    )
    assert limiting_text(shares, joints) == sentence
    assert limiting_text({"slip | c1": 0.001}, joints) == limiting_text({}, joints) == ""


def test_sentence_on_savings_names_the_largest_first_and_no_trifles() -> None:
    joints = ("shoulder_pan_joint", "wrist_1_joint")
    found = {"slosh height | all": 0.0208, "joint speed | shoulder_pan_joint": 0.0521, "tilt jerk | all": 1e-4}
    sentence = "a limit wider by 10 % would save about 0.052 s (speed of shoulder pan), 0.021 s (liquid of all objects)"
    assert savings_text(found, joints) == sentence
    assert savings_text({"slip | all": 1e-5}, joints) == savings_text({}, joints) == ""


def test_every_constraint_has_words() -> None:
    names = limiting_names([RowId(item.name, "c1") for item in CONSTRAINTS], ("joint_1",))
    assert len(set(names)) == len(names)
    assert not any("{" in name for name in names)
    assert limiting_names([RowId("splash", "c1")], ()) == ["splash of c1"]
    assert NEAR < AT_LIMIT < 1.0
