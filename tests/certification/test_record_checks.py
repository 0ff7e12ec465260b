"""Checks of the record itself: columns against the joints as they are played."""

from __future__ import annotations

from math import factorial

import numpy as np
import pytest

from nospill.certification.record_checks import columns_apart
from nospill.motion.trajectory import Trajectory


class TestCoarseRecord:
    """What a motion does between two samples is no fault of its record."""

    @staticmethod
    def step(rate: float) -> Trajectory:
        """All joints from rest with an acceleration that comes and goes in 2 ms, and its exact columns."""
        jerk_at, size, length, end = np.array([0.0, 0.002, 0.198, 0.202, 0.398, 0.4]), 10.0, 0.4, 0.6
        jerk = size / 0.002 * np.array([1.0, -1.0, -1.0, 1.0, 1.0, -1.0])
        t = np.arange(round(end * rate) + 1) / rate
        since = np.maximum(t[:, None] - jerk_at, 0.0)
        q, speed, acceleration = (since**order @ jerk / factorial(order) for order in (3, 2, 1))
        assert np.abs(acceleration[t > length]).max() < 1e-9 and np.abs(speed[t > length]).max() < 1e-9
        names = tuple(f"joint_{index + 1}" for index in range(6))
        return Trajectory.of_joints(t, names, *(np.outer(of, np.ones(6)) for of in (q, speed, acceleration)))

    @pytest.mark.parametrize("rate", [50.0, 100.0, 125.0, 250.0, 500.0, 1000.0])
    def test_an_acceleration_that_jumps_between_two_samples(self, rate):
        record = self.step(rate)
        per_sample = int(np.ceil(2000.0 / rate))
        t = np.linspace(0.0, record.t[-1], per_sample * (len(record.t) - 1) + 1)
        apart = columns_apart(record.joint_acceleration, record.motion(t, 2), per_sample)
        assert np.max(apart) < 2.0
        straight = np.abs(record.motion(record.t, 2) - record.joint_acceleration).max()
        assert rate > 125.0 or straight > 3.0, "compared instant by instant they are far apart"

    def test_what_is_not_of_the_motion_is_still_found(self):
        record = self.step(500.0)
        t = np.linspace(0.0, record.t[-1], 4 * (len(record.t) - 1) + 1)
        played = record.motion(t, 2)
        for row in (20, 40, 150, len(record.t) - 1):  # between the steps
            spoiled = record.joint_acceleration.copy()
            spoiled[row, 3] += 4.0
            assert columns_apart(spoiled, played, 4)[row] > 3.0
            moved = played.copy()
            moved[4 * row, 3] += 4.0
            assert columns_apart(record.joint_acceleration, moved, 4)[row] > 3.0
