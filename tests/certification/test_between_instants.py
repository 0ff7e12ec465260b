"""Peaks of constraints between the instants of the grid, against a replay on a finer one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.between_instants import peaks_between
from nospill.certification.certificate import judge
from nospill.certification.replay import MINIMUM_RATE, replay
from nospill.certification.traces import constraint_traces
from nospill.certification.verdict import Trace
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.base import EvaluationPoint
from nospill.motion.trajectory import Trajectory
from nospill.scene.scene import Scene
from tests.builders import with_linear_heights
from tests.motions import SmoothMotion

OBJECT = [EvaluationPoint.OBJECT]


@pytest.fixture(scope="module")
def fast(smooth_motion: Callable[..., SmoothMotion]) -> tuple[Trajectory, Scene]:
    """A motion of two cups; their heights are linear, which are looked at between the instants."""
    motion = smooth_motion("matrix-liquid-tilt", cargo=2, stretch=1.0)
    return motion.trajectory, with_linear_heights(motion.scene)


@pytest.mark.parametrize(
    ("point", "constraints"),
    [
        (EvaluationPoint.OBJECT, {"lift", "slip", "tip", "twist", "slosh height", "apparent gravity"}),
        (EvaluationPoint.JOINT, {"joint position", "joint speed"}),
    ],
)
def test_peaks_are_what_a_finer_grid_sees(
    fast: tuple[Trajectory, Scene], point: EvaluationPoint, constraints: set[str]
) -> None:
    trajectory, scene = fast
    motion = trajectory.motion
    coarse, fine = (replay(trajectory, scene, rate=rate) for rate in (MINIMUM_RATE, 4 * MINIMUM_RATE))
    traces = constraint_traces(trajectory, scene, coarse, points=[point])
    on_fine = {(one.constraint, one.subject): one for one in constraint_traces(trajectory, scene, fine, points=[point])}
    # as if the largest use of every constraint were 0.9995: what is looked at are its peaks
    scaled = tuple(replace(one, margin=_size(one) * (1 - 0.9995 + np.max(one.use) - one.use)) for one in traces)
    assert {round(float(np.max(one.use)), 6) for one in scaled} == {0.9995}
    found = peaks_between(trajectory, scene, coarse, scaled, motion)
    assert {one.constraint for one in found} == constraints
    assert len(found) == len(traces)
    for one in found:
        assert len(one.t) == 1 and BY_NAME[one.constraint].evaluated_at is point
        own = on_fine[one.constraint, one.subject]
        index = int(np.argmin(np.abs(own.t - one.t[0])))
        assert index % 4 and own.t[index] == pytest.approx(one.t[0], abs=1e-9)
        assert own.use[index] == pytest.approx(one.use[0], abs=1e-6)


def _size(trace: Trace) -> np.ndarray:
    """What a margin is a part of, as `Trace.use` has it."""
    return np.broadcast_to(trace.margin / (1.0 - trace.use), trace.margin.shape)


def test_nothing_is_looked_at_far_from_the_limits(fast: tuple[Trajectory, Scene]) -> None:
    trajectory, scene = fast
    played = replay(trajectory, scene)
    traces = constraint_traces(trajectory, scene, played, points=[EvaluationPoint.OBJECT, EvaluationPoint.JOINT])
    far = tuple(replace(one, margin=0.1 * _size(one)) for one in traces)
    assert peaks_between(trajectory, scene, played, far, trajectory.motion) == ()


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
