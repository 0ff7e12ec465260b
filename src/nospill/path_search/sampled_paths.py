"""Ways of the level tray from one place to another by sampling: RRT-Connect, seeds fixed.

A node is a configuration of the arm with a level tray; how the arm gets from one to the next is up to `level_arm`.
Trees grow from every branch at the start and every branch at the goal at once. A way that passes places is searched
from each to the next, the tray turned anyhow there.

Source: Kuffner, LaValle, "RRT-Connect: an efficient approach to single-query path planning", ICRA 2000.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from nospill.path_search.level_arm import METRIC, LevelArm
from nospill.path_search.over_the_base import pose_beyond
from nospill.robots.description.urdf import base_pose
from nospill.robots.kinematics.closed_form import TURN

_SAME = 1e-3
"""rad; configurations that are nearer to each other are one."""
_BETWEEN = 0.5
"""Share of the samples that are drawn from around start and goal; the others from all that the arm reaches."""
_AROUND = 0.4
"""How far around, in parts of the arm's reach."""
_TO_ROOTS = 0.1
"""Share of the samples that are roots of the other tree."""
_OVER = 0.1
"""Share of the steps that lead over the base, where they may."""
_TRIES = 12
"""Positions of the redundant joint that are tried for each pose that is drawn."""
_NEAR_STATED = 1e-3
"""rad; a configuration that is nearer to a stated one is that, as the closed form finds it."""
_EVERY = 6
"""Looks from node to node of a tree."""
_SPEED = 1.0
"""m/s; a metre between trays counts as so much time of the joints."""
_YAWS = 8
"""Turns of the tray at a place on the way, evenly all round from that between start and goal."""
_SHORTER = 0.99
"""Part of its time that a straight piece may take at most to take the place of another one."""


@dataclass(frozen=True, slots=True)
class SampledPath:
    """A way on which the arm, its level tray and its cargo are clear.

    Attributes:
        poses: (m, 4) of the tray at the looks along it, x, y, z, yaw; m and rad.
        q: (m, n) of the joints there, rad, but for whole turns.
    """

    poses: np.ndarray
    q: np.ndarray


class _Tree:
    """Configurations that are joined to the start, or to the goal."""

    def __init__(self, poses: np.ndarray, q: np.ndarray) -> None:
        self.poses, self.q, self.parents, self.roots = poses, q, [-1] * len(q), len(q)

    def add(self, poses: np.ndarray, q: np.ndarray, parent: int) -> int:
        """Add nodes one after the other, the first after a parent; return the number of the last."""
        count = len(self.q)
        self.parents += [parent, *range(count, count + len(q) - 1)]
        self.poses, self.q = np.concatenate([self.poses, poses]), np.concatenate([self.q, q])
        return len(self.q) - 1

    def back(self, number: int) -> list[int]:
        """A node and those before it, back to the root."""
        found = []
        while number >= 0:
            found.append(number)
            number = self.parents[number]
        return found


class _Draws:
    """Random clear configurations: around start and goal, and in all that the arm reaches."""

    def __init__(self, arm: LevelArm, random: np.random.Generator, ends: np.ndarray) -> None:
        self._arm, self._random = arm, random
        foot, _ = base_pose(arm.robot.urdf)
        reach = arm.robot.reach or 1.0
        around = _AROUND * reach
        turns = [np.min(ends[:, 3]) - np.pi, np.max(ends[:, 3]) + np.pi]
        self._boxes = [
            (np.append(low, turns[0]), np.append(high, turns[1]))
            for low, high in (
                (ends[:, :3].min(axis=0) - around, ends[:, :3].max(axis=0) + around),
                (foot - reach, foot + reach),
            )
        ]

    def __call__(self) -> tuple[np.ndarray, np.ndarray] | None:
        """A pose and a configuration, the redundant joint anywhere; None for a draw in vain."""
        low, high = self._boxes[int(self._random.random() >= _BETWEEN)]
        pose = self._random.uniform(low, high)
        # few positions of a redundant joint let an arm hold a level tray at a given pose
        tries = self._random.choice(self._arm.held, min(_TRIES, len(self._arm.held)))
        solutions = next(
            (some for some in self._arm.solutions(np.tile(pose, (len(tries), 1)), tries) if len(some)), None
        )
        if solutions is None:
            return None
        q = solutions[int(self._random.integers(len(solutions)))]
        return (pose, q) if self._arm.clear(pose[None], q[None])[0] else None


def sample_path(arm: LevelArm, *, seed: int, samples: int, over: np.ndarray | None = None) -> list[SampledPath] | None:
    """A way from the start of a scene's path to its end, not shortened; None where none is found.

    Args:
        arm: in its scene.
        seed: of the random numbers.
        samples: poses that are drawn from one place to the next before it gives up.
        over: axis (2,) of the base over which the tray may pass, m; None where it may not (see `over_the_base`).

    Returns:
        From the start to the first place on the way, from there to the next and so on, each from the configuration in
        which the one before ends.
    """
    random, legs = np.random.default_rng(seed), list[SampledPath]()
    start, goal = arm.ends
    first, last = arm.scene.path.ends
    here = _root_tree(arm, start[None], first)
    turned = np.array([0.0, TURN, -TURN])[:, None] * [0, 0, 0, 1]
    for number, place in enumerate(arm.scene.motion.via, start=1):
        yaw = start[3] + (goal[3] - start[3]) * number / (len(arm.scene.motion.via) + 1)
        poses = np.array([[*place.position, yaw + turn] for turn in np.linspace(0.0, TURN, _YAWS, endpoint=False)])
        leg = _connect(arm, random, here, _root_tree(arm, poses), samples, over)
        if leg is None:
            return None
        legs.append(leg)
        here = _Tree(leg.poses[-1:], leg.q[-1:])
    leg = _connect(arm, random, here, _root_tree(arm, goal + turned, last), samples, over)
    return None if leg is None else [*legs, leg]


def _connect(
    arm: LevelArm, random: np.random.Generator, start: _Tree, goal: _Tree, samples: int, over: np.ndarray | None
) -> SampledPath | None:
    """A way from a root of a tree to one of another."""
    roots = start, goal
    if not all(tree.roots for tree in roots):
        return None
    draw = _Draws(arm, random, np.array([start.poses[0], goal.poses[0]]))
    for number in range(samples):
        here, there = roots if number % 2 == 0 else roots[::-1]
        if over is not None and random.random() < _OVER:
            tip = _grow_over(arm, here, over, random)
        else:
            if random.random() < _TO_ROOTS:
                root = int(random.integers(there.roots))
                target = there.poses[root], there.q[root]
            else:
                target = draw()
            tip = None if target is None else _grow(arm, here, *target)
        if tip is None:
            continue
        other = _grow(arm, there, here.poses[tip], here.q[tip])
        if other is not None and np.abs(arm.apart(there.q[other], here.q[tip])).max() < _SAME:
            ways = [tree.back(node) for tree, node in ((here, tip), (there, other))]
            nodes = [(here, node) for node in ways[0][::-1]] + [(there, node) for node in ways[1][1:]]
            nodes = nodes if here is roots[0] else nodes[::-1]
            connection = _check_looks(arm, [(tree.poses[node], tree.q[node]) for tree, node in nodes])
            if connection is not None:
                return connection
    return None


def _check_looks(arm: LevelArm, nodes: list[tuple[np.ndarray, np.ndarray]]) -> SampledPath | None:
    """The way through some nodes with every look between them; None where it is another one in this direction."""
    poses, q = [nodes[0][0][None]], [nodes[0][1][None]]
    for pose, joints in nodes[1:]:
        straight, found, there = arm.towards(poses[-1][-1], q[-1][-1], pose, joints)
        if not there or np.abs(arm.apart(found[-1], joints)).max() > _SAME:
            return None
        poses.append(straight)
        q.append(found)
    return SampledPath(np.concatenate(poses), np.concatenate(q))


def _root_tree(arm: LevelArm, poses: np.ndarray, stated: np.ndarray | None = None) -> _Tree:
    """A tree of all clear configurations at some poses (k, 4), or of the stated one (n,) there."""
    held = arm.held if stated is None else np.array([arm.held_of(stated)])
    each = np.repeat(poses, len(held), axis=0)
    choices = arm.solutions(each, np.tile(held, len(poses)))
    roots = [(pose, q) for pose, some in zip(each, choices, strict=True) for q in some]
    if stated is not None:
        roots = [(pose, q) for pose, q in roots if np.abs(arm.apart(q, stated)).max() < _NEAR_STATED]
    if not roots:
        return _Tree(np.zeros((0, 4)), np.zeros((0, len(arm.robot.joints))))
    clear = arm.clear(np.array([pose for pose, _ in roots]), np.array([q for _, q in roots]))
    kept = [item for item, free in zip(roots, clear, strict=True) if free]
    return _Tree(np.array([pose for pose, _ in kept]), np.array([q for _, q in kept]))


def _grow(arm: LevelArm, tree: _Tree, pose: np.ndarray, q: np.ndarray) -> int | None:
    """Grow a tree from its nearest node towards a configuration; return the last node, None where none is new."""
    gaps = arm.time(tree.q, q) + np.linalg.norm((tree.poses - pose) * METRIC, axis=1) / _SPEED
    nearest = int(np.argmin(gaps))
    if gaps[nearest] < _SAME:
        return nearest
    return _grow_from(arm, tree, nearest, pose, q)


def _grow_over(arm: LevelArm, tree: _Tree, axis: np.ndarray, random: np.random.Generator) -> int | None:
    """Grow a tree from any of its nodes straight over the base."""
    node = int(random.integers(len(tree.q)))
    pose = pose_beyond(tree.poses[node], axis, random)
    return None if pose is None else _grow_from(arm, tree, node, pose, tree.q[node])


def _grow_from(arm: LevelArm, tree: _Tree, node: int, pose: np.ndarray, q: np.ndarray) -> int | None:
    poses, found, _ = arm.towards(tree.poses[node], tree.q[node], pose, q)
    if not len(found):
        return None
    kept = np.unique(np.append(np.arange(_EVERY - 1, len(found), _EVERY), len(found) - 1))
    return tree.add(poses[kept], found[kept], node)


def split_after(way: SampledPath, after: np.ndarray) -> list[SampledPath]:
    """A way in legs as `joined` joins them, the stretch after each of the given looks (k,) a leg of its own."""
    last = len(way.q) - 1
    cuts = np.unique([0, *after, *(after + 1), last])
    return [SampledPath(way.poses[a : b + 1], way.q[a : b + 1]) for a, b in pairwise(cuts)]


def concatenate(legs: Sequence[SampledPath]) -> SampledPath:
    """One way of several, each of which begins where the one before ends."""
    first, *others = legs
    poses, q = [first.poses, *(leg.poses[1:] for leg in others)], [first.q, *(leg.q[1:] for leg in others)]
    return SampledPath(np.concatenate(poses), np.concatenate(q))


def shorten(arm: LevelArm, way: SampledPath, *, seed: int, tries: int) -> SampledPath:
    """The way with straight pieces in the place of longer ones, between places drawn at random."""
    random = np.random.default_rng(seed)
    poses, q = way.poses, way.q
    for _ in range(tries):
        first, last = np.sort(random.integers(len(poses), size=2))
        taken = _SHORTER * time_along(arm, q[first : last + 1])
        # no piece takes less time than its ends are apart
        if last - first < 2 or arm.time(q[first], q[last]) >= taken:
            continue
        straight, shortcut, there = arm.towards(poses[first], q[first], poses[last], q[last])
        if not there or np.abs(arm.apart(shortcut[-1], q[last])).max() > _SAME:
            continue
        if time_along(arm, np.vstack([q[first], shortcut])) < taken:
            poses = np.vstack([poses[: first + 1], straight, poses[last + 1 :]])
            q = np.vstack([q[: first + 1], shortcut, q[last + 1 :]])
    return SampledPath(poses, q)


def time_along(arm: LevelArm, q: np.ndarray) -> float:
    """Time that the slowest joint of each step needs at full speed, s, in all."""
    return float(np.sum(arm.time(q[1:], q[:-1])))
