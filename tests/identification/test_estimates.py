"""Least squares with intervals."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.identification.estimates import Estimate, fitted, profile_ends

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
    assert not Estimate("lag", "a", "s", 0.0, float("inf"), 1.0).identifiable
    assert Estimate("lag", "a", "s", 0.0, 0.4, 1.0).identifiable
    assert Estimate("lag", "a", "s", 0.0, 0.4, 1.0).half_width == pytest.approx(0.784)


def test_intervals_follow_the_profile_where_it_is_not_quadratic() -> None:
    """Of v, where only its square is measured: the interval of the square is symmetric and known."""
    generator = np.random.default_rng(2)
    place = np.linspace(1.0, 2.0, 400)
    seen = 0.3**2 * place + 0.8 * generator.standard_normal(400)

    def residuals(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return values[0] ** 2 * place - seen, np.array(2.0 * values[0] * place)[:, None]

    scale, lower, upper = np.array([0.1]), np.array([0.0]), np.array([3.0])
    found = fitted(residuals, np.array([0.5]), scale, lower, upper, neighbours=0)
    ends = profile_ends(residuals, found, 0, lower, upper)
    square = float(place @ seen / (place @ place))
    half = 1.96 * np.sqrt(np.sum((square * place - seen) ** 2) / 399.0 / (place @ place))
    assert ends == pytest.approx((np.sqrt(max(square - half, 0.0)), np.sqrt(square + half)), abs=0.01)


def test_intervals_of_linear_laws_stay_symmetric() -> None:
    generator = np.random.default_rng(3)
    slopes = np.column_stack([np.ones(200), np.linspace(0.0, 1.0, 200)])
    seen = slopes @ [1.0, 2.0] + 0.1 * generator.standard_normal(200)
    bounds = np.array([-9.0, -9.0]), np.array([9.0, 9.0])
    found = fitted(lambda v: (slopes @ v - seen, slopes), np.zeros(2), np.ones(2), *bounds, neighbours=0)
    assert profile_ends(lambda v: (slopes @ v - seen, slopes), found, 1, *bounds) is None
