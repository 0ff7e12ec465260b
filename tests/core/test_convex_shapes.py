"""Convex solids: distances of points in closed form, and the balls and polyhedra about them."""

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
    point_distance,
    polyhedron,
    sphere_shape,
)

CUP = hull_shape(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]]), np.array([0.03, 0.045]))
SOLIDS = (
    box_shape((0.2, 0.4, 0.6)),
    cylinder_shape(0.1, 0.4),
    sphere_shape(0.1),
    capsule_shape(0.1, 0.5),
    CUP,
)


@pytest.mark.parametrize(
    ("shape", "point", "distance"),
    [
        (box_shape((0.2, 0.4, 0.6)), (0.0, 0.0, 0.0), -0.1),
        (box_shape((0.2, 0.4, 0.6)), (0.13, 0.24, 0.3), 0.05),
        (cylinder_shape(0.1, 0.4), (0.0, 0.05, 0.0), -0.05),
        (cylinder_shape(0.1, 0.4), (0.0, 0.13, -0.24), 0.05),
        (sphere_shape(0.1), (0.0, 0.3, 0.4), 0.4),
        (capsule_shape(0.1, 0.5), (0.0, 0.0, 0.3), 0.05),
        (capsule_shape(0.1, 0.5), (0.3, 0.0, 0.1), 0.2),
        (halfspace_shape(), (5.0, 1.0, -0.2), -0.2),
    ],
)
def test_distance_of_a_point(shape: Shape, point: tuple[float, ...], distance: float) -> None:
    assert point_distance(shape, np.array(point)) == pytest.approx(distance, abs=1e-12)


def test_distance_of_a_point_in_a_cup_is_that_of_its_polyhedron() -> None:
    assert point_distance(CUP, np.array([0.0, 0.0, 0.15])) == pytest.approx(0.05)
    assert -0.039 < point_distance(CUP, np.array([0.0, 0.0, 0.05])) < -0.037


@pytest.mark.parametrize("shape", SOLIDS, ids=lambda shape: shape.kind)
def test_ball_and_polyhedron_hold_the_shape(shape: Shape) -> None:
    """Support functions: that of the shape lies below those of the ball and of the polyhedron with its ball."""
    directions = np.random.default_rng(0).normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    across = np.hypot(directions[:, 0], directions[:, 1])[:, None]
    support = np.max(directions @ shape.points.T + across * shape.discs, axis=1) + shape.ball
    assert np.all(support <= directions @ shape.centre + shape.radius + 1e-12)
    outer = np.max(directions @ polyhedron(shape).T, axis=1) + shape.ball
    assert np.all(support <= outer + 1e-12) and np.all(outer <= support + 0.006 * np.max(shape.discs) + 1e-12)
