"""The rasteriser against closed forms: areas, perspective, who is nearest, what is cut."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.film.raster import NEAREST, Canvas, Triangles, clipped, covered, facing, fragments, layer, nearest

CANVAS = Canvas(80, 60, 50.0)


def triangles(*corners: list[list[float]], shade: float = 1.0) -> Triangles:
    found = np.array(corners, dtype=float)
    return Triangles(found, np.full(found.shape[:2], shade), np.arange(len(found)))


def test_the_middle_of_the_picture_is_what_the_camera_looks_at() -> None:
    x, y, inverse = CANVAS.project(np.array([0.0, 0.0, -2.0]))
    assert (x, y, inverse) == pytest.approx((39.5, 29.5, 0.5))
    right = CANVAS.project(np.array([0.3, 0.1, -2.0]))
    assert right[0] - x == pytest.approx(50.0 * 0.3 / 2.0)
    assert right[1] - y == pytest.approx(-50.0 * 0.1 / 2.0)


@given(st.lists(st.tuples(st.integers(-80, 400), st.integers(-80, 320)), min_size=4, max_size=4))
@settings(deadline=None)
def test_a_pixel_of_a_shared_edge_belongs_to_one_triangle(points: list[tuple[int, int]]) -> None:
    """Fans of a quadrilateral round its middle cover every pixel inside once, whatever its shape."""
    ring = np.array(points) / 4.0  # often with a pixel's centre on an edge
    middle = ring.mean(axis=0)
    ring = ring[np.argsort(np.arctan2(*(ring - middle).T[::-1]))]
    fans = np.array([[middle, ring[k], ring[(k + 1) % 4]] for k in range(4)])
    corners = np.concatenate([fans, np.ones((4, 3, 1))], axis=2)
    one, two = fans[:, 1] - fans[:, 0], fans[:, 2] - fans[:, 0]
    turn = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    if np.any(turn <= 1.0):
        return  # not convex seen from its middle: fans overlap
    found = fragments(CANVAS, corners)
    assert len(np.unique(found.pixel)) == len(found.pixel)
    assert np.all((found.pixel >= 0) & (found.pixel < 80 * 60))


def test_area_and_depth_are_exact() -> None:
    corners = np.array([[[10.0, 5.0, 0.2], [50.0, 5.0, 0.6], [10.0, 45.0, 1.0]]])
    found = fragments(CANVAS, corners)
    assert len(found.pixel) == pytest.approx(800, abs=25)
    x, y = found.pixel % 80, found.pixel // 80
    assert found.inverse == pytest.approx(0.2 + 0.01 * (x - 10) + 0.02 * (y - 5))


def test_the_nearer_one_is_seen_where_planes_cross() -> None:
    flat = [[-1.0, -1.0, -2.0], [1.0, -1.0, -2.0], [0.0, 1.5, -2.0]]
    leaning = [[-1.0, -1.0, -1.0], [1.0, -1.0, -3.0], [0.0, 1.5, -2.0]]
    surface = nearest(CANVAS, triangles(flat, leaning))
    x = surface.pixel % 80
    assert set(surface.label[x < 38]) == {1}
    assert set(surface.label[(x > 41) & (x < 55)]) == {0}
    before, _, shade = layer(CANVAS, triangles([[-1.0, -1.0, -1.9], [1.0, -1.0, -1.9], [0.0, 1.5, -1.9]]), surface)
    assert len(before) > 0
    assert np.all(shade == 1.0)
    assert np.all(surface.inverse[before] < 1 / 1.9)


def test_what_is_behind_the_camera_is_cut_away() -> None:
    found = clipped(triangles([[0.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.5, 1.0]], [[0.0, 0.0, 1.0]] * 3))
    assert len(found.label) == 1
    assert np.all(found.corners[..., 2] <= -NEAREST + 1e-12)
    two_ahead = clipped(triangles([[0.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.5, -1.0]]))
    assert list(two_ahead.label) == [0, 0]
    assert np.all(two_ahead.corners[..., 2] <= -NEAREST + 1e-12)


def test_outside_and_inside_of_a_triangle() -> None:
    seen = triangles([[-1.0, 0.0, -2.0], [1.0, 0.0, -2.0], [0.0, 1.0, -2.0]])
    assert facing(seen).tolist() == [True]
    assert facing(Triangles(seen.corners[:, ::-1], seen.shade, seen.label)).tolist() == [False]


def test_a_triangle_without_area_covers_nothing() -> None:
    line = triangles([[-1.0, 0.0, -2.0], [1.0, 0.0, -2.0], [0.0, 0.0, -2.0]])
    assert not covered(CANVAS, line).any()
