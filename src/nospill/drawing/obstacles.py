"""Obstacles as they are drawn: meshes in the frame of the path."""

from __future__ import annotations

import numpy as np

from nospill.core.shapes import Shape, polyhedron
from nospill.drawing.geometry import TUBE_SIDES, Mesh, capsule, prism
from nospill.scene.obstacles import Obstacle

OBSTACLE = (122, 138, 158)
"""Colour of what stands around the arm."""

_PATCH = 2.4
"""m; side of the piece of a half-space's surface that is drawn, about the point nearest to the arm's foot."""
_THIN = 0.01
_ON_THE_GROUND = 5e-3
"""m; a level surface as near as this to the ground is the ground."""


def obstacle_mesh(obstacle: Obstacle) -> Mesh | None:
    """The surface of an obstacle; None where it is the ground, which is drawn in any case."""
    shape, rotation, position = obstacle.shape, obstacle.rotation, obstacle.position
    if shape.kind == "halfspace":
        normal = rotation[:, 2]
        if normal[2] > 1.0 - 1e-9 and abs(float(position @ normal)) < _ON_THE_GROUND:
            return None
        position = (position @ normal) * normal
    mesh = shape_surface(shape)
    return Mesh(mesh.vertices @ rotation.T + position, mesh.faces)


def shape_surface(shape: Shape) -> Mesh:
    """The surface of a solid in its own frame, m."""
    if shape.kind == "box":
        length, width, height = shape.sizes
        return prism(_rectangle(length, width), -height / 2, height / 2)
    if shape.kind == "halfspace":
        return prism(_rectangle(_PATCH, _PATCH), -_THIN, 0.0)
    if shape.kind == "cylinder":
        radius, height = shape.sizes
        return prism(radius * _circle(), -height / 2, height / 2)
    if shape.kind == "hull":
        return _hull(shape)
    return capsule(float(shape.points[-1, 2]), shape.ball)


def _hull(shape: Shape) -> Mesh:
    """Its corners are its own for every face, so that light breaks at its edges."""
    # imported here: needed for hulls only
    from scipy.spatial import ConvexHull

    hull = ConvexHull(polyhedron(shape))
    corners = hull.points[hull.simplices]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inwards = np.sum(normal * hull.equations[:, :3], axis=1) < 0.0
    corners[inwards] = corners[inwards][:, ::-1]
    return Mesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))


def _rectangle(length: float, width: float) -> np.ndarray:
    return np.array(((-1, -1), (1, -1), (1, 1), (-1, 1))) * np.array([length, width]) / 2


def _circle() -> np.ndarray:
    angle = 2 * np.pi * np.arange(TUBE_SIDES) / TUBE_SIDES
    return np.column_stack([np.cos(angle), np.sin(angle)])
