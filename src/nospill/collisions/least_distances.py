"""The least distance of pairs of bodies along a motion, as a bound that holds between the samples too.

At a sample t_c let n separate two bodies by d(tau) when every point moves on at its speed for a time tau. The signed
distance is at least how far any direction separates, and a point is off its straight way by at most a tau^2 / 2, so

    distance(t_c + tau) >= d(tau) - (a_1 + a_2) tau^2 / 2,      |tau| <= T,

with a_i bounds on the accelerations of the points over that time. Points move linearly in tau and a support function
is convex in them: d is concave, and least at tau = -T or T. This bound is of second order in T: half a millimetre over
10 ms for a point that brakes at 1 g.

The time is cut into blocks, each with a sample near its middle. Where the bound says less than what is asked for, the
block is cut in two, down to half a step before and after a single sample (branch and bound). Balls about the bodies,
with the same bound, spare most pairs and blocks the search for n.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nospill.collisions.bodies import Body
from nospill.collisions.box_bounds import box_bounds
from nospill.collisions.capsule_distances import CapsuleDistances, are_capsules, capsules_apart
from nospill.collisions.distances import Distances, distances_of, separation
from nospill.collisions.motion_bounds import SampledMotion
from nospill.collisions.pairs import Pair
from nospill.core.arrays import cross
from nospill.robots.kinematics.frames import JointFrames, axis_reach, joint_frames

_BLOCK = 128
"""Samples in a block at first."""
_SHARED = 8
"""Size of blocks from which on all frames are found at once."""
_EXACT, _SHARE = 1e-4, 0.1
"""How far a stated distance may lie below the true one: m, or a part of what it is above its limit; never below that
limit where the true one is above it, but for the last half step."""


@dataclass(frozen=True, slots=True)
class LeastDistance:
    """The least distance of a pair along a motion.

    Attributes:
        pair: the two bodies.
        distance: that they keep at all times at least, m; negative where they may overlap.
        at: of a sample near which they are nearest, s.
    """

    pair: Pair
    distance: float
    at: float


def least_distances(
    motion: SampledMotion, pairs: Sequence[Pair], *, beyond: float = np.inf
) -> tuple[LeastDistance, ...]:
    """Of every subject among pairs the distance that leaves the least slack, in the order of their first ones.

    Args:
        motion: of the arm.
        pairs: with the distance that each must keep.
        beyond: distance, m, from which on nothing is looked at more closely: one above it is some bound on the least.
    """
    subjects: dict[str, list[Pair]] = {}
    for pair in pairs:
        subjects.setdefault(pair.subject, []).append(pair)
    if not subjects:
        return ()
    search = _Search(motion, pairs, beyond)
    nearest = [(group, *search.least_of(group)) for group in subjects.values()]
    return tuple(LeastDistance(group[number], distance, at) for group, number, distance, at in nearest)


class _Blocks:
    """One partition of the samples: the middle sample of each block, the time to its ends, and bounds over it.

    Attributes:
        middle: (k,) index of a sample.
        time: (k,) from it to the farther end of its block, s.
        drift: (k, b) how far points of each body may leave their straight ways by then, m.
    """

    def __init__(self, motion: SampledMotion, around: np.ndarray, size: int) -> None:
        starts = np.arange(0, len(motion.t), size)
        ends = np.minimum(starts + size, len(motion.t))
        self._motion = motion
        self.middle = (starts + ends - 1) // 2
        self.time = (np.maximum(self.middle - starts, ends - 1 - self.middle) + 0.5) * motion.step
        self.drift = 0.5 * np.maximum.reduceat(around, starts, axis=0) * self.time[:, None] ** 2
        self._all = self._of(self.middle) if size >= _SHARED else None

    def frames(self, chosen: np.ndarray) -> tuple[JointFrames, np.ndarray]:
        """Frames of the arm, and where among them the middles of some blocks are."""
        if self._all is not None:
            return self._all, chosen
        return self._of(self.middle[chosen]), np.arange(len(chosen))

    def _of(self, samples: np.ndarray) -> JointFrames:
        return joint_frames(self._motion.chain, self._motion.q[samples], self._motion.qd[samples])


class _Search:
    """What the pairs share: bounds on accelerations, and the partitions of the samples, finer and finer."""

    def __init__(self, motion: SampledMotion, pairs: Sequence[Pair], beyond: float) -> None:
        self.motion, self.pairs, self.beyond = motion, pairs, beyond
        bodies: dict[Body, int] = {}
        for pair in pairs:
            for body in (pair.first, pair.second):
                bodies.setdefault(body, len(bodies))
        self.number = bodies
        reach = [
            axis_reach(motion.chain, body.joint, body.points, float(np.max(body.shape.discs, initial=0.0)))
            for body in bodies
        ]
        self.around = motion.around_samples(np.array(reach).T)
        self.partitions: dict[int, _Blocks] = {}
        first = self.blocks(_BLOCK)
        frames, _ = first.frames(np.arange(len(first.middle)))
        self.low = dict(zip(pairs, self._of_balls(frames, first), strict=True))
        self.middle: dict[Pair, np.ndarray] = {}
        if beyond < np.inf:
            self._look_at_the_near(frames, first)

    def _look_at_the_near(self, frames: JointFrames, first: _Blocks) -> None:
        """Better bounds over the first blocks, from directions found for many pairs at once.

        Two capsules are nearest in closed form; of what the arm carries it is the box about it that is near a link.
        """
        near = [pair for pair in self.pairs if float(np.min(self.low[pair])) < self.beyond]
        capsules = [pair for pair in near if are_capsules(pair.first, pair.second)]
        carried = [pair for pair in near if pair.of_arm and pair.first.on_path]
        distances, between = capsules_apart([(pair.first, pair.second) for pair in capsules], frames)
        _, away = box_bounds([(pair.first, pair.second) for pair in carried], frames)
        self.middle = dict(zip(capsules, distances, strict=True))
        every = np.arange(len(first.middle))
        for pair, directions in zip([*capsules, *carried], [*between, *away], strict=True):
            self.low[pair] = np.maximum(self.low[pair], self._of_directions(pair, first, every, directions))

    def blocks(self, size: int) -> _Blocks:
        """The partition in blocks of so many samples."""
        if size not in self.partitions:
            self.partitions[size] = _Blocks(self.motion, self.around, size)
        return self.partitions[size]

    def least_of(self, pairs: Sequence[Pair]) -> tuple[int, float, float]:
        """Of some pairs the one with the least slack above its limit: its number, its distance, m, and where, s."""
        number, (least, at) = 0, self._least(pairs[0], np.inf)
        for own, pair in enumerate(pairs[1:], start=1):
            lower = pair.limit - pairs[number].limit
            distance, when = self._least(pair, least + lower)
            if distance < least + lower:
                number, least, at = own, distance, when
        return number, least, at

    def _least(self, pair: Pair, known: float) -> tuple[float, float]:
        """The least distance of one pair, m, and where, s: of those measured and of all bounds that were enough.

        Where it cannot be below a known distance, m, it is some distance that is not below it either.
        """
        size, blocks = _BLOCK, self.blocks(_BLOCK)
        low = self.low[pair]
        if float(np.min(low)) >= min(known, self.beyond):
            return float(np.min(low)), float(self.motion.t[int(np.argmin(low)) * _BLOCK])
        measure = distances_of(pair.first, pair.second)
        # the most promising block first: what it has spares most of the others
        nearest = int(np.argmin(low))
        distance, _ = self._measured(pair, measure, blocks, np.array([nearest]))
        best, at = float(distance[0]), int(blocks.middle[nearest])
        far = low >= self._enough(best, pair.limit)
        bound = float(np.min(low[far], initial=np.inf))
        chosen = np.flatnonzero(~far)
        while len(chosen):
            distance, low = self._measured(pair, measure, blocks, chosen)
            nearest = int(np.argmin(distance))
            if distance[nearest] < best:
                best, at = float(distance[nearest]), int(blocks.middle[chosen[nearest]])
            done = (low >= self._enough(best, pair.limit)) | (size == 1)
            bound = float(np.min(low[done], initial=bound))
            size //= 2
            halves = np.concatenate([2 * chosen[~done], 2 * chosen[~done] + 1])
            if not len(halves):
                break
            blocks = self.blocks(size)
            chosen = halves[halves < len(blocks.middle)]
        return min(bound, best), float(self.motion.t[at])

    def _measured(
        self, pair: Pair, measure: Distances | CapsuleDistances, blocks: _Blocks, chosen: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Distances (k,) in the middle of some blocks, and bounds (k,) over the whole of each, m."""
        if pair in self.middle and blocks is self.partitions[_BLOCK]:
            return self.middle[pair][chosen], self.low[pair][chosen]
        frames, places = blocks.frames(chosen)
        distance, directions = measure.at(frames, places)
        return distance, self._of_directions(pair, blocks, chosen, directions)

    def _of_directions(self, pair: Pair, blocks: _Blocks, chosen: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Bounds (k,) over the whole of some blocks, m, by a direction (k, 3) for each that separates the bodies."""
        frames, places = blocks.frames(chosen)
        time, both = blocks.time[chosen], np.concatenate([places, places])
        ends = np.concatenate([-time, time])
        bounds = separation(pair.first, pair.second, frames, both, np.concatenate([directions, directions]), ends)
        return np.min(bounds.reshape(2, -1), axis=0) - self._drift(pair, blocks)[chosen]

    def _of_balls(self, frames: JointFrames, blocks: _Blocks) -> np.ndarray:
        """Bounds (p, k) of all pairs over the first blocks by the balls about the bodies, m."""
        balls = [_ball(body, frames) for body in self.number]
        centre, speed = (np.array([ball[part] for ball in balls]) for part in (0, 1))
        first = np.array([self.number[pair.first] for pair in self.pairs])
        second = np.array([self.number[pair.second] for pair in self.pairs])
        gap = centre[second] - centre[first]
        direction = gap / np.maximum(np.linalg.norm(gap, axis=2, keepdims=True), 1e-12)
        radii = np.array([pair.first.radius + pair.second.radius for pair in self.pairs])
        for index, pair in enumerate(self.pairs):
            if pair.second.shape.kind == "halfspace":
                direction[index], radii[index] = -pair.second.rotation[:, 2], pair.first.radius
        apart = np.sum(direction * gap, axis=2)
        closing = np.abs(np.sum(direction * (speed[second] - speed[first]), axis=2)) * blocks.time
        drift = blocks.drift[:, first] + blocks.drift[:, second]
        return apart - radii[:, None] - closing - drift.T

    def _drift(self, pair: Pair, blocks: _Blocks) -> np.ndarray:
        return blocks.drift[:, self.number[pair.first]] + blocks.drift[:, self.number[pair.second]]

    def _enough(self, best: float, limit: float) -> float:
        """Bound from which on a block needs no closer look, where the least distance found is `best`."""
        left = best - limit
        # of what is left, that it may be told from nothing
        loose = max(min(_EXACT, 0.5 * left), _SHARE * left) if left > 0.0 else _EXACT
        return min(best - loose, self.beyond)


def _ball(body: Body, frames: JointFrames) -> tuple[np.ndarray, np.ndarray]:
    """Centre (k, 3), m, and its velocity (k, 3), m/s, of the ball about a body."""
    arm = frames.rotation[body.joint] @ body.centre
    speed = frames.velocity[body.joint] + cross(frames.angular_velocity[body.joint], arm)
    return frames.position[body.joint] + arm, speed
