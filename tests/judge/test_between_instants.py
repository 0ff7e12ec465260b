"""Peaks of contacts between the instants of the grid, against a replay on a finer one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from nospill.judge.between_instants import contact_peaks
from nospill.judge.certificate import judge
from nospill.judge.replay import MINIMUM_RATE, replay
from nospill.judge.traces import constraint_traces
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.base import EvaluationPoint, Role
from nospill.motion.interpolation import planned_motion
from nospill.motion.trajectory import Trajectory
from nospill.scene.scene import Scene
from tests.conftest import SmoothMotion

OBJECT = [EvaluationPoint.OBJECT]


@pytest.fixture(scope="module")
def fast(smooth_motion: Callable[..., SmoothMotion]) -> tuple[Trajectory, Scene]:
    """A motion of two cups."""
    motion = smooth_motion("matrix-liquid-tilt", cargo=2, stretch=1.0)
    return motion.trajectory, motion.scene


def test_peaks_are_what_a_finer_grid_sees(fast: tuple[Trajectory, Scene]) -> None:
    trajectory, scene = fast
    motion = planned_motion(trajectory)
    coarse, fine = (replay(trajectory, scene, rate=rate) for rate in (MINIMUM_RATE, 4 * MINIMUM_RATE))
    traces = constraint_traces(trajectory, scene, coarse, points=OBJECT)
    on_fine = {(one.constraint, one.subject): one for one in constraint_traces(trajectory, scene, fine, points=OBJECT)}
    # as if the largest use of every contact were 0.999: what is looked at are its peaks
    scaled = tuple(replace(one, margin=one.limit * (1 - one.use * 0.999 / np.max(one.use))) for one in traces)
    found = contact_peaks(scene, coarse, scaled, motion)
    assert {one.constraint for one in found} == {"lift", "slip", "tip", "twist"}
    for one in found:
        assert len(one.t) == 1 and BY_NAME[one.constraint].role is Role.CONTACT
        own = on_fine[one.constraint, one.subject]
        index = int(np.argmin(np.abs(own.t - one.t[0])))
        assert own.t[index] == pytest.approx(one.t[0], abs=1e-9)
        assert own.use[index] == pytest.approx(one.use[0], abs=1e-6)


def test_nothing_is_looked_at_far_from_the_limits(fast: tuple[Trajectory, Scene]) -> None:
    trajectory, scene = fast
    played = replay(trajectory, scene)
    traces = constraint_traces(trajectory, scene, played, points=OBJECT)
    far = tuple(replace(one, margin=np.full_like(one.limit, 0.1)) for one in traces)
    assert contact_peaks(scene, played, far, planned_motion(trajectory)) == ()


def test_the_certificate_has_the_peak_between_two_instants(fast: tuple[Trajectory, Scene]) -> None:
    trajectory, scene = fast
    fine = replay(trajectory, scene, rate=4 * MINIMUM_RATE)
    slips = [one for one in constraint_traces(trajectory, scene, fine, points=OBJECT) if one.constraint == "slip"]
    worst = max(slips, key=lambda one: float(np.max(one.use)))
    index = int(np.argmax(worst.use))
    assert index % 4  # the finer grid has its peak between two instants of the coarser one
    # as much friction as makes it a peak near the limit
    friction = float(scene.cargo[0].friction * worst.use[index] / 0.99)
    near = replace(scene, cargo=tuple(replace(item, friction=friction) for item in scene.cargo))
    row = max(
        (row for row in judge(trajectory, near).certificate.rows if row.constraint == "slip"), key=lambda r: r.use
    )
    assert row.subject == worst.subject
    assert row.use == pytest.approx(0.99, abs=5e-3)
    assert row.at_s == pytest.approx(float(worst.t[index]), abs=1e-9)
