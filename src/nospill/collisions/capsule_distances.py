"""Distances of capsules in closed form, with the directions in which they are nearest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nospill.collisions.bodies import Body
from nospill.collisions.body_arrays import BodyArrays
from nospill.robots.kinematics.frames import JointFrames

_PARALLEL = 1e-12
"""Square of the sine below which two axes count as parallel: then an end of one of them is nearest."""
_SHORTEST = 1e-9


def are_capsules(first: Body, second: Body) -> bool:
    """Whether two bodies are capsules or balls."""
    return all(body.shape.kind in ("capsule", "sphere") for body in (first, second))


class CapsuleDistances:
    """Signed distances of two capsules, as `Distances` has them: where their axes cross, what overlaps is the radii."""

    def __init__(self, first: Body, second: Body) -> None:
        self.first, self.second = first, second
        self._radii = first.shape.ball + second.shape.ball

    def between(self, turn: np.ndarray, place: np.ndarray) -> float:
        """Distance, m, with axes (3, 3) and place (3,) of the first body in the frame of the second."""
        own, other = (body.shape.points[[0, -1]] for body in (self.first, self.second))
        return float(np.linalg.norm(nearest_gaps(place + own @ turn.T, other))) - self._radii

    def at(self, frames: JointFrames, samples: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances (m,), m, and unit directions (m, 3) from the first body to the second, at some of the samples."""
        sides = np.repeat([[0], [1]], len(samples), axis=1)
        return capsules_at(BodyArrays.of((self.first, self.second)), sides, frames, samples)


def capsules_at(
    bodies: BodyArrays, sides: np.ndarray, frames: JointFrames, samples: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Distances (m,), m, and unit directions (m, 3) of capsules, by both numbers (2, m), at some samples (m,)."""
    lengths, away = _lengths(nearest_gaps(*(bodies.ends_at(side, frames, samples) for side in sides)))
    return lengths - np.sum(bodies.ball[sides], axis=0), away


def capsule_distances(pairs: Sequence[tuple[Body, Body]], frames: JointFrames) -> np.ndarray:
    """Distances (k, m), m, of k pairs of capsules at m configurations."""
    return capsules_apart(pairs, frames)[0]


def capsules_apart(pairs: Sequence[tuple[Body, Body]], frames: JointFrames) -> tuple[np.ndarray, np.ndarray]:
    """The same, and unit directions (k, m, 3) from the first capsules to the second."""
    if not pairs:
        return np.zeros((0, frames.position.shape[1])), np.zeros((0, frames.position.shape[1], 3))
    lengths, away = _lengths(nearest_gaps(*(_ends([pair[index] for pair in pairs], frames) for index in (0, 1))))
    return lengths - np.array([one.shape.ball + two.shape.ball for one, two in pairs])[:, None], away


def nearest_gaps(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) from the nearest point of one segment to that of another, each given by its ends (..., 2, 3).

    Two segments are nearest inside both, or at one of the four ends. Source: Lumelsky, "On fast computation of distance
    between line segments", Information Processing Letters 21 (1985).
    """
    gaps = np.concatenate([-_from_ends(second, first), _from_ends(first, second), _inside(first, second)], axis=-2)
    squares = np.sum(gaps * gaps, axis=-1)
    nearest = np.argmin(np.where(np.isnan(squares), np.inf, squares), axis=-1)
    return np.take_along_axis(gaps, nearest[..., None, None], axis=-2)[..., 0, :]


def _lengths(gaps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lengths (...,) and directions (..., 3) of vectors (..., 3); any direction where there is none."""
    lengths = np.linalg.norm(gaps, axis=-1)
    away = np.where(lengths[..., None] > _SHORTEST, gaps / np.maximum(lengths, _SHORTEST)[..., None], [0.0, 0.0, 1.0])
    return lengths, away


def _ends(bodies: Sequence[Body], frames: JointFrames) -> np.ndarray:
    """(k, m, 2, 3) ends of the axes at all configurations in base axes, m."""
    joints = [body.joint for body in bodies]
    points = np.array([body.points[[0, -1]] for body in bodies])
    turned = points[:, None] @ np.swapaxes(frames.rotation[joints], 2, 3)
    return frames.position[joints][:, :, None] + turned


def _from_ends(ends: np.ndarray, segment: np.ndarray) -> np.ndarray:
    """Vectors (..., 2, 3) from either end to the nearest point of a segment."""
    start, axis = segment[..., :1, :], segment[..., 1:, :] - segment[..., :1, :]
    length = np.sum(axis * axis, axis=-1)
    share = np.sum((ends - start) * axis, axis=-1) / np.where(length > 0.0, length, 1.0)
    return start + np.clip(share, 0.0, 1.0)[..., None] * axis - ends


def _inside(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Vector (..., 1, 3) between the lines where they are nearest within both segments, else no numbers."""
    one, two = first[..., 1, :] - first[..., 0, :], second[..., 1, :] - second[..., 0, :]
    gap = first[..., 0, :] - second[..., 0, :]
    a, b, c = (np.sum(u * v, axis=-1) for u, v in ((one, one), (one, two), (two, two)))
    d, e = np.sum(one * gap, axis=-1), np.sum(two * gap, axis=-1)
    area = a * c - b * b
    crossing = area > _PARALLEL * a * c
    safe = np.where(crossing, area, 1.0)
    share, other = (b * e - c * d) / safe, (a * e - b * d) / safe
    within = crossing & (share >= 0.0) & (share <= 1.0) & (other >= 0.0) & (other <= 1.0)
    nearest = other[..., None] * two - share[..., None] * one - gap
    return np.where(within[..., None], nearest, np.nan)[..., None, :]
