"""How near arm, level tray and cargo come to obstacles and to each other along a joint path."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from nospill.collisions.bodies import Body
from nospill.collisions.box_bounds import ball_bounds, box_bounds
from nospill.collisions.capsule_distances import are_capsules, capsule_distances
from nospill.collisions.distances import ball_gaps, distances_of
from nospill.collisions.pairs import Pair, scene_pairs
from nospill.paths.path import Path
from nospill.robots.joint_paths.following import tray_poses
from nospill.robots.joint_paths.search import JointPath
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.frames import JointFrames, arm_chain, joint_frames
from nospill.scene.scene import Scene

_PLACES = 201
"""Places along the path at which distances are measured; the judge looks between them."""


@dataclass(frozen=True, slots=True)
class Nearness:
    """The pair of bodies that comes nearest along a joint path.

    Attributes:
        pair: both.
        slack: distance less what must be kept, m; negative where it is not kept.
        s: where on the path, 0 to 1.
    """

    pair: Pair
    slack: float
    s: float


def nearest_along(scene: Scene, joint_path: JointPath, *, places: int = _PLACES) -> Nearness:
    """The pair with the least slack along a joint path.

    Args:
        scene: with obstacles.
        joint_path: of the level tray.
        places: number of them, evenly along the path.
    """
    s = np.linspace(0.0, 1.0, places)
    return _nearest(scene_pairs(scene), joint_frames(arm_chain(scene.robot), joint_path.at(s)), s)


def nearest_of_tray(scene: Scene, path: Path, *, places: int = _PLACES) -> Nearness:
    """The pair with the least slack of level tray and cargo with obstacles, which the path alone decides.

    Args:
        scene: with obstacles.
        path: of the tray.
        places: number of them, evenly along the path.
    """
    s = np.linspace(0.0, 1.0, places)
    pairs = [pair for pair in scene_pairs(scene) if pair.first.on_path and pair.second.obstacle is not None]
    return _nearest(pairs, _frames_on_path(scene, path, s), s)


def _frames_on_path(scene: Scene, path: Path, s: np.ndarray) -> JointFrames:
    """The frames of base and last joint where a path leads the level tray; those of the others are the base's."""
    robot = scene.robot
    zero = np.zeros((1, len(robot.joints)))
    tray, turn = kinematics(robot).poses(zero, tool=scene.tray.tool)
    last = joint_frames(arm_chain(robot), zero)
    # of the last joint as the tray sees it
    offset, turned = (last.position[-1, 0] - tray[0]) @ turn[0], turn[0].T @ last.rotation[-1, 0]
    at, rotation = tray_poses(path, s)
    positions, rotations = (
        np.zeros((len(last.position), len(s), 3)),
        np.tile(np.eye(3), (len(last.position), len(s), 1, 1)),
    )
    positions[-1], rotations[-1] = at + rotation @ offset, rotation @ turned
    still = np.zeros_like(positions)
    return JointFrames(positions, rotations, still, still)


def _nearest(pairs: Sequence[Pair], frames: JointFrames, s: np.ndarray) -> Nearness:
    places = len(s)
    worst: Nearness | None = None
    known = slack_bounds(pairs, frames)
    for index in np.argsort(known.min(axis=1), kind="stable"):
        pair, bounds = pairs[int(index)], known[index]
        where = np.arange(places) if worst is None else np.flatnonzero(bounds < worst.slack)
        if not len(where):
            continue
        slack = distances_of(pair.first, pair.second).at(frames, where)[0] - pair.limit
        least = int(np.argmin(slack))
        if worst is None or slack[least] < worst.slack:
            worst = Nearness(pair, float(slack[least]), float(s[where[least]]))
    assert worst is not None  # there is a tray, and an obstacle
    return worst


def least_slack(scene: Scene, q: np.ndarray, *, within: float) -> dict[str, float]:
    """Distance less what must be kept, m, the least over joint positions (m, n), rad, by the subjects of the pairs.

    Where it is above `within`, m, or above zero of the arm with itself and its load, it is a bound.
    """
    frames, least = joint_frames(arm_chain(scene.robot), q), dict[str, float]()
    pairs = scene_pairs(scene)
    for pair, slack in zip(pairs, slack_bounds(pairs, frames, enough=max(within, 0.0)), strict=True):
        # of the arm with itself and its load only what is broken counts: bounds do until then
        near = np.flatnonzero(slack < (0.0 if pair.of_arm else within))
        if len(near) and not are_capsules(pair.first, pair.second):
            slack[near] = distances_of(pair.first, pair.second).at(frames, near)[0] - pair.limit
        least[pair.subject] = min(float(np.min(slack)), least.get(pair.subject, np.inf))
    return least


def freest_of_arm(scene: Scene, q: np.ndarray, s: float) -> Nearness | None:
    """What comes nearest in that configuration in which the slack is largest; None where no pair is judged.

    Where it is above zero, some bound on the slack; the configuration is then clear.

    Of the arm with itself, its load and the obstacles; of tray and cargo with obstacles the path decides, not the arm.

    Args:
        scene: the task.
        q: (m, n) configurations, one at least, rad.
        s: where on the path they are.
    """
    pairs = [pair for pair in scene_pairs(scene) if pair.of_arm or not pair.first.on_path]
    if not pairs:
        return None
    frames = joint_frames(arm_chain(scene.robot), q)
    slacks = slack_bounds(pairs, frames, enough=0.0)
    for pair, slack in zip(pairs, slacks, strict=True):
        near = np.flatnonzero(slack < 0.0)
        if len(near) and not are_capsules(pair.first, pair.second):
            slack[near] = distances_of(pair.first, pair.second).at(frames, near)[0] - pair.limit
    worst = np.argmin(slacks, axis=0)
    least = slacks[worst, np.arange(len(q))]
    best = int(np.argmax(least))
    return Nearness(pairs[int(worst[best])], float(least[best]), s)


def slack_bounds(pairs: Sequence[Pair], frames: JointFrames, *, enough: float = np.inf) -> np.ndarray:
    """Bounds (k, m) on the slack of pairs, m: of two capsules the slack itself.

    Of what the arm carries and a link, by the box about the one; of others by the balls about both.

    Args:
        pairs: k of them.
        frames: of the arm at m configurations.
        enough: slack, m, from which on the balls about both do for every pair.
    """
    if not pairs:
        return np.zeros((0, frames.position.shape[1]))
    bodies, limits = [(pair.first, pair.second) for pair in pairs], np.array([[pair.limit] for pair in pairs])
    found = ball_gaps(bodies, frames) - limits

    def near(chosen: Iterable[int]) -> tuple[list[int], list[tuple[Body, Body]]]:
        indices = [index for index in chosen if enough == np.inf or np.min(found[index], initial=np.inf) < enough]
        return indices, [bodies[index] for index in indices]

    capsules, own = near(index for index, pair in enumerate(bodies) if are_capsules(*pair))
    found[capsules] = capsule_distances(own, frames) - limits[capsules]
    carried, own = near(index for index, pair in enumerate(pairs) if pair.of_arm and not are_capsules(*bodies[index]))
    found[carried] = np.maximum(found[carried], ball_bounds(own, frames) - limits[carried])
    carried, own = near(carried)
    found[carried] = np.maximum(found[carried], box_bounds(own, frames)[0] - limits[carried])
    return found
