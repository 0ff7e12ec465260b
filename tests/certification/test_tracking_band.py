"""Rows over a band of arms: against every combination of late joints, and drawn arms.

Heights are linear here; those of second order have a file of their own, and take most of a replay's time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter

from nospill.certification.certificate import Judgement, judge_motion
from nospill.certification.run import run_of
from nospill.certification.tracked_rows import Followed
from nospill.motion.interpolation import QUINTIC_SPLINE, JointMotion, JointSamples
from nospill.motion.tracking import Swinging, late_by
from nospill.scene.controller import Controller
from nospill.scene.scene import Scene
from nospill.scene.tracking import Tracking
from tests.motions import SmoothMotion

DELAY, LAG = 2e-3, 1e-3


@pytest.fixture(scope="module")
def motion(smooth_motion: Callable) -> SmoothMotion:
    found = smooth_motion("mixed-tray", cargo=2, stretch=0.9, tilt=(0.1, 0.05))
    return replace(found, scene=found.scene.changed({"motion.slosh_height": "linear"}))


@pytest.fixture(scope="module")
def scene(motion: SmoothMotion) -> Scene:
    return motion.scene.changed({"tolerance.tracking": {"delay": DELAY, "lag": LAG}})


@pytest.fixture(scope="module")
def judged(motion: SmoothMotion, scene: Scene) -> Judgement:
    return judge_motion(motion.trajectory, scene)


def test_the_band_adds_to_rows_and_takes_nothing(motion: SmoothMotion, judged: Judgement) -> None:
    planned = {row.id: row for row in judge_motion(motion.trajectory, motion.scene).certificate.rows}
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
    shares = [*np.array(list(product((0.0, 1.0), repeat=joints)))[1:-1], *between]
    late = late_by(followed.motion, *followed.span)
    arms = [late(Controller(share * DELAY, share * LAG)) for share in shares]
    for few in range(0, len(arms), 8):
        for played in followed.played(arms[few : few + 8], after=DELAY + 6 * LAG):
            for trace in followed.traces(played):
                worst[trace.id] = max(float(np.max(trace.use)), worst.get(trace.id, 0.0))
    for row, use in worst.items():
        assert use <= band.use[row] + 0.01
    # and it is no bound that nothing comes near
    added = {row: band.use[row] - planned.use for planned in judged.planned_rows if (row := planned.id) in worst}
    reached = max(added, key=lambda row: added[row])
    assert worst[reached] > band.use[reached] - 0.25 * added[reached]


def test_a_joint_without_a_band_adds_nothing(motion: SmoothMotion, judged: Judgement) -> None:
    one = motion.scene.changed({"tolerance.tracking": {"delay": [0, 0, DELAY, 0, 0, 0]}})
    all_of_them = judged.band
    alone = judge_motion(motion.trajectory, one).band
    assert alone is not None
    assert all_of_them is not None
    assert max(float(np.max(added)) for added in alone.added.values()) > 0.0
    assert max(alone.use.values()) < max(all_of_them.use.values())


def test_a_band_in_words() -> None:
    assert Tracking(np.array([3e-3, 1e-3]), np.zeros(2)).text == "joints up to 3 ms late"
    assert Tracking(np.zeros(2), np.array([2e-3, 0.0])).text == "joints with a lag of up to 2 ms"
    assert Tracking(np.full(2, 3e-3), np.full(2, 2e-3)).text == "joints up to 3 ms late with a lag of up to 2 ms"


def _rung(motion: JointMotion, frequency: np.ndarray, damping: float, start: float, stop: float) -> JointMotion:
    """Elastic joints by the exact step of a library, x'' = w^2 (q - x) + 2 zeta w (q' - x'), from rest.

    The step is exact for drives that are linear between the instants ("foh"), and a filter takes all of them.
    """
    t = np.arange(start, stop, 2.5e-4)
    asked, speed = motion(t), motion(t, 1)
    columns = []
    for joint, rate in enumerate(2.0 * np.pi * frequency):
        drive = rate**2 * (asked[:, joint] - asked[0, joint]) + 2.0 * damping * rate * speed[:, joint]
        step: Any = cont2discrete(([1.0], [1.0, 2.0 * damping * rate, rate**2]), t[1] - t[0], "foh")
        columns.append(asked[0, joint] + lfilter(step[0][0], step[1], drive))
    return QUINTIC_SPLINE.motion(JointSamples(t, np.column_stack(columns)))


@pytest.fixture(scope="module")
def ringing(motion: SmoothMotion) -> tuple[Scene, Judgement]:
    scene = motion.scene.changed({"tolerance.tracking": {"resonance": ["6 Hz", "18 Hz"], "damping": 0.05}})
    return scene, judge_motion(motion.trajectory, scene)


def test_drawn_elastic_joints_use_no_more_than_the_band_says(
    motion: SmoothMotion, ringing: tuple[Scene, Judgement]
) -> None:
    scene, judged = ringing
    followed = Followed.of_run(run_of(motion.trajectory, None), scene, ())
    assert judged.band is not None
    draws = np.random.default_rng(5).uniform(size=(6, followed.joints))
    start, stop = followed.span
    worst: dict = {}
    for natural in [np.full(followed.joints, 6.0), *(6.0 * 3.0**draws)]:
        (played,) = followed.played([_rung(followed.motion, natural, 0.05, start, stop + 1.5)], after=1.0)
        for trace in followed.traces(played):
            worst[trace.id] = max(float(np.max(trace.use)), worst.get(trace.id, 0.0))
    for row, use in worst.items():
        assert use <= judged.band.use[row] + 0.01
    planned = {row.id: row.use for row in judged.planned_rows}
    assert max(worst[row] - planned[row] for row in worst) > 0.02


def test_stiffer_joints_add_less(motion: SmoothMotion, ringing: tuple[Scene, Judgement]) -> None:
    stiff = judge_motion(motion.trajectory, ringing[0].changed({"tolerance.tracking.resonance": "40 Hz"})).band
    assert stiff is not None
    assert ringing[1].band is not None
    assert max(stiff.use.values()) < max(ringing[1].band.use.values())


def test_every_sinusoid_uses_no_more_than_the_band_says(motion: SmoothMotion) -> None:
    scene = motion.scene.changed({"tolerance.tracking": {"position": "0.5 mrad", "bandwidth": "5 Hz"}})
    band = judge_motion(motion.trajectory, scene).band
    followed = Followed.of_run(run_of(motion.trajectory, None), scene, ())
    assert band is not None
    joints, draw = followed.joints, np.random.default_rng(3)
    for _ in range(12):
        swing = Swinging(
            followed.motion, np.full(joints, 5e-4), draw.uniform(0.5, 5.0, joints), draw.uniform(0.0, 6.3, joints)
        )
        (played,) = followed.played([swing])
        for trace in followed.traces(played):
            assert float(np.max(trace.use)) <= band.use[trace.id] + 0.01
