"""Rows over a band of late arms: against every combination of joints, and drawn arms."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np
import pytest

from nospill.certification.certificate import Judgement, judge_motion
from nospill.certification.run import run_of
from nospill.certification.tracked_rows import Followed
from nospill.motion.tracking import late
from nospill.scene.controller import Controller
from nospill.scene.scene import Scene
from nospill.scene.tracking import Tracking
from tests.builders import with_linear_heights
from tests.motions import SmoothMotion

DELAY, LAG = 2e-3, 1e-3


@pytest.fixture(scope="module")
def motion(smooth_motion: Callable) -> SmoothMotion:
    return smooth_motion("mixed-tray", stretch=0.9, tilt=(0.1, 0.05))


@pytest.fixture(scope="module")
def scene(motion: SmoothMotion) -> Scene:
    return motion.scene.changed({"tolerance.tracking": {"delay": DELAY, "lag": LAG}})


@pytest.fixture(scope="module")
def judged(motion: SmoothMotion, scene: Scene) -> Judgement:
    return judge_motion(motion.trajectory, scene)


def test_the_band_adds_to_rows_and_takes_nothing(motion: SmoothMotion, judged: Judgement) -> None:
    alone = with_linear_heights(motion.scene)  # as they are over a band
    planned = {row.id: row for row in judge_motion(motion.trajectory, alone).certificate.rows}
    rows = {row.id: row for row in judged.certificate.rows}
    assert planned.keys() == rows.keys()
    assert all(rows[row].use >= planned[row].use - 1e-9 for row in planned)
    assert any(rows[row].use > planned[row].use + 0.01 for row in planned)
    assert {row.id: row.use for row in judged.planned_rows} == {row: own.use for row, own in planned.items()}


def test_no_combination_of_late_joints_uses_more_than_the_band_says(
    motion: SmoothMotion, scene: Scene, judged: Judgement
) -> None:
    """All that are late by all of it or not at all, and some in between; to what cross terms add beyond the first
    order."""
    followed = Followed.of_run(run_of(motion.trajectory, None), scene, ())
    band, joints = judged.band, followed.joints
    assert band is not None
    between = np.random.default_rng(2).uniform(size=(20, joints))
    worst: dict = {}
    for share in [*np.array(list(product((0.0, 1.0), repeat=joints)))[1:-1], *between]:
        arm = Controller(share * DELAY, share * LAG)
        (played,) = followed.played([late(followed.motion, arm, *followed.span)], after=DELAY + 6 * LAG)
        for trace in followed.traces(played):
            worst[trace.id] = max(float(np.max(trace.use)), worst.get(trace.id, 0.0))
    for row, use in worst.items():
        assert use <= band.use[row] + 0.01
    # and it is no bound that nothing comes near
    added = {row: band.use[row] - planned.use for planned in judged.planned_rows if (row := planned.id) in worst}
    reached = max(added, key=lambda row: added[row])
    assert worst[reached] > band.use[reached] - 0.25 * added[reached]


def test_a_joint_without_a_band_adds_nothing(motion: SmoothMotion, scene: Scene) -> None:
    one = motion.scene.changed({"tolerance.tracking": {"delay": [0, 0, DELAY, 0, 0, 0]}})
    all_of_them = judge_motion(motion.trajectory, scene).band
    alone = judge_motion(motion.trajectory, one).band
    assert alone is not None
    assert all_of_them is not None
    assert max(float(np.max(added)) for added in alone.added.values()) > 0.0
    assert max(alone.use.values()) < max(all_of_them.use.values())


def test_a_band_in_words() -> None:
    assert Tracking(np.array([3e-3, 1e-3]), np.zeros(2)).text == "joints up to 3 ms late"
    assert Tracking(np.zeros(2), np.array([2e-3, 0.0])).text == "joints with a lag of up to 2 ms"
    assert Tracking(np.full(2, 3e-3), np.full(2, 2e-3)).text == "joints up to 3 ms late with a lag of up to 2 ms"
