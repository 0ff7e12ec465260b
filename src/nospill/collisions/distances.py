"""Distances of two bodies at given configurations, by coal, with the directions in which they are nearest.

How far these separate the bodies is computed in `supports`: a bound that does not depend on coal.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from types import ModuleType
from typing import Any

import numpy as np

from nospill.collisions.bodies import Body
from nospill.collisions.body_arrays import BodyArrays
from nospill.collisions.capsule_distances import CapsuleDistances, are_capsules
from nospill.core.shapes import Shape, polyhedron
from nospill.robots.kinematics.frames import JointFrames

_SHORTEST = 1e-9
_TOLERANCE = 1e-8
"""m; of the distances of coal, on whose square root the directions depend."""


def coal_library() -> ModuleType:
    """The library coal, loaded where something is so near that a bound does not do."""
    import coal  # pyright: ignore[reportMissingImports] # in a folder that the wheel puts on the path

    return coal


class Distances:
    """Signed distances of two bodies, negative where they overlap."""

    def __init__(self, first: Body, second: Body) -> None:
        """Prepare a pair."""
        coal = coal_library()
        self.first, self.second = first, second
        self._measure = coal.ComputeDistance(_geometry(first.shape), _geometry(second.shape))
        self._transform, self._still = coal.Transform3s, coal.Transform3s.Identity()
        self._request, self._result = coal.DistanceRequest(), coal.DistanceResult()
        self._request.gjk_tolerance = _TOLERANCE

    def between(self, turn: np.ndarray, place: np.ndarray) -> float:
        """Distance, m, with axes (3, 3) and place (3,) of the first body in the frame of the second."""
        self._result.clear()
        return float(self._measure(self._transform(turn, place), self._still, self._request, self._result))

    @property
    def normal(self) -> np.ndarray:
        """(3,) direction in which they were found to be nearest the last time, in the frame of the second."""
        return self._result.normal  # type: ignore[no-any-return]

    def at(self, frames: JointFrames, samples: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances (m,), m, and unit directions (m, 3) from the first body to the second, at some of the samples."""
        bodies, sides = BodyArrays.of((self.first, self.second)), np.repeat([[0], [1]], len(samples), axis=1)
        return distances_by_coal([self] * len(samples), bodies, sides, frames, samples)


def distances_by_coal(
    pairs: Sequence[Distances], bodies: BodyArrays, sides: np.ndarray, frames: JointFrames, samples: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Distances (m,), m, and unit directions (m, 3) of pairs (m,), with both numbers (2, m), at some samples (m,)."""
    positions, rotations = bodies.poses(sides[0], frames, samples)
    others, turns = bodies.poses(sides[1], frames, samples)
    back = np.swapaxes(turns, 1, 2)
    gaps, turned = (back @ (positions - others)[:, :, None])[:, :, 0], back @ rotations
    distance, normals = np.empty(len(pairs)), np.empty((len(pairs), 3))
    for index, (pair, gap, turn) in enumerate(zip(pairs, gaps, turned, strict=True)):
        distance[index] = pair.between(turn, gap)
        normals[index] = pair.normal
    directions = (turns @ normals[:, :, None])[:, :, 0]
    flat = np.array([pair.second.shape.kind == "halfspace" for pair in pairs], dtype=bool)
    directions[flat] = -turns[flat, :, 2]
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    # what gives no direction gives no bound either: any will do
    return distance, np.where(lengths > _SHORTEST, directions / np.maximum(lengths, _SHORTEST), [0.0, 0.0, 1.0])


def distances_of(first: Body, second: Body) -> Distances | CapsuleDistances:
    """What measures two bodies: coal, or for capsules the closed form."""
    return CapsuleDistances(first, second) if are_capsules(first, second) else Distances(first, second)


def ball_gaps(pairs: Sequence[tuple[Body, Body]], frames: JointFrames) -> np.ndarray:
    """Bounds (k, m) on the distances of k pairs by the balls about both, m; of a half-space none."""
    if not pairs:
        return np.zeros((0, frames.position.shape[1]))
    numbers: dict[Body, int] = {}
    first, second = (
        np.array([numbers.setdefault(body, len(numbers)) for body in column]) for column in zip(*pairs, strict=True)
    )
    joints, points = [body.joint for body in numbers], np.array([body.centre for body in numbers])
    centres = frames.position[joints] + (frames.rotation[joints] @ points[:, None, :, None])[..., 0]
    radii = np.array([body.radius for body in numbers])
    return np.linalg.norm(centres[first] - centres[second], axis=2) - (radii[first] + radii[second])[:, None]


@lru_cache(maxsize=512)
def _geometry(shape: Shape) -> Any:
    """The same in coal; of a hull the polyhedron about it."""
    coal = coal_library()
    if shape.kind == "box":
        return coal.Box(*shape.sizes)
    if shape.kind == "cylinder":
        return coal.Cylinder(*shape.sizes)
    if shape.kind == "sphere":
        return coal.Sphere(*shape.sizes)
    if shape.kind == "capsule":
        radius, height = shape.sizes
        return coal.Capsule(radius, height - 2.0 * radius)
    if shape.kind == "halfspace":
        return coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)
    corners = coal.StdVec_Vec3s()
    for corner in polyhedron(shape):
        corners.append(corner)
    return coal.Convex.convexHull(corners, True, "Qt")
