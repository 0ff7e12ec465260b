"""Motions at another rate and at other times: on the motion, whole nanoseconds, at rest at both ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.motion.resampling import HIGHEST_RATE, LOWEST_RATE, interpolated, resampled


@pytest.mark.parametrize("rate", [10.0, 60.0, 100.0, 125.0, 300.0, 500.0, 997.0, 1000.0])
def test_resampled_lies_on_the_planned_motion(smooth_motion, rate):
    trajectory = smooth_motion("matrix-rigid", cargo=1).trajectory
    samples, motion = resampled(trajectory, rate), trajectory.motion
    assert samples.t[0] == 0.0
    assert trajectory.t[-1] <= samples.t[-1] + 1e-9 < trajectory.t[-1] + 1.0 / rate + 1e-8
    assert samples.rate == pytest.approx(rate, rel=1e-6)
    nanoseconds = samples.t * 1e9
    np.testing.assert_allclose(nanoseconds, np.round(nanoseconds), atol=1e-6)
    np.testing.assert_array_equal(samples.position, motion(samples.t))
    np.testing.assert_allclose(samples.position[-1], trajectory.joint_position[-1], atol=1e-14)
    assert samples.speed is not None and samples.acceleration is not None
    np.testing.assert_array_equal(samples.speed[1:-1], motion(samples.t, 1)[1:-1])
    for column in (samples.speed, samples.acceleration):
        assert np.all(column[[0, -1]] == 0.0), "a controller refuses a motion that does not end at rest"


def test_resampled_at_the_plans_rate_is_the_plan(smooth_motion):
    trajectory = smooth_motion("matrix-rigid", cargo=1).trajectory
    samples = resampled(trajectory, trajectory.rate)
    np.testing.assert_allclose(samples.t, trajectory.t, atol=1e-9)
    np.testing.assert_allclose(samples.position, trajectory.joint_position, atol=1e-14)
    assert samples.speed is not None
    np.testing.assert_allclose(samples.speed, trajectory.joint_speed, atol=1e-3)


@pytest.mark.parametrize("rate", [0.0, -500.0, np.nan, np.inf, LOWEST_RATE - 1.0, HIGHEST_RATE + 1.0])
def test_rates_out_of_range_are_refused(smooth_motion, rate):
    with pytest.raises(ScenarioError, match=r"rate is .* Hz; allowed are 10 to 1000 Hz"):
        resampled(smooth_motion("matrix-rigid", cargo=1).trajectory, rate)


def test_neighbouring_quaternions_of_opposite_sign_are_the_same_turn(smooth_motion):
    """q and -q are one attitude: halfway between them is not nothing."""
    trajectory = smooth_motion("matrix-rigid", cargo=1).trajectory
    signs = np.where(np.arange(len(trajectory.t)) % 3, 1.0, -1.0)[:, None]
    t = (trajectory.t[1:] + trajectory.t[:-1]) / 2
    found = [interpolated(item, t).tray_quaternion for item in (trajectory, _signed(trajectory, signs))]
    np.testing.assert_allclose(np.abs(np.sum(found[0] * found[1], axis=1)), 1.0, atol=1e-12)


def _signed(trajectory, signs):
    return replace(trajectory, tray_quaternion=signs * trajectory.tray_quaternion)
