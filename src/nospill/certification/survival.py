"""What a plan survives of an arm that does not quite track it, in three figures.

Each is the largest size of one fault under which every row still holds:

- delay: every joint late by anything from nothing to this, each for itself (what all share only shifts the time);
- swing: every joint off by a sinusoid of this amplitude at `SWING_FREQUENCY`, each in its own phase;
- resonance: every joint on an elastic transmission of this frequency, or of a higher one, damped by `DAMPING`.

Delays and swings are small beside the motion: a row is linear in them. So a replay with one joint off gives what that
joint adds to every row at every instant; the worst that all joints can add is the sum of what each can add, the size at
which a row reaches its limit follows, and so does the combination of joints that brings it there. That one is replayed,
and its size found by secants. Frequencies are tried from above.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from nospill.certification.survived import (
    DAMPING,
    HIGHEST,
    LOWEST,
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
from nospill.motion.tracking import Swinging, elastic, late
from nospill.motion.trajectory import Trajectory
from nospill.scene.controller import Controller
from nospill.scene.scene import Scene

_SMALL = 1e-4
"""s or rad, with which differences are made."""
_CLOSE = 0.03
"""Part of a size by which its last two estimates differ."""
_ALIKE = 1.05
"""Times the size of the row that fails first, within which the next one is replayed too."""
_NEAR = 1.3
"""Times that size, within which an object is on the tray where it is replayed."""
_SAMPLES_OF_A_PERIOD, _RATES = 16.0, (250.0, 1000.0)
"""Of an elastic joint, with which it is replayed; and the rates in Hz between which that is kept."""
_STEPS = 1.0 / 2.2, 0.95
"""From one frequency to the next lower one, at most and at least."""
_RING = 0.35
"""s after the end for which an elastic joint is followed."""
_ROUNDS = 4


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

    @property
    def phases(self) -> tuple[float, ...]:
        """With which a joint is played alone."""
        return (0.0,) if self.delays else (0.0, np.pi / 2)

    def rates(self, slopes: np.ndarray) -> np.ndarray:
        """The most that all joints add per size, (m,), from what each adds in each phase, (n, phases, m).

        Delays are counted from their middle, half a size later: what is left is free of the shift of time, by which a
        row that changes fast would seem to be exceeded.
        """
        if self.delays:
            return 0.5 * np.sum(np.abs(slopes[:, 0]), axis=0)
        return np.sum(np.linalg.norm(slopes, axis=1), axis=0)

    def worst(self, slopes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Shares of the size (n,) and phases (n,) with which they add it, from the slopes (n, phases) at an instant."""
        if self.delays:
            return (slopes[:, 0] > 0.0).astype(float), np.zeros(len(slopes))
        # cos(w t + phase) = cos(phase) cos(w t) + sin(phase) cos(w t + pi/2)
        return np.ones(len(slopes)), np.arctan2(slopes[:, 1], slopes[:, 0])


def delay_fault(followed: Followed) -> Fault:
    """Joints that are late."""
    start, stop = followed.span

    def motion(size: np.ndarray, _: np.ndarray) -> JointMotion:
        return late(followed.motion, Controller(size, np.zeros_like(size)), start, stop)

    return Fault(MOST_DELAY, motion, delays=True, rate=1000.0)


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
    return Survival(delay, swing, _resonance(plan))


def survived(plan: Looked, fault: Fault) -> Survived:
    """Of a fault the size that a plan survives."""
    worst, row = worst_of(plan.stated)
    if worst >= 1.0:
        return Survived(0.0, row.label)
    coarse, joints = replace(plan.few, rate=fault.rate), plan.few.joints

    motions = [fault.motion(own, np.full(joints, phase)) for own in _SMALL * np.eye(joints) for phase in fault.phases]
    before, *alone = coarse.rows(coarse.motion, *motions, after=_SMALL, at_end=fault.delays)
    candidates = _candidates(fault, plan.stated, before, alone)
    near = {item.row.subject for item in candidates if item.size <= _NEAR * candidates[0].size}
    some = replace(plan, few=plan.few.only(near))
    sizes = [_replayed(some, fault, item) for item in candidates[:2] if item.size <= _ALIKE * candidates[0].size]
    return min(sizes, key=_size_of, default=Survived(None))


def _size_of(item: Survived) -> float:
    return np.inf if item.size is None else item.size


@dataclass(frozen=True, slots=True)
class _Candidate:
    """A row with the size at which it reaches its limit, to the first order, and the joints that bring it there.

    Attributes:
        row: which.
        use: of its limit as planned, at that instant.
        size: of the fault.
        share: (n,) of the size that every joint has.
        phase: (n,) rad.
    """

    row: RowId
    use: float
    size: float
    share: np.ndarray
    phase: np.ndarray


def _candidates(fault: Fault, stated: Uses, before: Uses, alone: list[Uses]) -> list[_Candidate]:
    """Of every row the instant at which it is the first to reach its limit, the least size first."""
    found = []
    for row in before:
        slopes = np.array([one[row] - before[row] for one in alone]) / _SMALL
        slopes = slopes.reshape(-1, len(fault.phases), slopes.shape[1])
        use = _about(stated[row], slopes.shape[2])
        sizes = np.maximum(1.0 - use, 0.0) / np.maximum(fault.rates(slopes), 1e-12)
        at = int(np.argmin(sizes))
        found.append(_Candidate(row, float(use[at]), float(sizes[at]), *fault.worst(slopes[:, :, at])))
    return sorted(found, key=lambda item: item.size)


def _about(use: np.ndarray, count: int) -> np.ndarray:
    """A use over the same time at so many instants; where there are fewer, the largest about each of them."""
    if len(use) <= count:
        return np.interp(np.linspace(0.0, 1.0, count), np.linspace(0.0, 1.0, len(use)), use)
    edges = np.linspace(-0.5, count - 0.5, count + 1)[:-1] * (len(use) - 1) / (count - 1)
    return np.maximum.reduceat(use, np.maximum(np.round(edges), 0).astype(int))


def _replayed(plan: Looked, fault: Fault, found: _Candidate) -> Survived:
    """The size at which a combination of joints brings the first row to its limit, by secants over replays."""
    share, phase, first = found.share, found.phase, found.row.label
    before, size = (0.0, found.use), min(found.size, fault.most)
    for _ in range(_ROUNDS):
        (uses,) = plan.few.rows(fault.motion(size * share, phase), after=fault.after(size), at_end=fault.delays)
        worst, row = worst_of({row: use + plan.beyond(row) for row, use in uses.items()})
        first = row.label
        if not np.isfinite(worst):  # a liquid that is thrown about
            size = 0.5 * size
            continue
        if worst < 1.0 and size >= fault.most:
            return Survived(None)
        slope = (worst - before[1]) / (size - before[0])
        following = size + (1.0 - worst) / slope if slope > 0.0 else 2.0 * size
        following = float(np.clip(following, 0.5 * size, min(2.0 * size, fault.most)))
        if abs(following - size) < _CLOSE * size and following < fault.most:
            return Survived(following, first)
        before, size = (size, worst), following
    return Survived(size, first) if size < fault.most else Survived(None)


def _resonance(plan: Looked) -> Survived:
    """The lowest frequency that is survived, from above; the next one is where what is added would be 1.2 times it."""
    few, planned = plan.few, worst_of(plan.few_stated)[0]
    start, stop = few.span

    def worst(frequency: float) -> tuple[float, RowId]:
        motion = elastic(few.motion, np.full(few.joints, frequency), DAMPING, start, stop + 2.0 * _RING)
        coarse = replace(few, rate=float(np.clip(_SAMPLES_OF_A_PERIOD * frequency, *_RATES)))
        return worst_of(coarse.rows(motion, after=_RING, at_end=False)[0])

    high, frequency = np.inf, HIGHEST
    use, row = worst(frequency)
    while use <= 1.0:
        if frequency <= LOWEST:
            return Survived(None)
        # a stiffer joint is off by less as the square of its frequency
        nearer = 1.1 * np.sqrt(max(use - planned, 0.0) / max(1.0 - planned, 1e-9))
        high, frequency = frequency, max(frequency * float(np.clip(nearer, *_STEPS)), LOWEST)
        use, row = worst(frequency)
    if frequency == HIGHEST:
        return Survived(frequency, row.label)
    low, first = frequency, row.label
    while high > (1.0 + 2.0 * _CLOSE) * low:
        middle = float(np.sqrt(low * high))
        use, row = worst(middle)
        low, high, first = (middle, high, row.label) if use > 1.0 else (low, middle, first)
    return Survived(high, first)
