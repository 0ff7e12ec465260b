"""Splines through noisy positions and the band that they leave."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline

from nospill.execution.smoothing import smooth_joints

PERIOD = 0.002
T = np.arange(0.0, 3.0, PERIOD)


def motion(t: np.ndarray, order: int = 0) -> np.ndarray:
    """From rest to rest, two joints of different haste."""
    columns = []
    for way, swings in ((1.0, 1), (0.3, 3)):
        u, rate = np.clip(t / T[-1], 0.0, 1.0), 1.0 / T[-1]
        inner = 2 * np.pi * swings
        columns.append(
            {
                0: way * (u - np.sin(inner * u) / inner),
                1: way * rate * (1 - np.cos(inner * u)),
                2: way * rate**2 * inner * np.sin(inner * u),
            }[order]
        )
    return np.column_stack(columns)


def noisy(noise: float, seed: int = 0) -> np.ndarray:
    return motion(T) + noise * np.random.default_rng(seed).standard_normal((len(T), 2))


@pytest.mark.parametrize("noise", [1e-7, 1e-5, 1e-3])
def test_the_noise_is_found(noise: float) -> None:
    found = smooth_joints(T, noisy(noise), PERIOD)
    assert found.noise == pytest.approx([noise, noise], rel=0.1)


@pytest.mark.parametrize("order", [0, 1, 2])
def test_the_band_of_95_percent_holds_the_motion_95_times_in_a_hundred(order: int) -> None:
    """Or more often: the penalty takes accelerations to be rougher than these are."""
    inside, at = [], T[100:-100:40]
    knots = np.concatenate([np.zeros(5), np.linspace(0.0, T[-1], 27), np.full(5, T[-1])])
    for seed in range(12):
        generator = np.random.default_rng(seed)
        way = np.cumsum(generator.standard_normal((31, 2)), axis=0)
        way[:3], way[-3:] = way[3], way[-4]  # at rest at both ends
        truth = BSpline(knots, 0.1 * way, 5)
        found = smooth_joints(T, truth(T) + 1e-5 * generator.standard_normal((len(T), 2)), PERIOD)
        inside.append(np.abs(found(at, order) - truth(at, order)) < 1.96 * found.deviation(at, order))
    assert np.mean(inside) >= 0.92
    assert np.mean(inside) < 0.999


def test_drawn_motions_are_as_wide_as_the_band() -> None:
    found = smooth_joints(T, noisy(1e-5), PERIOD)
    generator, at = np.random.default_rng(1), T[200:-200:100]
    drawn = np.array([found.drawn(generator)(at, 2) - found(at, 2) for _ in range(200)])
    assert drawn.std(axis=0) == pytest.approx(found.deviation(at, 2), rel=0.2)


def test_begins_and_ends_at_rest() -> None:
    found = smooth_joints(T, noisy(1e-5), PERIOD)
    for order in (1, 2):
        assert np.max(np.abs(found(T[[0, -1]], order))) < 1e-9


def test_what_is_without_noise_is_followed() -> None:
    found = smooth_joints(T, motion(T), PERIOD)
    assert np.max(np.abs(found(T) - motion(T))) < 1e-8
    assert np.max(np.abs(found(T, 2) - motion(T, 2))[50:-50]) < 1e-3


def test_a_joint_that_stands_has_no_band() -> None:
    found = smooth_joints(T, np.column_stack([motion(T)[:, 0], np.full(len(T), 0.7)]), PERIOD)
    assert found(T)[:, 1] == pytest.approx(0.7, abs=1e-12)
    assert np.max(found.deviation(T[::100], 2)[:, 1]) < 1e-6


def test_samples_may_be_missing() -> None:
    kept = np.delete(np.arange(len(T)), np.arange(700, 715))
    found = smooth_joints(T[kept], noisy(1e-5)[kept], PERIOD)
    inside, beside = found.deviation(np.array([T[707], T[900]]), 2)
    assert np.all(inside > 1.1 * beside)
