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

from collections.abc import Generator, Sequence
from dataclasses import dataclass, fields

import numpy as np

from nospill.collisions.bodies import Body
from nospill.collisions.box_bounds import box_bounds
from nospill.collisions.capsule_distances import capsules_apart, capsules_at
from nospill.collisions.distances import Distances, distances_by_coal
from nospill.collisions.motion_bounds import SampledMotion
from nospill.collisions.pair_arrays import PairArrays
from nospill.collisions.pairs import Pair
from nospill.collisions.supports import separations
from nospill.robots.kinematics.frames import JointFrames, joint_frames

_Question = tuple[int, int, np.ndarray]
"""Number of a pair, size of its blocks, and which (k,) of them."""
_Answer = tuple[np.ndarray, np.ndarray]
"""Distances (k,) in the middle of these blocks, and bounds (k,) over the whole of each, m."""

_BLOCK = 128
"""Samples in a block at first."""
_SHARED = 8
"""Size of blocks from which on the frames at all middles are found at once."""
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


def least_distances(motion: SampledMotion, pairs: PairArrays, *, beyond: float = np.inf) -> tuple[LeastDistance, ...]:
    """Of every subject among pairs the distance that leaves the least slack, in the order of their first ones.

    Args:
        motion: of the arm.
        pairs: with the distance that each must keep.
        beyond: distance, m, from which on nothing is looked at more closely: one above it is some bound on the least.
    """
    search = _Search(motion, pairs, beyond)
    searches = [search.least_of(group) for group in pairs.groups]
    asked: dict[int, _Question] = {}
    found: dict[int, tuple[int, float, float]] = {}

    def go_on(number: int, answer: _Answer | None) -> None:
        asked.pop(number, None)
        try:
            asked[number] = next(searches[number]) if answer is None else searches[number].send(answer)
        except StopIteration as end:
            found[number] = end.value

    for number in range(len(searches)):
        go_on(number, None)
    while asked:  # what all of them ask for next is measured together
        numbers = list(asked)
        for number, answer in zip(numbers, search.measured([asked[number] for number in numbers]), strict=True):
            go_on(number, answer)
    return tuple(LeastDistance(pairs.pairs[pair], distance, at) for _, (pair, distance, at) in sorted(found.items()))


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
        self.middle = (starts + ends - 1) // 2
        self.time = (np.maximum(self.middle - starts, ends - 1 - self.middle) + 0.5) * motion.step
        self.drift = 0.5 * np.maximum.reduceat(around, starts, axis=0) * self.time[:, None] ** 2


class _Search:
    """What the pairs share: bounds on accelerations, and the partitions of the samples, finer and finer."""

    def __init__(self, motion: SampledMotion, pairs: PairArrays, beyond: float) -> None:
        self.motion, self.pairs, self.beyond = motion, pairs, beyond
        self.around = motion.around_samples(pairs.reach)
        self.partitions: dict[int, _Blocks] = {}
        self.measures: dict[int, Distances] = {}
        sizes = [_BLOCK >> power for power in range(_BLOCK.bit_length()) if _BLOCK >> power >= _SHARED]
        known = np.unique(np.concatenate([self.blocks(size).middle for size in sizes]))
        self.row = np.full(len(motion.t), -1)
        self.row[known], self.frames = np.arange(len(known)), self._frames_at(known)
        first = self.blocks(_BLOCK)
        columns = self.row[first.middle]
        frames = JointFrames(*(getattr(self.frames, item.name)[:, columns] for item in fields(JointFrames)))
        drift = first.drift[:, pairs.sides[0]] + first.drift[:, pairs.sides[1]]
        self.low = pairs.ball_gaps(frames, first.time) - drift.T
        self.middle: dict[int, np.ndarray] = {}
        if beyond < np.inf:
            self._look_at_the_near(frames, first)
        self.nearest, self.least = np.argmin(self.low, axis=1).tolist(), np.min(self.low, axis=1).tolist()

    def _look_at_the_near(self, frames: JointFrames, first: _Blocks) -> None:
        """Better bounds over the first blocks, from directions found for many pairs at once.

        Two capsules are nearest in closed form; of what the arm carries it is the box about it that is near a link.
        """
        near = np.min(self.low, axis=1) < self.beyond
        capsules, carried = np.flatnonzero(near & self.pairs.capsules), np.flatnonzero(near & self.pairs.carried)
        distances, between = capsules_apart(self._bodies(capsules), frames)
        _, away = box_bounds(self._bodies(carried), frames)
        self.middle = dict(zip(capsules.tolist(), distances, strict=True))
        own, every = np.concatenate([capsules, carried]), np.arange(len(first.middle))
        which, blocks = np.repeat(own, len(every)), np.tile(every, len(own))
        drift = first.drift[blocks, self.pairs.sides[:, which]].sum(axis=0)
        directions = np.concatenate([between, away]).reshape(-1, 3)
        bounds = self._separated(which, frames, blocks, directions, first.time[blocks]) - drift
        np.maximum.at(self.low, own, bounds.reshape(-1, len(every)))

    def _bodies(self, numbers: np.ndarray) -> list[tuple[Body, Body]]:
        return [(pair.first, pair.second) for pair in (self.pairs.pairs[number] for number in numbers.tolist())]

    def blocks(self, size: int) -> _Blocks:
        """The partition in blocks of so many samples."""
        if size not in self.partitions:
            self.partitions[size] = _Blocks(self.motion, self.around, size)
        return self.partitions[size]

    def least_of(self, group: Sequence[int]) -> Generator[_Question, _Answer, tuple[int, float, float]]:
        """Of some pairs the one with the least slack above its limit: its number, its distance, m, and where, s."""
        nearest, (least, at) = group[0], (yield from self._least(group[0], np.inf))
        for pair in group[1:]:
            lower = self.pairs.pairs[pair].limit - self.pairs.pairs[nearest].limit
            distance, when = yield from self._least(pair, least + lower)
            if distance < least + lower:
                nearest, least, at = pair, distance, when
        return nearest, least, at

    def _least(self, pair: int, known: float) -> Generator[_Question, _Answer, tuple[float, float]]:
        """The least distance of one pair, m, and where, s: of those measured and of all bounds that were enough.

        Where it cannot be below a known distance, m, it is some distance that is not below it either.
        """
        nearest, least = self.nearest[pair], self.least[pair]
        if least >= min(known, self.beyond):
            return least, float(self.motion.t[nearest * _BLOCK])
        size, low, limit = _BLOCK, self.low[pair], self.pairs.pairs[pair].limit
        # the most promising block first: what it has spares most of the others
        distance, _ = yield from self._asked(pair, size, np.array([nearest]))
        best, at = float(distance[0]), int(self.blocks(size).middle[nearest])
        far = low >= self._enough(best, limit)
        bound = float(np.min(low[far], initial=np.inf))
        chosen = np.flatnonzero(~far)
        while len(chosen):
            distance, low = yield from self._asked(pair, size, chosen)
            nearest = int(np.argmin(distance))
            if distance[nearest] < best:
                best, at = float(distance[nearest]), int(self.blocks(size).middle[chosen[nearest]])
            done = (low >= self._enough(best, limit)) | (size == 1)
            bound = float(np.min(low[done], initial=bound))
            size //= 2
            halves = np.concatenate([2 * chosen[~done], 2 * chosen[~done] + 1])
            if not len(halves):
                break
            chosen = halves[halves < len(self.blocks(size).middle)]
        return min(bound, best), float(self.motion.t[at])

    def _asked(self, pair: int, size: int, chosen: np.ndarray) -> Generator[_Question, _Answer, _Answer]:
        if pair in self.middle and size == _BLOCK:
            return self.middle[pair][chosen], self.low[pair][chosen]
        return (yield pair, size, chosen)

    def measured(self, questions: Sequence[_Question]) -> list[_Answer]:
        """The answers, all found together."""
        partitions, counts = [self.blocks(size) for _, size, _ in questions], [len(part) for _, _, part in questions]
        which = np.repeat([pair for pair, _, _ in questions], counts)
        middle, time, drift = [], [], []
        for (pair, _, chosen), blocks in zip(questions, partitions, strict=True):
            first, second = self.pairs.sides[:, pair]
            middle.append(blocks.middle[chosen])
            time.append(blocks.time[chosen])
            drift.append(blocks.drift[chosen, first] + blocks.drift[chosen, second])
        frames, places = self._frames(np.concatenate(middle))
        distance, directions = self._apart(which, frames, places)
        low = self._separated(which, frames, places, directions, np.concatenate(time)) - np.concatenate(drift)
        ends = np.cumsum(counts)[:-1]
        return list(zip(np.split(distance, ends), np.split(low, ends), strict=True))

    def _frames(self, samples: np.ndarray) -> tuple[JointFrames, np.ndarray]:
        """Frames of the arm, and where among them those at some samples (k,) are."""
        places = self.row[samples]
        if np.all(places >= 0):
            return self.frames, places
        some, places = np.unique(samples, return_inverse=True)
        return self._frames_at(some), places

    def _frames_at(self, samples: np.ndarray) -> JointFrames:
        return joint_frames(self.motion.chain, self.motion.q[samples], self.motion.qd[samples])

    def _apart(self, which: np.ndarray, frames: JointFrames, places: np.ndarray) -> _Answer:
        """Distances (k,) of pairs (k,), m, and directions (k, 3) in which they are nearest, at some configurations."""
        distance, directions = np.empty(len(which)), np.empty((len(which), 3))
        bodies, sides, capsules = self.pairs.bodies, self.pairs.sides[:, which], self.pairs.capsules[which]
        if np.any(capsules):
            own = sides[:, capsules]
            distance[capsules], directions[capsules] = capsules_at(bodies, own, frames, places[capsules])
        if not np.all(capsules):
            measures, own = [self._measure(pair) for pair in which[~capsules].tolist()], sides[:, ~capsules]
            found = distances_by_coal(measures, bodies, own, frames, places[~capsules])
            distance[~capsules], directions[~capsules] = found
        return distance, directions

    def _measure(self, pair: int) -> Distances:
        if pair not in self.measures:
            self.measures[pair] = Distances(self.pairs.pairs[pair].first, self.pairs.pairs[pair].second)
        return self.measures[pair]

    def _separated(
        self, which: np.ndarray, frames: JointFrames, places: np.ndarray, directions: np.ndarray, time: np.ndarray
    ) -> np.ndarray:
        """How far directions (k, 3) separate pairs (k,) for times (k,), s, about some configurations at least, m."""
        both, ends = np.concatenate([directions, directions]), np.concatenate([-time, time])
        sides = np.tile(self.pairs.sides[:, which], 2)
        bounds = separations(self.pairs.bodies, sides, frames, np.tile(places, 2), both, ends)
        return np.min(bounds.reshape(2, -1), axis=0)  # type: ignore[no-any-return]

    def _enough(self, best: float, limit: float) -> float:
        """Bound from which on a block needs no closer look, where the least distance found is `best`."""
        left = best - limit
        # of what is left, that it may be told from nothing
        loose = max(min(_EXACT, 0.5 * left), _SHARE * left) if left > 0.0 else _EXACT
        return min(best - loose, self.beyond)
