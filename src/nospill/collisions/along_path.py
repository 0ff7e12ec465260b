"""How near arm, level tray and cargo come to obstacles and to each other along a joint path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.collisions.distances import Distances
from nospill.collisions.pairs import Pair, scene_pairs
from nospill.robots.joint_paths.search import JointPath
from nospill.robots.kinematics.frames import JointFrames, arm_chain, joint_frames
from nospill.scene.scene import Scene

_PLACES = 201
"""Places along the path at which distances are measured; the judge looks between them."""


@dataclass(frozen=True, slots=True)
class Nearness:
    """The pair of bodies that comes nearest along a joint path.

    Attributes:
        pair: both.
        room: distance less what must be kept, m; negative where it is not kept.
        s: where on the path, 0 to 1.
    """

    pair: Pair
    room: float
    s: float


def nearest_along(scene: Scene, joint_path: JointPath, *, on_path: bool = False, places: int = _PLACES) -> Nearness:
    """The pair with the least room along a joint path.

    Args:
        scene: with obstacles.
        joint_path: of the level tray.
        on_path: look at the tray and its cargo against obstacles alone, which do not depend on the branch.
        places: number of them, evenly along the path.

    Raises:
        MissingExtraError: the library coal is not installed.
    """
    s = np.linspace(0.0, 1.0, places)
    frames = joint_frames(arm_chain(scene.robot), joint_path.at(s))
    worst: Nearness | None = None
    for pair in scene_pairs(scene):
        if on_path and not (pair.first.on_path and pair.second.obstacle is not None):
            continue
        where = np.arange(places) if worst is None else np.flatnonzero(ball_room(pair, frames) < worst.room)
        if not len(where):
            continue
        room = Distances(pair.first, pair.second).at(frames, where)[0] - pair.limit
        least = int(np.argmin(room))
        if worst is None or room[least] < worst.room:
            worst = Nearness(pair, float(room[least]), float(s[where[least]]))
    assert worst is not None  # there is a tray
    return worst


def least_room(scene: Scene, q: np.ndarray, *, within: float) -> dict[str, float]:
    """Distance less what must be kept, m, the least over joint positions (m, n), rad, by the subjects of the pairs.

    Where it is above `within`, m, it is a bound by the balls about the bodies.

    Raises:
        MissingExtraError: the library coal is not installed.
    """
    frames, found = joint_frames(arm_chain(scene.robot), q), dict[str, float]()
    for pair in scene_pairs(scene):
        room = ball_room(pair, frames)
        near = np.flatnonzero(room < within)
        room[near] = Distances(pair.first, pair.second).at(frames, near)[0] - pair.limit
        found[pair.subject] = min(float(np.min(room)), found.get(pair.subject, np.inf))
    return found


def ball_room(pair: Pair, frames: JointFrames) -> np.ndarray:
    """A bound (m,) on the room of a pair by the balls about both bodies, m."""
    if pair.second.shape.kind == "halfspace":
        return np.full(frames.position.shape[1], -np.inf)
    first, second = (
        frames.position[body.joint] + frames.rotation[body.joint] @ body.centre for body in (pair.first, pair.second)
    )
    return np.linalg.norm(first - second, axis=1) - pair.first.radius - pair.second.radius - pair.limit
