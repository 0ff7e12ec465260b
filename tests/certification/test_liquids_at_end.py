"""What is left in the liquids when the arm stands: judged at instants of the record, whatever grid the replay has."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.certification.certificate import judge_motion
from nospill.certification.replay import MINIMUM_RATE
from nospill.laws.constraints.residual_height import EndDisplacement, ResidualHeight


@pytest.mark.parametrize("stretch", [0.4, 0.76])
@pytest.mark.parametrize(
    ("name", "constraint"),
    [
        ("matrix-liquid", ResidualHeight.name),
        ("matrix-liquid-tilt", ResidualHeight.name),
        ("matrix-liquid", EndDisplacement.name),
        ("matrix-liquid-still", EndDisplacement.name),
    ],
)
def test_final_states_are_independent_of_the_grid(smooth_motion, name, constraint, stretch):
    """The motion stops between two instants of either grid, and between two samples, the tray slowing down until then.

    Displacements count at the end: of a liquid that passes its rest shape then they are others at the next sample.
    """
    motion = smooth_motion(name, stretch=stretch)
    trajectory = motion.trajectory
    assert trajectory.t[-2] + 1e-4 < trajectory.end_time < trajectory.t[-1] - 1e-4
    usual, fine = (
        [one for one in judge_motion(trajectory, motion.scene, rate=rate).traces if one.constraint == constraint]
        for rate in (MINIMUM_RATE, 4 * MINIMUM_RATE)
    )
    instant = trajectory.rest_time if constraint == ResidualHeight.name else trajectory.end_time
    assert [trace.subject for trace in usual] == [cargo.name for cargo in motion.scene.cargo]
    for trace, finer in zip(usual, fine, strict=True):
        assert trace.t == pytest.approx(instant, abs=1e-12)
        np.testing.assert_allclose(trace.value, finer.value, rtol=0, atol=1e-8)  # m; integrations agree to 1e-7
