"""What is left in the liquids when the arm stands: judged where its samples say so, whatever grid the replay has."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.judge.certificate import judge_motion
from nospill.judge.replay import MINIMUM_RATE
from nospill.laws.constraints.residual_height import ResidualHeight


@pytest.mark.parametrize("stretch", [0.4, 0.76])
@pytest.mark.parametrize("name", ["matrix-liquid", "matrix-liquid-tilt"])
def test_residual_heights_are_independent_of_the_grid(smooth_motion, name, stretch):
    """The motion stops between two instants of either grid, the tray slowing down until then."""
    motion = smooth_motion(name, stretch=stretch)
    trajectory = motion.trajectory
    assert trajectory.t[-2] + 1e-4 < trajectory.end_time < trajectory.t[-1] - 1e-4
    usual, fine = (
        [
            trace
            for trace in judge_motion(trajectory, motion.scene, rate=rate).traces
            if trace.constraint == ResidualHeight.name
        ]
        for rate in (MINIMUM_RATE, 4 * MINIMUM_RATE)
    )
    assert [trace.subject for trace in usual] == [cargo.name for cargo in motion.scene.cargo]
    for trace, finer in zip(usual, fine, strict=True):
        assert trace.t == pytest.approx(trajectory.rest_time, abs=1e-12)
        np.testing.assert_allclose(trace.value, finer.value, rtol=1e-6)
