"""What a plan survives of an arm that does not quite track it, in three figures.

Each is the largest size of one fault under which every row still holds:

- delay: every joint late by anything from nothing to this, each for itself (what all share only shifts the time);
- swing: every joint off by a sinusoid of this amplitude at `SWING_FREQUENCY`, each in its own phase;
- resonance: every joint on an elastic transmission of this frequency, or of a higher one, damped by `DAMPING`.

Delays and swings are small beside the motion, and a row is nearly linear in them. So replays with one joint off give
what that joint adds to every row at every instant, and the combinations of joints that add most; those are replayed,
then those beside the worst of them, and the worst counts. What is worst of a small delay is not what is worst of a
large one: at a size far from those before, differences are made anew. Sizes follow by secants, and the one that is said
was replayed and holds. Frequencies: `resonance`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from nospill.certification.resonance import CLOSE, resonance_survived
from nospill.certification.survived import (
    MOST_DELAY,
    MOST_SWING,
    SWING_FREQUENCY,
    Survival,
    Survived,
)
from nospill.certification.tracked_rows import Followed, Uses, worst_of
from nospill.certification.verdict import Row
from nospill.laws.constraints.base import RowId
from nospill.motion.interpolation import JointMotion
from nospill.motion.tracking import Swinging, late_by
from nospill.motion.trajectory import Trajectory
from nospill.scene.controller import Controller
from nospill.scene.scene import Scene

_SMALL = 1e-4
"""s or rad, at which the first differences are made."""
_FEW_MODES = 0.02
"""Part of what a plan leaves of its limits that replays with few modes are trusted with no farther."""
_BELOW = 0.3
"""Part of that by which a size that fails is gone below where it is expected to hold."""
_COMBINATIONS, _ROUNDS = 8, 8
"""Of joints that are replayed at a size, and sizes, at most."""
_ALIKE = 1.5
"""Ratio of two sizes up to which the combinations of joints that were the worst at one are looked at at the other."""
_NEAR = 2.0
"""Times the size of the row that fails first, within which an object is on the tray where it is replayed."""


Combination = tuple[np.ndarray, np.ndarray]
"""Of joints: shares (n,) of a size, and phases (n,), rad."""


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault that every joint has for itself.

    Attributes:
        most: largest size that is looked at.
        motion: (size of every joint, phase of every joint) -> what the joints do.
        delays: whether it is a delay, from nothing to its size; else a sinusoid, whose phase is its own.
        rate: of the replays that tell what a joint adds, Hz: what a delay adds jumps with the jerk.
    """

    most: float
    motion: Callable[[np.ndarray, np.ndarray], JointMotion]
    delays: bool
    rate: float

    def after(self, size: float) -> float:
        """How much longer than the plan it lasts, s."""
        return size if self.delays else 0.0

    def alone(self, size: float, joints: int) -> list[JointMotion]:
        """What the joints do with none of them off, then with one of them off, joint by joint, each in two ways.

        Delays are counted from their middle, of which a joint is as much later or earlier: what is left is free of the
        shift of time, by which a row that changes fast would seem to be exceeded. Of a sinusoid every phase is a sum of
        two.
        """
        none, each = np.zeros(joints), size * np.eye(joints)
        if self.delays:
            middle = none + 0.5 * size
            ways = [middle, *(middle + off for own in each for off in (0.5 * own, -0.5 * own))]
            return [self.motion(way, none) for way in ways]
        phases = (0.0, np.pi / 2)
        return [self.motion(none, none), *(self.motion(own, none + phase) for own in each for phase in phases)]

    def most_added(self, added: np.ndarray) -> np.ndarray:
        """The most that all joints add, (m,), from what each adds in each of its two ways, (n, 2, m)."""
        if self.delays:
            return np.sum(np.maximum(np.max(added, axis=1), 0.0), axis=0)
        return np.sum(np.linalg.norm(added, axis=1), axis=0)

    def worst(self, added: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Shares of the size (n,) and phases (n,) with which they add it, from (n, 2) at an instant."""
        if self.delays:
            return (added[:, 0] > added[:, 1]).astype(float), np.zeros(len(added))
        # cos(w t + phase) = cos(phase) cos(w t) + sin(phase) cos(w t + pi/2)
        return np.ones(len(added)), np.arctan2(added[:, 1], added[:, 0])

    def beside(self, share: np.ndarray, phase: np.ndarray) -> list[Combination]:
        """Combinations that differ from one in a joint; of sinusoids, whose phases are any, none."""
        flipped = [np.where(own, 1.0 - share, share) for own in np.eye(len(share), dtype=bool)]
        return [(own, phase) for own in flipped if np.ptp(own) > 0.0] if self.delays else []


def delay_fault(followed: Followed) -> Fault:
    """Joints that are late."""
    late = late_by(followed.motion, *followed.span)

    def motion(size: np.ndarray, _: np.ndarray) -> JointMotion:
        return late(Controller(size, np.zeros_like(size)))

    return Fault(MOST_DELAY, motion, delays=True, rate=500.0)


def swing_fault(followed: Followed) -> Fault:
    """Joints that swing about where they should be."""

    def motion(size: np.ndarray, phase: np.ndarray) -> JointMotion:
        return Swinging(followed.motion, size, SWING_FREQUENCY, phase)

    return Fault(MOST_SWING, motion, delays=False, rate=125.0)


@dataclass(frozen=True, slots=True)
class Looked:
    """A plan that is looked at: the same for every fault.

    Attributes:
        few: the plan with few modes of each liquid.
        stated: rows where nothing is off, with all modes.
        few_stated: those of `few`.
    """

    few: Followed
    stated: Uses
    few_stated: Uses

    @classmethod
    def at(cls, followed: Followed) -> Looked:
        """What is the same for every fault of a plan."""
        few = followed.with_few_modes()
        return cls(few, *(own.rows(own.motion, after=_SMALL)[0] for own in (followed, few)))

    def beyond(self, row: RowId) -> float:
        """What the other modes add to the largest use of a row."""
        return float(np.max(self.stated[row]) - np.max(self.few_stated[row]))


def survival(trajectory: Trajectory, scene: Scene, rows: tuple[Row, ...] = ()) -> Survival | None:
    """What a plan survives.

    Args:
        trajectory: the plan.
        scene: the task; its objects are as stated, whatever their tolerances.
        rows: of the certificate, for the distances that are near.

    Returns:
        The sizes; None of an empty tray.
    """
    if not scene.cargo:
        return None
    followed = Followed.of(trajectory, scene, rows)
    plan = Looked.at(followed)
    delay, swing = (survived(plan, fault(followed)) for fault in (delay_fault, swing_fault))
    return Survival(delay, swing, resonance_survived(plan.few, worst_of(plan.few_stated)[0]))


def survived(plan: Looked, fault: Fault) -> Survived:
    """Of a fault the size that a plan survives: the worst combinations of joints that are found hold at it."""
    use, row = worst_of(plan.stated)
    if use >= 1.0:
        return Survived(0.0, row.label)
    limit = 1.0 - _FEW_MODES * (1.0 - use)
    low, high, first = (0.0, use / limit), (np.inf, np.inf), row.label
    candidates = _candidates(plan, fault, _SMALL)
    size = min(candidates[0].size, fault.most)
    near = {item.row.subject for item in candidates if item.size <= _NEAR * candidates[0].size}
    plan = replace(plan, few=plan.few.only(near))
    seen, combinations = 0.0, []
    for _ in range(_ROUNDS):
        if not combinations or max(size, seen) > _ALIKE * min(size, seen):
            seen, combinations = size, _combinations(plan, fault, size)
        use, row = _worst(plan, fault, size, combinations)
        use /= limit
        if use < 1.0 and size >= fault.most:
            return Survived(None)
        before, (low, high) = low, ((size, use), high) if use < 1.0 else (low, (size, use))
        other = high if np.isfinite(high[0]) else before
        first = row.label if use >= 1.0 or not np.isfinite(high[0]) else first
        size = _following(low, other, high[0], fault.most)
        if min(size, high[0]) <= (1.0 + CLOSE) * low[0]:
            break
    return Survived(low[0], first)


def _following(low: tuple[float, float], other: tuple[float, float], high: float, most: float) -> float:
    """The next size, from the largest that holds with its use, another one with its, and the least that fails."""
    # a quotient grows beyond all bounds where an object is hardly pressed: of one that fails no more than half way
    rise = min(other[1] - low[1], 2.0 * (1.0 - low[1]))
    slope = rise / (other[0] - low[0]) if other[0] != low[0] else 0.0
    size = low[0] + (1.0 - low[1]) / slope if slope > 0.0 else 2.0 * low[0]
    if np.isinf(high):
        return min(size, 2.0 * low[0], most)
    size -= _BELOW * CLOSE * size  # that it may hold; and away from what is known already
    return float(np.clip(size, low[0] + 0.1 * (high - low[0]), low[0] + 0.9 * (high - low[0])))


@dataclass(frozen=True, slots=True)
class _Candidate:
    """A row at an instant, its use and the size (s or rad) at which it reaches its limit, both to the first order.

    `share` (n,) of the size and `phase` (n,), rad, are the combination of joints that uses most of it there.
    """

    row: RowId
    use: float
    size: float
    share: np.ndarray
    phase: np.ndarray


def _candidates(plan: Looked, fault: Fault, size: float) -> list[_Candidate]:
    """Of every row the instants at which it is used most at a size, the row first that reaches its limit first."""
    few = replace(plan.few, rate=fault.rate)
    none, *alone = few.rows(*fault.alone(size, few.joints), after=fault.after(size), at_end=fault.delays)
    found = []
    for row in none:
        added = np.array([own[row] - none[row] for own in alone]).reshape(few.joints, 2, -1)
        most, planned = fault.most_added(added), none[row] + plan.beyond(row)
        reached = size * np.maximum(1.0 - planned, 0.0) / np.maximum(most, 1e-12)
        for at in {int(np.argmin(reached)), *_peaks(planned + most).tolist()}:
            worst = fault.worst(added[:, :, at])
            found.append(_Candidate(row, float(planned[at] + most[at]), float(reached[at]), *worst))
    return sorted(found, key=lambda item: item.size)


def _peaks(use: np.ndarray) -> np.ndarray:
    """Instants at which a use is no less than beside it."""
    padded = np.concatenate([[-np.inf], use, [-np.inf]])
    return np.flatnonzero((use >= padded[:-2]) & (use >= padded[2:]))


def _combinations(plan: Looked, fault: Fault, size: float) -> list[Combination]:
    """The combinations of joints that are the worst at a size, to the first order."""
    alike: dict[bytes, _Candidate] = {}
    for item in sorted(_candidates(plan, fault, size), key=lambda item: -item.use):
        alike.setdefault(np.round([item.share, item.phase], 1).tobytes(), item)
    return [(item.share, item.phase) for item in list(alike.values())[:_COMBINATIONS]]


def _worst(plan: Looked, fault: Fault, size: float, combinations: list[Combination]) -> tuple[float, RowId]:
    """The largest use at a size, over some combinations of joints and those beside the worst of them, replayed."""
    use, row, found = _played(plan, fault, size, combinations)
    beside = fault.beside(*combinations[found])
    return max((use, row), _played(plan, fault, size, beside)[:2]) if beside else (use, row)


def _played(plan: Looked, fault: Fault, size: float, combinations: list[Combination]) -> tuple[float, RowId, int]:
    """The largest use of some combinations, whose it is, and which of them that is."""
    motions = [fault.motion(size * share, phase) for share, phase in combinations]
    played = plan.few.rows(*motions, after=fault.after(size), at_end=fault.delays)
    worst = [worst_of({row: use + plan.beyond(row) for row, use in uses.items()}) for uses in played]
    index = max(range(len(worst)), key=lambda index: worst[index][0])
    return *worst[index], index
