"""Convex solids: the hull of points, each widened by a horizontal disc, the whole rounded by a ball.

One form holds boxes (eight points), cylinders (two points with discs), spheres (a point and a ball), capsules (two
points and a ball), half-spaces (one face), and the outsides of cups (a disc at every corner of the meridian). Its
support function is exact, so that bounds on distances need no approximation of round faces.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Literal

import numpy as np

from nospill.core.arrays import read_only

ShapeKind = Literal["box", "cylinder", "sphere", "capsule", "halfspace", "hull"]


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """A convex solid in its own frame; equal only to itself, and never changed.

    Attributes:
        kind: what it is called.
        sizes: numbers that state it, m: three sides; radius and height; radius; none of a half-space or a hull.
        points: (k, 3) corners of the core, m.
        discs: (k,) radius of the disc about z at each of them, m.
        ball: radius by which all is rounded, m.
    """

    kind: ShapeKind
    sizes: tuple[float, ...]
    points: np.ndarray
    discs: np.ndarray
    ball: float = 0.0

    @property
    def centre(self) -> np.ndarray:
        """(3,) middle of the bounding box, m; of a half-space the point on its surface."""
        return (self.points.min(axis=0) + self.points.max(axis=0)) / 2.0

    @property
    def radius(self) -> float:
        """Radius of a ball about `centre` that holds it, m; infinite for a half-space."""
        if self.kind == "halfspace":
            return math.inf
        gaps = self.points - self.centre
        across = np.hypot(gaps[:, 0], gaps[:, 1]) + self.discs
        return float(np.max(np.hypot(across, gaps[:, 2]))) + self.ball


def box_shape(size: Sequence[float]) -> Shape:
    """A box of three sides, m, about its centre."""
    corners = np.array(list(product((-0.5, 0.5), repeat=3))) * np.array(size)
    return Shape("box", tuple(size), read_only(corners), read_only(np.zeros(8)))


def cylinder_shape(radius: float, height: float) -> Shape:
    """A cylinder about z with its centre at the origin, m."""
    ends = np.array([[0.0, 0.0, -height / 2], [0.0, 0.0, height / 2]])
    return Shape("cylinder", (radius, height), read_only(ends), read_only([radius, radius]))


def sphere_shape(radius: float) -> Shape:
    """A ball about the origin, m."""
    return Shape("sphere", (radius,), read_only(np.zeros((1, 3))), read_only([0.0]), radius)


def capsule_shape(radius: float, height: float) -> Shape:
    """A cylinder about z with two half balls as ends; `height` is that of the whole, at least the diameter, m."""
    half = height / 2 - radius
    ends = np.array([[0.0, 0.0, -half], [0.0, 0.0, half]])
    return Shape("capsule", (radius, height), read_only(ends), read_only([0.0, 0.0]), radius)


def halfspace_shape() -> Shape:
    """All below the plane z = 0."""
    return Shape("halfspace", (), read_only(np.zeros((1, 3))), read_only([0.0]))


def hull_shape(points: np.ndarray, discs: np.ndarray | None = None) -> Shape:
    """The hull of points (k, 3), m, each with a disc (k,) about z, m."""
    own = np.zeros(len(points)) if discs is None else discs
    return Shape("hull", (), read_only(points), read_only(own))


@lru_cache(maxsize=512)
def polyhedron(shape: Shape, sides: int = 32) -> np.ndarray:
    """Corners (n, 3), m, of a polyhedron that holds the shape without its ball, discs as circumscribed polygons."""
    angles = 2.0 * np.pi * np.arange(sides) / sides
    ring = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(sides)]) / math.cos(math.pi / sides)
    parts = [
        point[None] if disc == 0.0 else point + disc * ring
        for point, disc in zip(shape.points, shape.discs, strict=True)
    ]
    return np.concatenate(parts)


def point_distance(shape: Shape, point: np.ndarray) -> float:
    """Signed distance of a point (3,), m, in the shape's frame from its surface; negative inside.

    Of a hull with discs that of the polyhedron about it.
    """
    x, y, z = (float(value) for value in point)
    if shape.kind == "halfspace":
        return z
    if shape.kind == "box":
        beyond = np.abs([x, y, z]) - np.array(shape.sizes) / 2.0
        return float(np.linalg.norm(np.maximum(beyond, 0.0)) + min(float(beyond.max()), 0.0))
    if shape.kind == "cylinder":
        radius, height = shape.sizes
        beyond = np.array([math.hypot(x, y) - radius, abs(z) - height / 2])
        return float(np.linalg.norm(np.maximum(beyond, 0.0)) + min(float(beyond.max()), 0.0))
    if shape.kind in ("sphere", "capsule"):
        half = float(shape.points[-1, 2])
        return math.hypot(x, y, z - min(max(z, -half), half)) - shape.ball
    # imported here: needed for hulls only
    from scipy.spatial import ConvexHull

    faces = ConvexHull(polyhedron(shape)).equations
    return float(np.max(faces[:, :3] @ point + faces[:, 3])) - shape.ball
