"""Pairs of bodies that must keep apart, and those left out because they touch by construction.

Whether two bodies of the arm touch by construction is not stated by hand: they do where they touch in nearly every one
of some hundred configurations drawn over the joints' ranges, or in the home of the arm, in which it is known to stand.
`pair_table` shows every pair with its share.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np

from nospill.collisions.bodies import Body, region_bodies, scene_bodies
from nospill.collisions.distances import Distances, ball_gap
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from nospill.scene.scene import Scene

BY_CONSTRUCTION = 0.9
"""Share of the sampled configurations in which a pair touches, from which on it is left out."""
SAMPLES = 200
_SEED = 0


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """Two bodies that must keep apart.

    Attributes:
        first: moves.
        second: moves otherwise, or stands still.
        limit: least distance, m.
    """

    first: Body
    second: Body
    limit: float

    @property
    def subject(self) -> str:
        """As rows name it."""
        return f"{self.first.name} to {self.second.name}"

    @property
    def place_tolerance(self) -> str:
        """In words, how far the objects may be off their places, which the distance includes; empty where not."""
        off = max(self.first.place_tolerance, self.second.place_tolerance)
        return f"position +-{1e3 * off:.4g} mm" if off else ""


@dataclass(frozen=True, slots=True)
class SampledPair:
    """Two bodies of the arm with its load.

    Attributes:
        first: name.
        second: name.
        touching: share of the sampled configurations in which they touch.
        at_home: whether they touch in the arm's home.
        judged: whether they have a row.
    """

    first: str
    second: str
    touching: float
    at_home: bool
    judged: bool


def scene_pairs(scene: Scene, *, loaded: bool = True) -> tuple[Pair, ...]:
    """The pairs that are judged.

    Tray and cargo, as one, with what is beside each side of every region; where there are obstacles, everything that
    moves with each of them, and the arm with itself and its load.
    """
    return _pairs(scene, loaded)[0]


def pair_table(scene: Scene) -> tuple[SampledPair, ...]:
    """Every pair of bodies of the arm and its load that move against each other, by name."""
    return _pairs(scene, True)[1]


@lru_cache(maxsize=8)
def _pairs(scene: Scene, loaded: bool) -> tuple[tuple[Pair, ...], tuple[SampledPair, ...]]:
    bodies = scene_bodies(scene, loaded=loaded)
    own = [body for body in bodies if body.obstacle is None]
    around = [
        Pair(body, item, item.obstacle.clearance)
        for item in bodies
        if item.obstacle is not None
        for body in own
        if body.joint
    ]
    load, sides = region_bodies(scene, loaded=loaded)
    around += [Pair(load, item, 0.0) for item in sides]
    if not scene.obstacles:
        return tuple(around), ()
    against = [Pair(second, first, 0.0) for first, second in combinations(own, 2) if first.joint != second.joint]
    table = _sampled(scene, against)
    kept = [pair for pair in against if table[pair.subject].judged]
    return (*around, *kept), tuple(table.values())


def _sampled(scene: Scene, pairs: Sequence[Pair]) -> dict[str, SampledPair]:
    """By subject. Bodies of one link belong together: the one that touches most speaks for all."""
    robot, generator = scene.robot, np.random.default_rng(_SEED)
    q = generator.uniform(robot.lower, robot.upper, (SAMPLES, len(robot.joints)))
    if robot.home is not None:
        q = np.concatenate([q, robot.home[None]])
    frames = joint_frames(arm_chain(robot), q)
    touching: dict[str, np.ndarray] = {}
    for pair in pairs:
        near = np.flatnonzero(ball_gap(pair.first, pair.second, frames) < 0.0)
        own = touching.setdefault(pair.subject, np.zeros(len(q), dtype=bool))
        own[near] |= Distances(pair.first, pair.second).at(frames, near)[0] < 0.0
    found = {}
    for pair in pairs:
        own = touching[pair.subject]
        share, at_home = float(np.mean(own[:SAMPLES])), bool(np.any(own[SAMPLES:]))
        judged = share < BY_CONSTRUCTION and not at_home
        found[pair.subject] = SampledPair(pair.first.name, pair.second.name, share, at_home, judged)
    return found
