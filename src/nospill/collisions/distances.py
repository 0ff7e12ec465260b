"""Distances of two bodies at given configurations, by coal, and bounds on them that do not depend on coal.

The signed distance of two convex bodies is the largest over all directions n of how far n separates them, so any
direction gives a lower bound. coal finds the best direction; how far it separates is computed here from the bodies'
support functions.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from types import ModuleType
from typing import Any

import numpy as np

from nospill.collisions.bodies import Body
from nospill.collisions.capsule_distances import CapsuleDistances, are_capsules
from nospill.core.arrays import cross
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

    def at(self, frames: JointFrames, samples: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances (m,), m, and unit directions (m, 3) from the first body to the second, at some of the samples."""
        (positions, rotations), (others, turns) = (_pose(body, frames, samples) for body in (self.first, self.second))
        back = np.swapaxes(turns, 1, 2)
        gaps, turned = (back @ (positions - others)[:, :, None])[:, :, 0], back @ rotations
        distance, normals = np.empty(len(samples)), np.empty((len(samples), 3))
        for index, (gap, turn) in enumerate(zip(gaps, turned, strict=True)):
            distance[index] = self.between(turn, gap)
            normals[index] = self._result.normal
        if self.second.shape.kind == "halfspace":
            directions = -turns[:, :, 2]
        else:
            directions = (turns @ normals[:, :, None])[:, :, 0]
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


def separation(
    first: Body,
    second: Body,
    frames: JointFrames,
    samples: np.ndarray,
    directions: np.ndarray,
    ahead: np.ndarray,
) -> np.ndarray:
    """How far given directions (m, 3) separate two bodies (m,), m, `ahead` (m,) s later at steady speeds."""
    reach = _support(first, frames, samples, directions, ahead)
    return -_support(second, frames, samples, -directions, ahead) - reach


def _support(
    body: Body, frames: JointFrames, samples: np.ndarray, direction: np.ndarray, ahead: np.ndarray
) -> np.ndarray:
    """Largest coordinate (m,) of a body along unit directions (m, 3) in base axes, every point moved on by its speed.

    With the frame's velocities v, w, a point r in it moves on by t (v + w x r), so along n it has n (p + t v) + g r
    with g = R^T (n + t n x w); a disc of radius r about a in the frame adds r |g - a (a g)|, a ball its radius.
    """
    joint, shape = body.joint, body.shape
    later = ahead[:, None]
    if joint:
        pull = direction + later * cross(direction, frames.angular_velocity[joint][samples])
        pull = (pull[:, None] @ frames.rotation[joint][samples])[:, 0]
        base = frames.position[joint][samples] + later * frames.velocity[joint][samples]
        along = np.sum(direction * base, axis=1)
    else:
        pull, along = direction, np.zeros(len(direction))
    values = pull @ body.points.T
    if np.any(shape.discs):
        axis = body.rotation[:, 2]
        across = np.linalg.norm(pull - (pull @ axis)[:, None] * axis, axis=1)
        values = values + across[:, None] * shape.discs
    return along + np.max(values, axis=1) + shape.ball


def _pose(body: Body, frames: JointFrames, samples: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position (m, 3) and axes (m, 3, 3) of a body's own frame."""
    turns = frames.rotation[body.joint][samples]
    return frames.position[body.joint][samples] + turns @ body.position, turns @ body.rotation


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
