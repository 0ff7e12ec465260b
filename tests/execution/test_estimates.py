"""Least squares with intervals."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.execution.estimates import Estimate, fitted

T = np.linspace(0.0, 1.0, 200)


def line(noise: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values and deviations of a line through 2 + 3 t and noise."""
    measured = 2.0 + 3.0 * T + noise
    slopes = np.column_stack([np.ones_like(T), T])
    found = fitted(
        lambda values: (slopes @ values - measured, slopes),
        np.zeros(2),
        np.ones(2),
        np.full(2, -10.0),
        np.full(2, 10.0),
        neighbours=10,
    )
    return found.values, np.sqrt(np.diag(found.covariance))


def test_independent_noise() -> None:
    generator, inside = np.random.default_rng(0), []
    for _ in range(200):
        values, deviation = line(0.1 * generator.standard_normal(len(T)))
        inside.append(np.abs(values - [2.0, 3.0]) < 1.96 * deviation)
    assert np.all((np.mean(inside, axis=0) > 0.9) & (np.mean(inside, axis=0) < 0.995))


def test_noise_that_neighbours_share_makes_wider_intervals() -> None:
    generator = np.random.default_rng(1)
    alone = generator.standard_normal(len(T))
    shared = np.convolve(generator.standard_normal(len(T) + 8), np.ones(9) / 3.0, mode="valid")
    assert np.all(line(shared)[1] > 1.15 * line(alone)[1])


def test_what_no_residual_reads_is_not_told() -> None:
    slopes = np.column_stack([np.ones_like(T), np.zeros_like(T)])
    found = fitted(
        lambda values: (slopes @ values - T, slopes),
        np.zeros(2),
        np.ones(2),
        np.full(2, -9.0),
        np.full(2, 9.0),
        neighbours=3,
    )
    assert not np.isfinite(found.covariance[1, 1])
    assert not Estimate("lag", "a", "s", 0.0, float("inf"), 1.0).told
    assert Estimate("lag", "a", "s", 0.0, 0.4, 1.0).told
    assert Estimate("lag", "a", "s", 0.0, 0.4, 1.0).half_width == pytest.approx(0.784)
