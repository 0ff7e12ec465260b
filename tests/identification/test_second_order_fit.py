"""Lags of second order as long as those of servos that nobody tuned, against an outside solver of linear systems."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lsim

from nospill.identification.second_order import fit_second_order


def asked(t: np.ndarray) -> np.ndarray:
    u = np.clip((t - 0.2) / 0.9, 0.0, 1.0)
    return 0.3 + 1.2 * u**3 * (10.0 - 15.0 * u + 6.0 * u**2)


@pytest.mark.parametrize(("period", "ratio"), [(0.08, 1.0), (0.11, 0.8), (0.012, 0.6)])
def test_a_joint_that_lags_by_150_to_180_ms(period: float, ratio: float) -> None:
    """The fit of first order sees all of the lag as one, 2 D T: its delay alone is no place to begin from."""
    t, delay, lag = np.arange(0.0, 2.5, 1e-3), 0.004, 2.0 * period * ratio
    done = lsim(([1.0], [period**2, lag, 1.0]), asked(t - delay) - 0.3, t)[1] + 0.3
    found = fit_second_order("j", t, done, asked, (0.0, 1.5), delay=delay, lag=lag)
    assert found.frequency.value == pytest.approx(1.0 / period, rel=0.01)
    assert found.damping.value == pytest.approx(ratio, rel=0.01)
    assert found.delay.value == pytest.approx(delay, abs=5e-4)
