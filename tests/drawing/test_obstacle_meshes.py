"""Obstacles as they are drawn: closed, facing outwards, in place."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.core.shapes import (
    Shape,
    box_shape,
    capsule_shape,
    cylinder_shape,
    halfspace_shape,
    hull_shape,
    polyhedron,
    sphere_shape,
)
from nospill.drawing.geometry import Mesh
from nospill.drawing.obstacles import obstacle_mesh
from nospill.scene.obstacles import Obstacle


def placed(shape: Shape, at: tuple[float, ...], rpy: tuple[float, ...] = (0.0, 0.0, 0.0)) -> Obstacle:
    return Obstacle("thing", shape, np.array(at), np.array(rpy), 0.01)


def volume(mesh: Mesh) -> float:
    """By the divergence theorem: positive where the faces look outwards."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    return float(np.sum(a * np.cross(b, c)) / 6.0)


@pytest.mark.parametrize(
    ("shape", "wanted"),
    [
        (box_shape((0.1, 0.2, 0.3)), 0.006),
        (cylinder_shape(0.1, 0.5), np.pi * 0.01 * 0.5),
        (sphere_shape(0.1), 4 / 3 * np.pi * 1e-3),
        (hull_shape(np.array(list(np.ndindex(2, 2, 2))) * 0.2 - 0.1), 0.008),
        (capsule_shape(0.1, 0.5), 4 / 3 * np.pi * 1e-3 + np.pi * 0.01 * 0.3),
    ],
    ids=lambda value: getattr(value, "kind", ""),
)
def test_a_solid_is_drawn_as_large_as_it_is_and_where_it_stands(shape: Shape, wanted: float) -> None:
    obstacle = placed(shape, (1.0, -2.0, 0.5), (0.3, -0.4, 0.5))
    mesh = obstacle_mesh(obstacle)
    assert mesh is not None and volume(mesh) == pytest.approx(wanted, rel=0.02)
    distances = [obstacle.distance(vertex) for vertex in mesh.vertices]
    assert max(distances) < 1e-4 and np.median(np.abs(distances)) < 1e-3
    assert mesh.vertices.mean(axis=0) == pytest.approx([1.0, -2.0, 0.5], abs=0.02)
    assert len(polyhedron(shape)) > 0


def test_a_half_space_is_drawn_about_the_point_nearest_to_the_foot() -> None:
    wall = obstacle_mesh(placed(halfspace_shape(), (5.0, 0.8, 3.0), (np.pi / 2, 0.0, 0.0)))
    assert wall is not None
    assert wall.vertices.max(axis=0) == pytest.approx([1.2, 0.81, 1.2], abs=1e-9)
    assert wall.vertices.min(axis=0) == pytest.approx([-1.2, 0.8, -1.2], abs=1e-9)


def test_the_ground_is_not_drawn_again() -> None:
    assert obstacle_mesh(placed(halfspace_shape(), (0.3, 0.0, 0.001))) is None
    assert obstacle_mesh(placed(halfspace_shape(), (0.3, 0.0, -0.3))) is not None
