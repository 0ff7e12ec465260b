"""Which configurations of an arm are clear: many at once, every pair of bodies with what it must keep."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from nospill.collisions.along_path import slack_bounds
from nospill.collisions.bodies import Body
from nospill.collisions.box_bounds import box_about
from nospill.collisions.capsule_distances import are_capsules
from nospill.collisions.distances import Distances
from nospill.collisions.pairs import Pair, scene_pairs
from nospill.robots.kinematics.frames import JointFrames, arm_chain, joint_frames
from nospill.scene.scene import Scene


class Configurations:
    """Looks at configurations of one scene.

    Of pairs with what stands still, a ball about the first body and a box about the second spare most of them the query
    of coal; of the arm with itself and its load, what `slack_bounds` says of them.
    """

    def __init__(self, scene: Scene) -> None:
        """Prepare the pairs of a scene."""
        self._chain = arm_chain(scene.robot)
        self._own = [pair for pair in scene_pairs(scene) if pair.of_arm]
        self._around = [pair for pair in scene_pairs(scene) if not pair.of_arm]
        self._measures: dict[Pair, Distances] = {}
        self._limits = np.array([pair.limit for pair in self._around])

    def clear(self, q: np.ndarray, spare: np.ndarray | None = None) -> np.ndarray:
        """Whether nothing is in the way of some configurations; joint limits are not looked at.

        Args:
            q: (m, n), rad.
            spare: (m,) slack to keep from obstacles in addition to the clearance, m; none when left out.

        Returns:
            (m,) of bool.
        """
        free, frames = np.ones(len(q), dtype=bool), joint_frames(self._chain, q)
        if self._around:
            self._look_around(free, frames, np.zeros(len(q)) if spare is None else spare)
        if self._own:
            self._look_at_itself(free, frames)
        return free

    def _look_at_itself(self, free: np.ndarray, frames: JointFrames) -> None:
        slack = slack_bounds(self._own, frames, enough=0.0)
        exact = np.array([are_capsules(pair.first, pair.second) for pair in self._own], dtype=bool)
        free &= ~np.any(slack[exact] < 0.0, axis=0)
        for index in np.flatnonzero(~exact):
            pair, near = self._own[index], np.flatnonzero(free & (slack[index] < 0.0))
            if len(near):
                free[near] = self._measure(pair).at(frames, near)[0] >= pair.limit

    def _look_around(self, free: np.ndarray, frames: JointFrames, spare: np.ndarray) -> None:
        wanted = self._limits[:, None] + spare
        joints, points, body_axes, first, second = self._bodies
        turns, at = frames.rotation[joints], frames.position[joints]
        centres, origins = (at + (turns @ part[:, None, :, None])[..., 0] for part in points)
        axes = turns @ body_axes[:, None]
        low, high, radii = self._sizes
        # what stands still has the same axes everywhere
        local = (centres[first] - origins[second]) @ body_axes[second]
        beyond = np.maximum(np.maximum(low - local, local - high), 0.0)
        gaps = np.sqrt(np.einsum("kmi,kmi->km", beyond, beyond)) - radii
        pairs, looks = np.nonzero(gaps < wanted)
        back = np.swapaxes(axes[second[pairs], looks], 1, 2)
        places = (back @ (origins[first[pairs], looks] - origins[second[pairs], looks])[:, :, None])[:, :, 0]
        turned = back @ axes[first[pairs], looks]
        least = wanted[pairs, looks].tolist()
        for pair, look, turn, place, kept in zip(pairs.tolist(), looks.tolist(), turned, places, least, strict=True):
            if free[look]:
                free[look] = self._measure(self._around[pair]).between(turn, place) >= kept

    @cached_property
    def _bodies(self) -> tuple[np.ndarray, tuple[np.ndarray, ...], np.ndarray, np.ndarray, np.ndarray]:
        """Joints, centres and positions, and axes of the bodies of the pairs with what stands still; whose they are."""
        numbers: dict[Body, int] = {}
        for pair in self._around:
            for body in (pair.first, pair.second):
                numbers.setdefault(body, len(numbers))
        points = tuple(np.array([getattr(body, of) for body in numbers]) for of in ("centre", "position"))
        first, second = (np.array([numbers[getattr(pair, of)] for pair in self._around]) for of in ("first", "second"))
        joints = np.array([body.joint for body in numbers])
        return joints, points, np.array([body.rotation for body in numbers]), first, second

    @cached_property
    def _sizes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Box about the second body of each of these pairs, and radius of the ball about the first."""
        boxes = np.array([box_about(pair.second.shape) for pair in self._around]).transpose(1, 0, 2)
        return boxes[0][:, None], boxes[1][:, None], np.array([pair.first.radius for pair in self._around])[:, None]

    def _measure(self, pair: Pair) -> Distances:
        if pair not in self._measures:
            self._measures[pair] = Distances(pair.first, pair.second)
        return self._measures[pair]
