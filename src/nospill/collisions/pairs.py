"""Pairs of bodies that must keep apart, and those left out, each with its reason.

Whether two parts of the arm touch by construction is not stated by hand: they do where they touch in nearly every one
of some hundred configurations drawn over the joints' ranges, or in the home of the arm, in which it is known to stand.
That is about the arm alone: tray and cargo keep apart from every part of the arm that they move against. `pair_table`
shows every pair of parts of the arm with its share.

Capsules that are estimated reach farther than the arm, or less far: with them two bodies may touch by a quarter of the
radius of each such capsule (record 0061).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from typing import Any

import numpy as np

from nospill.collisions.bodies import HOLDER, Body, region_bodies, scene_bodies
from nospill.collisions.capsule_distances import capsule_distances
from nospill.robots.capsules import are_estimated
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from nospill.robots.robot import Robot
from nospill.scene.scene import Scene

BY_CONSTRUCTION = 0.9
"""Share of the sampled configurations in which a pair touches, from which on it is left out."""
SAMPLES = 200
_SEED = 0
AT_HOME = "they touch in the home of the arm"
"""Why a pair is not judged that does not touch in nearly all configurations."""
_OF_RADIUS = 0.25
"""Part of an estimated capsule's radius by which it may be entered."""


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """Two bodies that must keep apart.

    Attributes:
        first: moves.
        second: moves otherwise, or stands still.
        limit: least distance, m; negative where capsules that are estimated may overlap by so much.
    """

    first: Body
    second: Body
    limit: float

    @property
    def subject(self) -> str:
        """As rows name it."""
        return f"{self.first.name} to {self.second.name}"

    @property
    def of_arm(self) -> bool:
        """Whether it is of the arm with itself or with what it carries."""
        return self.second.obstacle is None

    @property
    def note(self) -> str:
        """What the distance rests on in addition to the numbers of the scenario, in words; empty where on nothing."""
        off = max(self.first.place_tolerance, self.second.place_tolerance)
        notes = [f"position +-{1e3 * off:.4g} mm"] if off else []
        return ", ".join([*notes, "estimated capsules"] if self.limit < 0.0 else notes)


@dataclass(frozen=True, slots=True)
class SampledPair:
    """Two parts of the arm: links, or a link and the holder of the tray.

    Attributes:
        first: name.
        second: name.
        touching: share of the sampled configurations in which they touch.
        at_home: whether they touch in the arm's home.
    """

    first: str
    second: str
    touching: float
    at_home: bool

    @property
    def by_construction(self) -> bool:
        """Whether they touch in nearly every configuration."""
        return self.touching >= BY_CONSTRUCTION

    @property
    def judged(self) -> bool:
        """Whether they must keep apart."""
        return not (self.by_construction or self.at_home)

    @property
    def reason(self) -> str:
        """Why they are not judged; empty where they are."""
        if self.by_construction:
            return f"they touch in {100 * self.touching:.0f} % of all configurations"
        return AT_HOME if self.at_home else ""


@dataclass(frozen=True, slots=True)
class SelfCollision:
    """What a certificate says of the arm with itself and what it carries.

    Attributes:
        on: whether it is judged; the scenario may switch it off.
        judged: number of pairs, by name, that must keep apart.
        unjudged: pairs that move against each other and are left out, with the reason.
        estimated: whether the capsules of the arm are.
    """

    on: bool
    judged: int
    unjudged: tuple[tuple[str, str], ...]
    estimated: bool

    def to_dict(self) -> dict[str, object]:
        """For certificate.json and summary.json: on, judged, unjudged (pair and reason), estimated."""
        unjudged = [{"pair": pair, "reason": reason} for pair, reason in self.unjudged]
        return {"on": self.on, "judged": self.judged, "unjudged": unjudged, "estimated": self.estimated}

    @classmethod
    def from_dict(cls, table: Mapping[str, Any]) -> SelfCollision:
        """What `to_dict` gave."""
        unjudged = tuple((str(item["pair"]), str(item["reason"])) for item in table["unjudged"])
        return cls(bool(table["on"]), int(table["judged"]), unjudged, bool(table["estimated"]))

    @property
    def text(self) -> str:
        """In one line."""
        if not self.on:
            return "self-collision: not judged (switched off)"
        at_home = [pair for pair, reason in self.unjudged if reason == AT_HOME]
        always = len(self.unjudged) - len(at_home)
        parts = [
            f"{self.judged} pairs judged",
            *([f"{always} left out that touch by construction"] if always else []),
            *([f"left out because {AT_HOME}: {', '.join(at_home)}"] if at_home else []),
            *(["the capsules are estimated"] if self.estimated else []),
        ]
        return f"self-collision: {', '.join(parts)}"


def scene_pairs(scene: Scene, *, loaded: bool = True) -> tuple[Pair, ...]:
    """The pairs that are judged.

    Everything that moves with every obstacle; tray and cargo, as one, with what is beyond each side of every region;
    the arm with itself and its load.
    """
    return _pairs(scene, loaded)


def pair_table(scene: Scene) -> tuple[SampledPair, ...]:
    """Every pair of parts of the arm that move against each other, by name."""
    return tuple(_table(scene).values())


def self_collision(scene: Scene) -> SelfCollision:
    """Which pairs of the arm with itself and what it carries are judged, and which are not."""
    estimated = are_estimated(scene.robot)
    if not scene.robot.self_collision:
        return SelfCollision(False, 0, (), estimated)
    judged = {pair.subject for pair in scene_pairs(scene) if pair.of_arm}
    unjudged = [(f"{row.first} to {row.second}", row.reason) for row in pair_table(scene) if not row.judged]
    return SelfCollision(True, len(judged), tuple(unjudged), estimated)


@lru_cache(maxsize=8)
def _pairs(scene: Scene, loaded: bool) -> tuple[Pair, ...]:
    bodies = _bodies(scene, loaded)
    moving = [body for body in bodies if body.obstacle is None]
    around = [
        Pair(body, item, item.obstacle.clearance)
        for item in bodies
        if item.obstacle is not None
        for body in moving
        if body.joint
    ]
    if scene.regions:
        load, sides = region_bodies(scene, loaded=loaded)
        around += [Pair(load, item, 0.0) for item in sides]
    if not scene.robot.self_collision:
        return tuple(around)
    table = _table(scene)
    may_enter = _OF_RADIUS if are_estimated(scene.robot) else 0.0
    against = []
    for first, second in combinations(moving, 2):
        if first.joint == second.joint or (second.of_arm and not table[second.name, first.name].judged):
            continue
        depth = may_enter * sum(body.shape.ball for body in (first, second) if body.of_arm and body.name != HOLDER)
        against.append(Pair(second, first, -depth))
    return (*around, *against)


@lru_cache(maxsize=8)
def _bodies(scene: Scene, loaded: bool) -> tuple[Body, ...]:
    return scene_bodies(scene, loaded=loaded)


@lru_cache(maxsize=8)
def _table(scene: Scene) -> Mapping[tuple[str, str], SampledPair]:
    """Links and holder, each a capsule or more, against each other."""
    return _sampled_pairs(scene.robot, [body for body in _bodies(scene, True) if body.of_arm])


def _sampled_pairs(robot: Robot, parts: Sequence[Body]) -> Mapping[tuple[str, str], SampledPair]:
    """By both names. Bodies of one link belong together: the one that touches most speaks for all."""
    shapes = tuple((body.name, body.joint, body.shape.ball, *body.points.ravel().tolist()) for body in parts)
    ranges = tuple(part.tobytes() for part in (robot.lower, robot.upper, robot.home) if part is not None)
    key = (robot.urdf, robot.joints, robot.tip, shapes, ranges)
    if key not in _KNOWN:
        if len(_KNOWN) >= _MOST_KNOWN:
            _KNOWN.clear()
        _KNOWN[key] = _sample_pairs(robot, parts)
    return _KNOWN[key]


_KNOWN: dict[object, Mapping[tuple[str, str], SampledPair]] = {}
_MOST_KNOWN = 16
"""Arms whose table is kept."""


def _sample_pairs(robot: Robot, parts: Sequence[Body]) -> dict[tuple[str, str], SampledPair]:
    generator = np.random.default_rng(_SEED)
    q = generator.uniform(robot.lower, robot.upper, (SAMPLES, len(robot.joints)))
    if robot.home is not None:
        q = np.concatenate([q, robot.home[None]])
    pairs = [(second, first) for first, second in combinations(parts, 2) if first.joint != second.joint]
    frames = joint_frames(arm_chain(robot), q)
    touching: dict[tuple[str, str], np.ndarray] = {}
    for (first, second), distances in zip(pairs, capsule_distances(pairs, frames), strict=True):
        names = first.name, second.name
        touching[names] = touching.get(names, False) | (distances < 0.0)
    return {
        names: SampledPair(*names, float(np.mean(touches[:SAMPLES])), bool(np.any(touches[SAMPLES:])))
        for names, touches in touching.items()
    }
