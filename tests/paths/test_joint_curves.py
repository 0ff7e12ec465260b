"""Curves near the straight ways between joint points: distances, ends, stops, what is no corner."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nospill.errors import ScenarioError
from nospill.paths.joint_curves import JoinedPoints, interpolated, rounded, stopping

LEVER = 0.8
SIZES = np.array([1.0, 2.0, 3.0])


def gap(curve: np.ndarray, straight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    apart = curve - straight
    return np.max(np.abs(apart), axis=1), LEVER * np.linalg.norm(apart, axis=1)


def distance_from_ways(joined: JoinedPoints, points: np.ndarray) -> float:
    """Largest distance of a joint of the curve from the nearest place of the straight ways.

    Along a straight way the distance is convex, so that thirds of it lead to its nearest place.
    """
    q, nearest = joined.joints(np.linspace(0.0, 1.0, 401)), []
    for a, b in pairwise(points):
        low, high = np.zeros(len(q)), np.ones(len(q))
        for _ in range(40):
            thirds = np.stack([low + (high - low) / 3, high - (high - low) / 3])
            left, right = np.abs(a + (b - a) * thirds[..., None] - q).max(axis=2)
            low, high = np.where(left > right, thirds[0], low), np.where(left > right, high, thirds[1])
        nearest.append(np.abs(a + (b - a) * low[:, None] - q).max(axis=1))
    return float(np.min(nearest, axis=0).max())


@given(seed=st.integers(0, 10_000), count=st.integers(3, 6), angle=st.sampled_from([0.004, 0.02, 0.1]))
def test_rounded_ways_keep_the_distances_and_the_ends(seed: int, count: int, angle: float) -> None:
    points = np.cumsum(np.random.default_rng(seed).uniform(-1.0, 1.0, (count, 3)), axis=0)
    joined = rounded(points, SIZES, gap, angle, 0.01)
    np.testing.assert_allclose(joined.joints(np.array([0.0, 1.0])), points[[0, -1]], atol=1e-9)
    assert 0.0 < joined.angle <= angle and joined.length <= 0.01
    assert distance_from_ways(joined, points) <= joined.angle * 1.02 + 1e-6
    jumps = [joined.joints(joined.joints.breaks[1:-1] - 1e-12, k) - joined.joints(joined.joints.breaks[1:-1], k)
             for k in (0, 1, 2, 3)]  # fmt: skip
    scale = [np.abs(joined.joints(np.linspace(0, 1, 999), k)).max() for k in (0, 1, 2, 3)]
    assert all(np.abs(jump).max(initial=0.0) < 1e-5 * size for jump, size in zip(jumps, scale, strict=True))


def test_a_smaller_tolerance_is_a_sharper_corner() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 2, 0]])
    bends = [np.abs(rounded(points, SIZES, gap, angle, 1.0).joints(np.linspace(0, 1, 4001), 2)).max()
             for angle in (0.1, 0.01, 0.001)]  # fmt: skip
    assert bends[0] < bends[1] / 4 < bends[2] / 16


def test_points_on_a_straight_way_are_the_straight_way() -> None:
    points = np.outer([0.0, 0.1, 0.5, 1.0], [1.0, -2.0, 0.5])
    joined = rounded(points, SIZES, gap, 0.01, 0.01)
    np.testing.assert_allclose(joined.joints(np.array([0.25])), [points[-1] / 4], atol=1e-15)
    assert joined.angle == joined.length == 0.0
    assert len(stopping(points, SIZES).joints.breaks) == 2


def test_samples_of_a_smooth_motion_make_no_shaking_path() -> None:
    s = np.linspace(0.0, 1.0, 400)[:, None]
    wave = np.hstack([np.sin(3 * s), np.cos(2 * s), s**2])
    joined = rounded(wave, SIZES, gap, 1e-3, 1e-3)
    assert joined.angle < 1e-3
    # the polygon's own corners would ask for a third derivative of its turns over the square of a step
    through = interpolated(wave[::21], SIZES, gap)
    third = [np.abs(own.joints(np.linspace(0, 1, 999), 3)).max() for own in (joined, through)]
    assert third[0] < 3.0 * third[1]


def test_joints_stand_still_at_every_corner_where_they_stop() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 1e-9 + 0.7], [0.2, -0.4, 0.3]])
    joined = stopping(points, SIZES)
    at = joined.joints.breaks
    np.testing.assert_allclose(joined.joints(at), points, atol=1e-12)
    for order in (1, 2):
        np.testing.assert_allclose(joined.joints(at, order), 0.0, atol=1e-9)
        np.testing.assert_allclose(joined.joints(at - 1e-9, order), 0.0, atol=1e-4)
    assert distance_from_ways(joined, points) < 2e-3  # on the ways, but for the steps of the brute force


def test_a_spline_passes_every_point() -> None:
    points = np.random.default_rng(3).uniform(-1, 1, (9, 3))
    joined = interpolated(points, SIZES, gap)
    np.testing.assert_allclose(joined.joints(joined.s), points, atol=1e-10)
    assert joined.angle > 0.01


def test_points_that_turn_too_often_are_refused() -> None:
    zigzag = np.array([[index * 0.01, index % 2, 0.0] for index in range(300)])
    with pytest.raises(ScenarioError, match="300 points turn so often"):
        rounded(zigzag, SIZES, gap, 1e-4, 1e-4)
