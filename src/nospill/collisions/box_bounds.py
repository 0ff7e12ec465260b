"""Bounds on the distances of what the arm carries from its links: a box about the one, the capsule of the other.

The distance of a box from a point of a segment is convex along the segment: a golden section finds the least one, and
what is left of the section times the length of the segment bounds the error.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from nospill.collisions.bodies import Body
from nospill.core.shapes import Shape
from nospill.robots.kinematics.frames import JointFrames

_GOLDEN = (5.0**0.5 - 1.0) / 2.0
_CUTS = 12
_LEFT = _GOLDEN**_CUTS
_SHORTEST = 1e-9


def box_bounds(pairs: Sequence[tuple[Body, Body]], frames: JointFrames) -> tuple[np.ndarray, np.ndarray]:
    """Bounds (k, m) on the distances, m, of bodies from capsules, and unit directions (k, m, 3) from box to capsule.

    Args:
        pairs: k, each a body and a capsule.
        frames: of the arm at m configurations.
    """
    if not pairs:
        return np.zeros((0, frames.position.shape[1])), np.zeros((0, frames.position.shape[1], 3))
    low, high = np.array([box_about(body.shape) for body, _ in pairs]).transpose(1, 0, 2)[:, :, None]
    joints, box_axes = [body.joint for body, _ in pairs], np.array([body.rotation for body, _ in pairs])
    axes = frames.rotation[joints] @ box_axes[:, None]
    origin = frames.position[joints] + _turn(frames.rotation[joints], np.array([body.position for body, _ in pairs]))
    others = [capsule.joint for _, capsule in pairs]
    ends = np.array([capsule.points[[0, -1]] for _, capsule in pairs])
    back = np.swapaxes(axes, 2, 3)
    start, end = (
        _turn(back, frames.position[others] + _turn(frames.rotation[others], ends[:, index]) - origin)
        for index in (0, 1)
    )
    axis = end - start

    def beyond(share: np.ndarray) -> np.ndarray:
        """Vectors from the box to the points at a share of the segments."""
        at = start + share[..., None] * axis
        return at - np.clip(at, low, high)

    share = _least(beyond, start.shape[:2])
    gap = beyond(share)
    distance = np.sqrt(np.sum(gap * gap, axis=-1))
    error = _LEFT * np.sqrt(np.sum(axis * axis, axis=-1))
    radii = np.array([capsule.shape.ball for _, capsule in pairs])[:, None]
    away = np.where(distance[..., None] > _SHORTEST, gap / np.maximum(distance, _SHORTEST)[..., None], [0.0, 0.0, 1.0])
    return distance - error - radii, _turn(axes, away)


def box_about(shape: Shape) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner of the box about a shape in its own frame, m; infinite where a half-space is."""
    if shape.kind == "halfspace":
        return np.full(3, -np.inf), np.array([np.inf, np.inf, 0.0])
    wide = shape.discs[:, None] * [1.0, 1.0, 0.0]
    return (shape.points - wide).min(axis=0) - shape.ball, (shape.points + wide).max(axis=0) + shape.ball


def _least(beyond: Callable[[np.ndarray], np.ndarray], shape: tuple[int, ...]) -> np.ndarray:
    """Share (k, m) of each segment at which it is nearest to its box, by a golden section."""
    first, last = np.zeros(shape), np.ones(shape)
    inner, outer = np.full(shape, 1.0 - _GOLDEN), np.full(shape, _GOLDEN)
    square = [np.sum(gap * gap, axis=-1) for gap in (beyond(inner), beyond(outer))]
    for _ in range(_CUTS - 1):
        before = square[0] <= square[1]
        first, last = np.where(before, first, inner), np.where(before, outer, last)
        fresh = np.where(before, first + (1.0 - _GOLDEN) * (last - first), first + _GOLDEN * (last - first))
        gap = beyond(fresh)
        new = np.sum(gap * gap, axis=-1)
        inner, outer = np.where(before, fresh, outer), np.where(before, inner, fresh)
        square = [np.where(before, new, square[1]), np.where(before, square[0], new)]
    return np.where(square[0] <= square[1], inner, outer)


def _turn(turns: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (k, m, 3) or (k, 3) turned by axes (k, m, 3, 3)."""
    some = vectors[:, None] if vectors.ndim == 2 else vectors
    return (turns @ some[..., None])[..., 0]
