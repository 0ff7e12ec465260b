"""Meshes against closed forms, with trimesh as the outside judge of what is inside and outside."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.drawing.geometry import (
    Mesh,
    board,
    contact_collar,
    container_body,
    drawn_section,
    merge_meshes,
    prism,
    shrunk,
    tube,
    wall_thickness,
)
from nospill.scene.containers import Box, Cylinder
from tests.builders import VESSELS

SIZE = st.floats(0.01, 0.5)
PLACE = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array)


def solid(mesh: Mesh) -> trimesh.Trimesh:
    """The mesh with vertices that lie on each other made one, as a closed body needs."""
    found = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    found.merge_vertices(digits_vertex=9)
    return found


def polygon_area(outline: np.ndarray) -> float:
    x, y = outline.T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2


@settings(max_examples=25, deadline=None)
@given(SIZE, SIZE, SIZE)
def test_prism_is_closed_and_holds_base_times_height(length: float, width: float, height: float) -> None:
    for container in (Box(length, width, height), Cylinder(length, height)):
        body = solid(container_body(container, hollow=False))
        assert body.is_watertight
        assert body.volume == pytest.approx(polygon_area(container.outline) * height, rel=1e-6)  # positive: faces out
        assert body.bounds[0][2] == 0.0
        assert body.bounds[1][2] == pytest.approx(height)


@settings(max_examples=25, deadline=None)
@given(SIZE, SIZE)
def test_cup_stands_on_the_tray_with_its_wall_inside_the_outline(radius: float, height: float) -> None:
    cup = Cylinder(radius, height)
    body, wall = solid(container_body(cup, hollow=True)), wall_thickness(cup)
    assert body.is_watertight
    area = polygon_area(cup.outline)
    inner = area * ((radius - wall) / radius) ** 2
    if height > 2 * wall:
        assert body.volume == pytest.approx(area * height - inner * (height - wall), rel=1e-6)
    assert body.vertices[:, 2].min() == 0.0  # the tray's plane
    assert np.hypot(*body.vertices[:, :2].T).max() <= radius * (1 + 1e-9)


def test_box_shell_has_the_same_wall_on_every_side() -> None:
    outline = Box(0.2, 0.1, 0.05).outline
    assert np.ptp(shrunk(outline, 0.004), axis=0) == pytest.approx([0.192, 0.092])
    body = solid(container_body(Box(0.2, 0.1, 0.05), hollow=True))
    assert body.is_watertight
    assert body.volume == pytest.approx(0.2 * 0.1 * 0.05 - 0.196 * 0.096 * 0.048)


def test_a_drawn_section_is_near_all_points_and_has_few() -> None:
    angle = np.linspace(0.0, np.pi / 2, 500)
    bowl = np.column_stack([np.sin(angle), 0.05 * (1.0 - np.cos(angle))])
    kept = drawn_section(bowl, 0.05)
    assert len(kept) < 40
    assert kept[[0, -1]] == pytest.approx(bowl[[0, -1]])
    radius = np.interp(bowl[:, 1], kept[:, 1], kept[:, 0])
    across = np.interp(bowl[:, 0], kept[:, 0], kept[:, 1])
    off = np.minimum(0.05 * np.abs(radius - bowl[:, 0]), np.abs(across - bowl[:, 1]))
    assert off.max() < 1.5e-3 * 0.05
    straight = np.column_stack([np.ones(9), np.linspace(0.0, 0.1, 9)])
    assert drawn_section(straight, 0.03) == pytest.approx(straight[[0, -1]])


def test_a_glass_is_round_and_light() -> None:
    body = container_body(VESSELS["wine-glass"], hollow=True)
    assert len(body.faces) < 15_000
    assert solid(body).is_watertight


@settings(max_examples=25, deadline=None)
@given(PLACE, PLACE, SIZE, SIZE)
def test_tube_is_a_frustum_between_its_points(start: np.ndarray, end: np.ndarray, first: float, last: float) -> None:
    length = float(np.linalg.norm(end - start))
    if length < 0.01:
        return
    body = solid(tube(start, end, (first, last), sides=24))
    assert body.is_watertight
    polygon = 12 * np.sin(2 * np.pi / 24)  # area of a regular polygon of 24 corners on the unit circle
    assert body.volume == pytest.approx(polygon * length * (first**2 + first * last + last**2) / 3, rel=1e-5)
    along = (body.vertices - start) @ (end - start) / length
    assert along.min() == pytest.approx(0.0, abs=1e-8)
    assert along.max() == pytest.approx(length, abs=1e-8)


def test_tube_needs_a_direction() -> None:
    with pytest.raises(ValueError, match="no direction"):
        tube(np.ones(3), np.ones(3), (0.1, 0.1))


def test_board_has_its_upper_surface_at_zero() -> None:
    found = board(np.array([0.335, 0.25]), 0.006)
    assert found.vertices.max(axis=0) == pytest.approx([0.1675, 0.125, 0.0])
    assert found.vertices.min(axis=0) == pytest.approx([-0.1675, -0.125, -0.006])


def test_collar_goes_round_the_foot() -> None:
    found = contact_collar(Cylinder(0.035, 0.1))
    assert found.vertices[:, 2].min() == 0.0
    assert np.hypot(*found.vertices[:, :2].T).max() == pytest.approx(0.038, rel=1e-3)


def test_joined_meshes_keep_their_faces() -> None:
    first, second = prism(Box(1, 1, 1).outline, 0, 1), prism(Box(2, 2, 1).outline, 3, 4)
    both = merge_meshes([first, second])
    assert np.array_equal(both.vertices[both.faces[len(first.faces) :]], second.vertices[second.faces])
