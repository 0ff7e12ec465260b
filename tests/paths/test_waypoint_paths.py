"""Paths through recorded points: as smooth as the tolerance allows, and roughness is refused with a way out."""

from __future__ import annotations

import re
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.errors import ScenarioError
from nospill.paths.path import Path, preset_path
from nospill.paths.smoothing import SmoothCurve, smooth_curve
from nospill.paths.waypoint_paths import MAX_WAYPOINTS, SMOOTHING, path_through_waypoints

GRID = np.linspace(0.0, 1.0, 2001)
ARC = preset_path("arc").at(np.linspace(0.0, 1.0, 200))[:, :3]


def scattered(size: float, count: int = 200, seed: int = 0) -> np.ndarray:
    exact = preset_path("arc").at(np.linspace(0.0, 1.0, count))[:, :3]
    return exact + np.random.default_rng(seed).normal(scale=size, size=exact.shape)


def largest(path: Path, order: int) -> float:
    return float(np.abs(path.derivative(GRID, order)[:, :3]).max())


def distance(path: Path, points: np.ndarray) -> float:
    """Largest distance of a point from the path, by brute force and one refinement."""
    s = np.linspace(0.0, 1.0, 20_001)
    places = path.at(s)[:, :3]
    return max(float(np.linalg.norm(places - point, axis=1).min()) for point in points)


def test_rounded_points_give_the_curve_of_the_exact_ones() -> None:
    exact, rounded = path_through_waypoints(ARC), path_through_waypoints(np.round(ARC, 5))
    assert np.abs(exact.at(GRID) - rounded.at(GRID)).max() < 2 * SMOOTHING
    assert largest(rounded, 3) < 1.02 * largest(exact, 3)
    # through every rounded point the third derivative is some eighty times that
    assert largest(path_through_waypoints(np.round(ARC, 5), smoothing=0.0), 3) > 20 * largest(exact, 3)


@pytest.mark.slow
@pytest.mark.parametrize("count", [200, 2000, MAX_WAYPOINTS])
def test_noise_of_a_millimetre_is_smoothed_within_the_tolerance(count: int) -> None:
    points = scattered(1e-3, count)
    path = path_through_waypoints(points, smoothing=6e-3)
    assert distance(path, points[:: max(1, count // 200)]) <= 6e-3 + 1e-5
    assert largest(path, 3) < 2 * largest(path_through_waypoints(ARC), 3)
    np.testing.assert_allclose(path.at(np.array([0.0, 1.0]))[:, :3], points[[0, -1]], atol=1e-12)
    assert f"joins the {count} waypoints, at most 6 mm off them" in path.notes[-1]


def test_the_tolerance_is_used_up_and_never_exceeded() -> None:
    for tolerance in (1e-4, 1e-3, 1e-2):
        found = smooth_curve(ARC, tolerance)
        assert found is not None
        own = np.linalg.norm(found.pieces(found.s) - ARC, axis=1)
        assert own.max() == pytest.approx(found.deviation, rel=1e-9)
        assert 0.9 * tolerance < found.deviation <= tolerance
        assert int(np.argmax(own)) == found.at


def test_a_wider_tolerance_is_never_rougher() -> None:
    points = scattered(2e-4)
    rough = [largest(path_through_waypoints(points, smoothing=tolerance), 3) for tolerance in (1e-3, 2e-3, 4e-3, 8e-3)]
    assert all(later <= 1.05 * earlier for earlier, later in pairwise(rough))


@cache
def plain_curve() -> SmoothCurve | None:
    return smooth_curve(scattered(1e-3)[::4], 5e-3)


@pytest.mark.slow
@settings(max_examples=8, deadline=None)
@given(scale=st.floats(0.05, 20.0), turn=st.floats(-3.0, 3.0), shift=st.floats(-2.0, 2.0))
def test_size_and_place_do_not_matter(scale: float, turn: float, shift: float) -> None:
    points = scattered(1e-3)[::4]
    cosine, sine = np.cos(turn), np.sin(turn)
    rotation = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    plain, moved = plain_curve(), smooth_curve(scale * points @ rotation.T + shift, scale * 5e-3)
    assert plain is not None
    assert moved is not None
    expected = scale * plain.pieces(GRID) @ rotation.T + shift
    np.testing.assert_allclose(moved.pieces(GRID), expected, atol=1e-5 * scale)


def test_noise_without_a_tolerance_is_refused_with_one_that_suffices() -> None:
    points = scattered(1e-3)
    with pytest.raises(ScenarioError, match=r"scatter by up to .* mm about a smooth curve.*at s = 0\.") as caught:
        path_through_waypoints(points)
    offered = float(str(caught.value).split('smoothing = "')[1].split(" mm")[0])
    assert largest(path_through_waypoints(points, smoothing=1e-3 * offered), 3) < 1e4
    # whoever insists gets the curve through every point
    assert distance(path_through_waypoints(points, smoothing=0.0), points[::20]) < 1e-4


def test_a_tolerance_below_the_scatter_names_the_worst_point() -> None:
    points = scattered(1e-4)
    points[77] += [0.0, 0.0, 0.02]
    with pytest.raises(ScenarioError, match=r"the closest is .* mm off at waypoint 7[789] \(s = 0\.\d\d\)"):
        path_through_waypoints(points, smoothing=2e-3)


def test_many_points_that_are_far_from_smooth_are_meant() -> None:
    walk = np.cumsum(np.random.default_rng(0).uniform(0.05, 0.2, (30, 3)), axis=0)
    assert distance(path_through_waypoints(walk), walk) < 1e-3


def test_few_sharp_points_are_meant() -> None:
    zigzag = np.array([[0.1 * i, 0.1 * (i % 2), 0.5] for i in range(12)])
    path = path_through_waypoints(zigzag)
    assert len(path.notes) == 1 and "leaves the straight lines between them by up to 161 mm" in path.notes[0]
    assert distance(path, zigzag) < 1e-4
    with pytest.raises(ScenarioError, match="12 waypoints are too few to be smoothed"):
        path_through_waypoints(zigzag, smoothing=1e-3)


def test_repeated_points_are_left_out_with_a_note() -> None:
    points = np.array([[0, 0, 0], [0, 0, 0], [0.5, 0.1, 0], [1, 0, 0], [1, 0, 0], [1, 0, 0]], dtype=float)
    path = path_through_waypoints(points)
    np.testing.assert_allclose(path.at(GRID), path_through_waypoints(points[[0, 2, 3]]).at(GRID), atol=1e-15)
    assert path.notes[0] == "3 waypoints repeat the one before, the first of them waypoint 2, and are left out"
    with pytest.raises(ScenarioError, match=r"all 3 are the same point \(0, 0, 1\)"):
        path_through_waypoints([[0, 0, 1]] * 3)


def test_yaw_at_the_points_is_followed() -> None:
    points = ARC[::10]
    angles = np.linspace(0.0, 2.0, len(points)) ** 2
    path = path_through_waypoints(points, yaw_at_points=angles)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    np.testing.assert_allclose(path.at(along / along[-1])[:, 3], angles, atol=1e-3)
    with pytest.raises(ScenarioError, match="yaw_at_points: 3 angles for 20 points"):
        path_through_waypoints(points, yaw_at_points=angles[:3])
    with pytest.raises(ScenarioError, match=r"turns by 5\.73 deg at one point"):
        path_through_waypoints([[0, 0, 0], [0, 0, 0], [1, 0, 0]], yaw_at_points=[0.0, 0.1, 0.2])


CORNERS = np.array([[0.65, -0.3, 0.5], [0.65, 0.1, 0.5], [0.45, 0.1, 0.5], [0.45, 0.1, 0.9]])


def test_blended_lines_keep_to_their_lines_and_are_smooth_at_the_seams() -> None:
    blend, rows = 0.05, np.column_stack([CORNERS, [0.0, 0.3, 0.3, 1.0]])
    path = path_through_waypoints(CORNERS, yaw_at_points=rows[:, 3], blend=blend)
    s = np.linspace(0.0, 1.0, 20001)
    poses, rates = path.at(s), [path.derivative(s, order) for order in (1, 2, 3)]
    assert poses[[0, -1]] == pytest.approx(rows[[0, -1]], abs=1e-12)
    away = np.full(len(s), np.inf)
    for start, end in pairwise(CORNERS):
        line = end - start
        share = np.clip((poses[:, :3] - start) @ line / (line @ line), 0.0, 1.0)
        away = np.minimum(away, np.linalg.norm(poses[:, :3] - start - share[:, None] * line, axis=1))
    assert np.max(away) == pytest.approx(5.0 / 32.0 * blend, rel=1e-3)  # on one line of the corner, its half from both
    near = np.min(np.linalg.norm(poses[:, None, :3] - CORNERS[1:-1], axis=2), axis=1)
    assert np.all(away[near > blend + 1e-6] < 1e-12)
    assert np.min(near) == pytest.approx(5.0 / 32.0 * np.sqrt(2.0) * blend, rel=1e-3)
    for order in range(2):
        slope = np.gradient(rates[order], s, axis=0)
        np.testing.assert_allclose(slope[2:-2], rates[order + 1][2:-2], atol=2e-3 * np.max(np.abs(rates[order + 1])))
    step = np.max(np.abs(np.diff(rates[2], axis=0)))
    assert step < 0.02 * np.max(np.abs(rates[2]))  # the third derivative is continuous


@pytest.mark.parametrize(
    ("points", "blend", "says"),
    [
        (CORNERS, 0.11, "blend 110 mm: the line from waypoint 2 to 3 is 200 mm long, which leaves 100 mm at most"),
        (CORNERS[[0, 1, 0]], 0.02, "turns back by 180 deg at waypoint 2"),
    ],
)
def test_corners_that_cannot_be_rounded_so(points: np.ndarray, blend: float, says: str) -> None:
    with pytest.raises(ScenarioError, match=says):
        path_through_waypoints(points, blend=blend)


def test_blend_and_smoothing_are_two_ways() -> None:
    with pytest.raises(ScenarioError, match="blend and smoothing: both are given"):
        path_through_waypoints(CORNERS, blend=0.01, smoothing=1e-4)


def test_a_point_beside_its_neighbour_is_that_neighbour() -> None:
    """A button pressed twice: without the second point the same curve, and a note."""
    points = np.array([[0.60, -0.3, 0.5], [0.65, -0.1, 0.5], [0.65, 0.1, 0.5], [0.60, 0.3, 0.5]])
    twice = np.insert(points, 2, points[1] + [1e-8, 0.0, 0.0], axis=0)
    s = np.linspace(0.0, 1.0, 301)
    found, plain = path_through_waypoints(twice), path_through_waypoints(points)
    np.testing.assert_allclose(found.at(s), plain.at(s), atol=1e-9)
    assert "waypoint 3 is within 0.01 mm of its neighbour and is left out" in found.notes
    ended = np.vstack([points, points[-1] + [0.0, 1e-8, 0.0]])
    np.testing.assert_allclose(path_through_waypoints(ended).at(1.0)[0, :3], ended[-1], atol=1e-12)


def test_the_distance_from_the_lines_is_said() -> None:
    hairpin = np.array([[0.65, -0.3], [0.65, -0.1], [0.65, 0.1], [0.652, 0.1], [0.652, -0.1], [0.652, -0.3]])
    path = path_through_waypoints(np.column_stack([hairpin, np.full(6, 0.5)]))
    (note,) = path.notes
    swing = path.at(np.linspace(0.0, 1.0, 4001))[:, 0]
    said = float(re.search(r"by up to (\d+) mm", note)[1]) / 1e3  # type: ignore[index]
    assert said > 0.15 and said == pytest.approx(max(0.65 - swing.min(), swing.max() - 0.652), abs=2e-3)
    assert "blend keeps to the lines" in note
    straight = np.column_stack([np.linspace(0.0, 1.0, 7), np.zeros((7, 2))])
    assert path_through_waypoints(straight).notes == ()
