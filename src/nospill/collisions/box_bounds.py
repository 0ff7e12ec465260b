"""Bounds on the distances of what the arm carries from its links: a box about the one, the capsule of the other.

The square of the distance of a box from a point of a segment is convex along the segment, and quadratic between the
planes of the box's sides: its slope, at these places and at both ends, tells between which of them it is least.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nospill.collisions.bodies import Body
from nospill.core.shapes import Shape
from nospill.robots.kinematics.frames import JointFrames

_ROUNDING = 1e-9
"""Of the place where a segment is nearest, a part of its length."""
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
    nearest = start + _nearest_share(start, axis, low, high)[..., None] * axis
    gap = nearest - np.clip(nearest, low, high)
    distance = np.sqrt(np.sum(gap * gap, axis=-1))
    error = _ROUNDING * np.sqrt(np.sum(axis * axis, axis=-1))
    radii = np.array([capsule.shape.ball for _, capsule in pairs])[:, None]
    away = np.where(distance[..., None] > _SHORTEST, gap / np.maximum(distance, _SHORTEST)[..., None], [0.0, 0.0, 1.0])
    return distance - error - radii, _turn(axes, away)


def ball_bounds(pairs: Sequence[tuple[Body, Body]], frames: JointFrames) -> np.ndarray:
    """Bounds (k, m) on the same distances, m, by the ball about the body: coarser, and a tenth of the work."""
    if not pairs:
        return np.zeros((0, frames.position.shape[1]))
    joints, others = ([pair[index].joint for pair in pairs] for index in (0, 1))
    centre = frames.position[joints] + _turn(frames.rotation[joints], np.array([body.centre for body, _ in pairs]))
    ends = np.array([capsule.points[[0, -1]] for _, capsule in pairs])
    start, end = (frames.position[others] + _turn(frames.rotation[others], ends[:, index]) for index in (0, 1))
    axis = end - start
    length = np.maximum(np.sum(axis * axis, axis=-1), _SHORTEST**2)
    share = np.clip(np.sum((centre - start) * axis, axis=-1) / length, 0.0, 1.0)
    radii = np.array([body.radius + capsule.shape.ball for body, capsule in pairs])[:, None]
    return np.linalg.norm(start + share[..., None] * axis - centre, axis=-1) - radii


def box_about(shape: Shape) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner of the box about a shape in its own frame, m; infinite where a half-space is."""
    if shape.kind == "halfspace":
        return np.full(3, -np.inf), np.array([np.inf, np.inf, 0.0])
    wide = shape.discs[:, None] * [1.0, 1.0, 0.0]
    return (shape.points - wide).min(axis=0) - shape.ball, (shape.points + wide).max(axis=0) + shape.ball


def _nearest_share(start: np.ndarray, axis: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Share (k, m) of each segment, start (k, m, 3) and axis (k, m, 3), at which it is nearest to its box."""
    along = np.where(axis == 0.0, 1.0, axis)
    ends = np.broadcast_to([0.0, 1.0], (*start.shape[:2], 2))
    shares = np.clip(np.concatenate([(low - start) / along, (high - start) / along, ends], axis=-1), 0.0, 1.0)
    at = start[..., None, :] + shares[..., None] * axis[..., None, :]
    slopes = np.einsum("kmsi,kmi->kms", at - np.clip(at, low[..., None, :], high[..., None, :]), axis)
    falls = slopes <= 0.0
    before, after = np.max(np.where(falls, shares, 0.0), axis=-1), np.min(np.where(falls, 1.0, shares), axis=-1)
    down, up = np.max(np.where(falls, slopes, -np.inf), axis=-1), np.min(np.where(falls, np.inf, slopes), axis=-1)
    inside = np.isfinite(down) & np.isfinite(up)
    down, up = np.where(inside, down, 0.0), np.where(inside, up, 1.0)
    # it falls, or rises, all along where there is one kind of slope only
    return np.where(inside, before + (after - before) * down / (down - up), np.where(falls[..., -1], 1.0, 0.0))


def _turn(turns: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (k, m, 3) or (k, 3) turned by axes (k, m, 3, 3)."""
    some = vectors[:, None] if vectors.ndim == 2 else vectors
    return (turns @ some[..., None])[..., 0]
