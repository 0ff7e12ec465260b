"""Nearest distances over time, for figures: what is nearest to each obstacle, and the arm to itself and its load."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.collisions.distances import distances_of
from nospill.collisions.pairs import Pair, scene_pairs
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from nospill.scene.scene import Scene


@dataclass(frozen=True, slots=True)
class NearestOverTime:
    """The least distance to one obstacle, or of the arm to itself and its load.

    Attributes:
        obstacle: its name; empty for the arm to itself.
        limit: least distance that is allowed, m.
        distance: (m,) m, negative where bodies overlap.
        nearest: the pair whose distance is least of all, as rows name it.
    """

    obstacle: str
    limit: float
    distance: np.ndarray
    nearest: str


def nearest_over_time(scene: Scene, q: np.ndarray) -> tuple[NearestOverTime, ...]:
    """Nearest distances at joint positions (m, n), rad, in the order of the obstacles; none without obstacles."""
    if not scene.has_surroundings:
        return ()
    frames, every = joint_frames(arm_chain(scene.robot), q), np.arange(len(q))
    groups: dict[str, list[Pair]] = {}
    for pair in scene_pairs(scene):
        groups.setdefault("" if pair.second.obstacle is None else pair.second.name, []).append(pair)
    histories = []
    for name, pairs in groups.items():
        distances = np.array([distances_of(pair.first, pair.second).at(frames, every)[0] for pair in pairs])
        nearest = pairs[int(np.argmin(distances.min(axis=1)))]
        histories.append(NearestOverTime(name, nearest.limit, distances.min(axis=0), nearest.subject))
    return tuple(histories)
