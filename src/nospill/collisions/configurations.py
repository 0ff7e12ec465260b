"""Which configurations of an arm are clear: many at once, every pair of bodies with what it must keep."""

from __future__ import annotations

import numpy as np

from nospill.collisions.bodies import Body
from nospill.collisions.distances import Distances
from nospill.collisions.pairs import scene_pairs
from nospill.core.shapes import Shape
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from nospill.scene.scene import Scene


class Configurations:
    """Looks at configurations of one scene.

    A ball about the first body of a pair and a box about the second spare most of them the query of coal.
    """

    def __init__(self, scene: Scene) -> None:
        """Prepare the pairs of a scene.

        Raises:
            MissingExtraError: the library coal is not installed.
        """
        self._chain = arm_chain(scene.robot)
        # those whose second body stands still come first
        pairs = sorted(scene_pairs(scene), key=lambda pair: pair.second.joint > 0)
        self._measures = [Distances(pair.first, pair.second) for pair in pairs]
        self._limits = np.array([pair.limit for pair in pairs])
        self._around = np.array([pair.second.obstacle is not None for pair in pairs])
        numbers: dict[Body, int] = {}
        for pair in pairs:
            for body in (pair.first, pair.second):
                numbers.setdefault(body, len(numbers))
        self._joints = np.array([body.joint for body in numbers])
        self._points = tuple(np.array([getattr(body, of) for body in numbers]) for of in ("centre", "position"))
        self._axes = np.array([body.rotation for body in numbers])
        self._first = np.array([numbers[pair.first] for pair in pairs])
        self._second = np.array([numbers[pair.second] for pair in pairs])
        self._still = sum(pair.second.joint == 0 for pair in pairs)
        self._radii = np.array([pair.first.radius for pair in pairs])
        self._low, self._high = np.array([_box(pair.second.shape) for pair in pairs]).transpose(1, 0, 2)[:, :, None]

    def clear(self, q: np.ndarray, spare: np.ndarray | None = None) -> np.ndarray:
        """Whether nothing is in the way of some configurations; joint limits are not looked at.

        Args:
            q: (m, n), rad.
            spare: (m,) room to keep from obstacles beside what must be kept, m; none when left out.

        Returns:
            (m,) of bool.
        """
        free, frames = np.ones(len(q), dtype=bool), joint_frames(self._chain, q)
        wanted = self._limits[:, None] + self._around[:, None] * (np.zeros(len(q)) if spare is None else spare)
        turns, at = frames.rotation[self._joints], frames.position[self._joints]
        centres, origins = (at + (turns @ points[:, None, :, None])[..., 0] for points in self._points)
        axes = turns @ self._axes[:, None]
        pairs, looks = np.nonzero(self._gaps(centres, origins, axes) < wanted)
        first, second = self._first[pairs], self._second[pairs]
        back = np.swapaxes(axes[second, looks], 1, 2)
        places = (back @ (origins[first, looks] - origins[second, looks])[:, :, None])[:, :, 0]
        turned = back @ axes[first, looks]
        least = wanted[pairs, looks].tolist()
        for pair, look, turn, place, kept in zip(pairs.tolist(), looks.tolist(), turned, places, least, strict=True):
            if free[look]:
                free[look] = self._measures[pair].between(turn, place) >= kept
        return free

    def _gaps(self, centres: np.ndarray, origins: np.ndarray, axes: np.ndarray) -> np.ndarray:
        """Bounds (k, m) on the distances of the pairs by ball and box, m; bodies by places (b, m, 3) and axes."""
        still, moving = self._second[: self._still], self._second[self._still :]
        gaps = centres[self._first] - origins[self._second]
        local = np.empty_like(gaps)
        local[: self._still] = gaps[: self._still] @ self._axes[still]
        local[self._still :] = (gaps[self._still :, :, None] @ axes[moving])[:, :, 0]
        beyond = np.maximum(np.maximum(self._low - local, local - self._high), 0.0)
        return np.sqrt(np.einsum("kmi,kmi->km", beyond, beyond)) - self._radii[:, None]


def _box(shape: Shape) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner of the box about a shape in its own frame, m; infinite where a half-space is."""
    if shape.kind == "halfspace":
        return np.full(3, -np.inf), np.array([np.inf, np.inf, 0.0])
    wide = shape.discs[:, None] * [1.0, 1.0, 0.0]
    return (shape.points - wide).min(axis=0) - shape.ball, (shape.points + wide).max(axis=0) + shape.ball
