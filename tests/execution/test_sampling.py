"""The clock of a recorder."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.execution.log import JointLog
from nospill.execution.sampling import sampling_of

PERIOD = 0.002
JITTER = 3e-5


def swing(t: np.ndarray) -> np.ndarray:
    return np.column_stack([np.sin(3.0 * t), 0.5 * np.cos(2.0 * t)])


def log(t: np.ndarray, position: np.ndarray) -> JointLog:
    return JointLog("run.csv", t, ("a", "b"), position)


def stamps(count: int = 1000) -> tuple[np.ndarray, np.ndarray]:
    """Even times, and as they were stamped."""
    even = PERIOD * np.arange(count)
    return even, even + np.random.default_rng(0).normal(0.0, JITTER, count)


def test_jitter_that_is_the_recorders_alone_leaves_the_samples_even() -> None:
    even, stamped = stamps()
    found = sampling_of(log(stamped, swing(even)))
    assert found.even
    assert found.period == pytest.approx(PERIOD, rel=1e-5)
    assert found.jitter == pytest.approx(JITTER, rel=0.1)
    assert np.ptp(np.diff(found.t)) < 1e-12


def test_samples_that_were_taken_at_their_stamps_keep_them() -> None:
    _, stamped = stamps()
    found = sampling_of(log(stamped, swing(stamped)))
    assert not found.even
    assert found.share == pytest.approx(1.0, abs=0.05)
    assert np.array_equal(found.t, stamped)


def test_missing_samples_are_counted_and_leave_their_time() -> None:
    even, _ = stamps()
    kept = np.delete(np.arange(len(even)), [200, 201, 640])
    found = sampling_of(log(even[kept], swing(even[kept])))
    assert found.missing == 3
    assert np.allclose(found.t, even[kept], atol=1e-9)


def test_a_row_that_repeats_the_one_before_in_motion_is_left_out() -> None:
    even, _ = stamps()
    position = np.round(swing(even), 7)
    position[[300, 500]] = position[[299, 499]]
    found = sampling_of(log(even, position))
    assert found.doubled == 2
    assert not {300, 500} & set(found.kept)


def test_the_resolution_is_the_grid_on_which_positions_lie() -> None:
    even, _ = stamps()
    fine = swing(even) + 2e-7 * np.random.default_rng(1).standard_normal((len(even), 2)) * (even > 0.1)[:, None]
    slow = np.where((even < 1.0)[:, None], fine[:1], fine)
    slow[:100] += 3e-7 * np.random.default_rng(2).standard_normal((100, 2))
    assert sampling_of(log(even, np.round(slow, 7))).resolution == pytest.approx([1e-7, 1e-7])
    assert sampling_of(log(even, slow)).resolution == pytest.approx([0.0, 0.0])


def test_equal_rows_at_rest_are_no_fault() -> None:
    even, _ = stamps()
    position = np.round(swing(np.minimum(even, 1.0)), 7)
    found = sampling_of(log(even, position))
    assert found.doubled == 0
    assert found.missing == 0


def test_a_log_with_a_hole_is_refused() -> None:
    even, _ = stamps()
    kept = np.delete(np.arange(len(even)), np.arange(300, 400))
    with pytest.raises(ScenarioError, match=r"run.csv: no samples from t = 0.598 s to 0.800 s; at most 0.1 s"):
        sampling_of(log(even[kept], swing(even[kept])))


def test_time_that_stands_still_is_refused() -> None:
    with pytest.raises(ScenarioError, match="its time never advances"):
        sampling_of(log(np.zeros(50), swing(PERIOD * np.arange(50))))
