"""Few points: a motion of a few quintics comes back as its own breaks, and the tolerance is kept."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.motion.fewest_points import compared_at, fewest_points, part_of
from nospill.motion.interpolation import QUINTIC_HERMITE, JointSamples


def sampled(knots: JointSamples, count: int) -> JointSamples:
    motion = QUINTIC_HERMITE.motion(knots)
    t = np.linspace(knots.t[0], knots.t[-1], count)
    return JointSamples(t, *(motion(t, order) for order in range(3)))


def some_knots(seed: int, times: list[float]) -> JointSamples:
    rng = np.random.default_rng(seed)
    columns = rng.normal(size=(3, len(times), 2))
    columns[1:, [0, -1]] = 0.0
    return JointSamples(np.array(times), *columns)


def test_the_breaks_of_a_few_quintics_are_found() -> None:
    samples = sampled(some_knots(1, [0.0, 0.1, 0.35, 0.5, 1.0]), 201)
    rows = fewest_points(samples, 1e-6)
    np.testing.assert_allclose(samples.t[rows], [0.0, 0.1, 0.35, 0.5, 1.0], atol=1e-12)


def test_one_quintic_is_two_points() -> None:
    assert fewest_points(sampled(some_knots(2, [0.0, 1.0]), 301), 1e-6).tolist() == [0, 300]


def test_nothing_is_left_out_where_nothing_may_differ() -> None:
    t = np.arange(50) / 100.0
    rng = np.random.default_rng(3)
    noise = JointSamples(t, *rng.normal(size=(3, 50, 2)))
    assert fewest_points(noise, 1e-9).tolist() == list(range(50))


@settings(deadline=None, max_examples=20)
@given(frequency=st.floats(1.0, 40.0), tolerance=st.floats(1e-3, 1.0), count=st.integers(30, 300))
def test_accelerations_stay_within_the_tolerance(frequency: float, tolerance: float, count: int) -> None:
    t = np.linspace(0.0, 1.0, count)[:, None]
    phase = frequency * t + np.array([0.0, 1.0])
    whole = JointSamples(t[:, 0], np.sin(phase), frequency * np.cos(phase), -(frequency**2) * np.sin(phase))
    few = part_of(whole, fewest_points(whole, tolerance))
    fine = np.linspace(0.0, 1.0, 2 * (count - 1) + 1)
    apart = QUINTIC_HERMITE.motion(few)(fine, 2) - QUINTIC_HERMITE.motion(whole)(fine, 2)
    assert np.max(np.abs(apart)) <= tolerance * (1 + 1e-9)


def test_a_finer_tolerance_takes_no_fewer_points() -> None:
    samples = sampled(some_knots(4, [0.0, 0.2, 0.3, 0.6, 0.8, 1.0]), 401)
    counts = [len(fewest_points(samples, tolerance)) for tolerance in (10.0, 1.0, 0.1, 0.01)]
    assert counts == sorted(counts)


@pytest.mark.parametrize("rows", [[0, 3], [0, 1, 2, 3]])
def test_part_of_keeps_every_column(rows: list[int]) -> None:
    samples = some_knots(5, [0.0, 0.1, 0.2, 0.4])
    part = part_of(samples, np.array(rows))
    assert part.speed is not None and samples.speed is not None
    np.testing.assert_array_equal(part.speed, samples.speed[rows])
    assert part_of(JointSamples(samples.t, samples.position), np.array(rows)).speed is None


def test_a_tolerance_of_some_instants_puts_points_there_alone() -> None:
    t = np.linspace(0.0, 1.0, 401)[:, None]
    whole = JointSamples(t[:, 0], np.sin(30.0 * t), 30.0 * np.cos(30.0 * t), -900.0 * np.sin(30.0 * t))
    at = compared_at(whole)
    everywhere = fewest_points(whole, 1.0)
    some = fewest_points(whole, np.where((at > 0.4) & (at < 0.6), 1e-3, 1.0))
    inside = [np.sum((whole.t[rows] > 0.4) & (whole.t[rows] < 0.6)) for rows in (everywhere, some)]
    outside = [len(rows) - count for rows, count in zip((everywhere, some), inside, strict=True)]
    assert inside[1] > 2 * inside[0]
    assert outside[1] <= outside[0] + 2


def test_no_segment_is_longer_than_it_may_be() -> None:
    samples = sampled(some_knots(2, [0.0, 1.0]), 301)
    assert np.max(np.diff(samples.t[fewest_points(samples, 1e-6, longest=0.11)])) <= 0.11
    assert len(fewest_points(samples, 1e-6, longest=1e-4)) == 301
