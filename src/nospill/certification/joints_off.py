"""What joints that are off add to every row, each of them alone: to the first order all together add the sum.

Three respects in which joints of a band may be off, each with the ways of one joint that are replayed, all others in
the middle of their band:

- late: as early and as late as the band allows; a lag is a delay to the first order;
- elastic: transmissions of some frequencies of the band, so near to each other that their ringing overlaps;
- beside: sinusoids of some frequencies up to the bandwidth, in two phases, of which the others are sums.

What a joint adds to a row at an instant is the most that any of its ways does. Rows on the final state are looked at
twice where joints ring: where they should stand, and once they do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from nospill.certification.end_states import added_at_end, uses_at_end
from nospill.certification.replay import Replay
from nospill.certification.tracked_rows import Followed
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.base import Role, RowId
from nospill.laws.constraints.lift import Lift
from nospill.motion.tracking import done_by
from nospill.scene.controller import Controller
from nospill.scene.tracking import Arm, Tracking

_DECAYED = 2.2
"""Time constants of the slowest ringing for which it is followed: a tenth is left."""
_LONGEST_RING = 1.0
"""s, for which it is followed at most."""
_LAGS = 6.0
"""After which nothing is left of one that counts: exp(-6) is 0.25 %."""
_OVERLAP, _STEPS = 2.0, (1.04, 1.3)
"""Damping ratios from one frequency to the next, and least and largest ratio of the two."""
_FROM, _OF_SWINGS = 1.0, 1.25
"""Hz, of the slowest sinusoid, and from one to the next."""
_PHASES = 2.0 * np.pi * np.arange(8) / 8
"""Of a sinusoid, for rows on the final state."""
_PRESSED = 0.02
"""Weights with which an object is pressed at least where shares of its friction are compared."""
_AT_ONCE = 24
"""Replays in one call."""
_FAST, _SLOW, _OF_SLOW = 1000.0, 500.0, 100.0
"""Hz, of the replays: what a delay adds jumps with the jerk; and of the ringing that needs no more than the slower."""


@dataclass(frozen=True, slots=True)
class Added:
    """What joints that are off in one respect add.

    Attributes:
        t: (m,) s, on the clock of the plan.
        added: part of its limit that every row uses more, (m,); of a row on the final state (1,).
        worst: what each joint does where it adds most, (n, m, w), or (n, 1, w): see the respect.
    """

    t: np.ndarray
    added: dict[RowId, np.ndarray]
    worst: dict[RowId, np.ndarray]

    def at(self, row: RowId, time: float) -> np.ndarray:
        """What each joint does where it adds most to a row at a time, (n, w)."""
        found = self.worst[row]
        instants = np.linspace(self.t[0], self.t[-1], found.shape[1]) if found.shape[1] > 1 else self.t[-1:]
        return found[:, int(np.argmin(np.abs(instants - time)))]


@dataclass(frozen=True, slots=True)
class Late:
    """Joints that are late; `worst` is 1 for late and 0 for early. The replays have a rate, Hz."""

    tracking: Tracking
    rate: float = _FAST

    def of(self, arm: Arm, worst: np.ndarray) -> Arm:
        """An arm with these joints (n, 1) late by all of their band."""
        share = worst[:, 0]
        return replace(arm, controller=Controller(share * self.tracking.delay, share * self.tracking.lag))

    def added(self, followed: Followed) -> Added:
        """What the joints add."""
        few, half = replace(followed.with_few_modes(), rate=self.rate), self.tracking.latest / 2.0
        uncertain = np.flatnonzero(half)
        alone = half * (np.arange(len(half)) == uncertain[:, None])
        arms = [Arm.late(Controller(half + off, np.zeros_like(half))) for off in (0.0 * half, *alone, *-alone)]
        played = _Played.of(few, arms, float(np.max(self.tracking.latest)))
        behind, ahead = slice(1, len(alone) + 1), slice(len(alone) + 1, None)
        added, worst = {}, {}
        for row, uses in played.uses.items():
            more, less = uses[behind], uses[ahead]
            added[row] = np.sum(np.maximum(np.maximum(more, less) - uses[0], 0.0), axis=0)
            worst[row] = np.ones((len(half), uses.shape[1], 1))
            worst[row][uncertain, :, 0] = more >= less
        last, first = (np.array([played.settled[0]] * len(half)) for _ in range(2))
        last[uncertain], first[uncertain] = played.settled[behind], played.settled[ahead]
        for row, (most, share) in added_at_end(few.scene, played.settled[0], last, first).items():
            added[row], worst[row] = np.array([most]), share[:, None, None]
        return Added(played.t, added, worst)


@dataclass(frozen=True, slots=True)
class Elastic:
    """Joints on elastic transmissions; `worst` is a frequency, Hz."""

    tracking: Tracking

    def of(self, arm: Arm, worst: np.ndarray) -> Arm:
        """An arm with transmissions of these frequencies (n, 1)."""
        assert self.tracking.resonance is not None
        return replace(arm, frequency=worst[:, 0], damping=self.tracking.resonance.damping)

    @property
    def frequencies(self) -> np.ndarray:
        """(k,) increasing, Hz: those that are replayed."""
        band = self.tracking.resonance
        assert band is not None
        lowest, highest = band.ends
        step = float(np.clip(1.0 + _OVERLAP * band.damping, *_STEPS))
        count = int(np.ceil(np.log(highest / lowest) / np.log(step) - 1e-9)) + 1
        return np.geomspace(lowest, highest, count)

    @property
    def rings(self) -> float:
        """How long after the end it is followed, s."""
        band = self.tracking.resonance
        assert band is not None
        return min(_DECAYED / (band.damping * 2.0 * np.pi * band.lowest), _LONGEST_RING)

    def added(self, followed: Followed) -> Added:
        """What the joints add."""
        frequencies, joints = self.frequencies, followed.joints
        rate = _SLOW if frequencies[-1] <= _OF_SLOW else _FAST
        few = replace(followed.with_few_modes(), rate=rate)
        stiff = _middle(self.tracking)
        alone = [np.where(np.eye(joints)[joint] > 0.0, own, np.inf) for joint in range(joints) for own in frequencies]
        arms = [stiff, *(self.of(stiff, own[:, None]) for own in alone)]
        played = _Played.of(few, arms, float(np.max(self.tracking.latest)) + self.rings)
        added, worst = {}, {}
        for row, uses in played.uses.items():
            by_joint = uses[1:].reshape(joints, len(frequencies), -1)
            added[row] = np.sum(np.maximum(np.max(by_joint, axis=1) - uses[0], 0.0), axis=0)
            worst[row] = frequencies[np.argmax(by_joint, axis=1)][:, :, None]
        for states in (played.ending, played.settled):
            by_joint = states[1:].reshape(joints, len(frequencies), *states.shape[1:])
            for row, (most, share) in added_at_end(few.scene, states[0], by_joint[:, 0], by_joint[:, -1]).items():
                if most >= added.get(row, np.zeros(1))[0]:
                    added[row] = np.array([most])
                    worst[row] = np.where(share > 0.5, frequencies[0], frequencies[-1])[:, None, None]
        return Added(played.t, added, worst)


@dataclass(frozen=True, slots=True)
class Beside:
    """Joints beside where they should be; `worst` is a frequency, Hz, and a phase, rad."""

    tracking: Tracking

    def of(self, arm: Arm, worst: np.ndarray) -> Arm:
        """An arm with sinusoids of these frequencies and phases (n, 2)."""
        assert self.tracking.swing is not None
        return replace(arm, amplitude=self.tracking.swing.amplitude, swing=worst[:, 0], phase=worst[:, 1])

    @property
    def frequencies(self) -> np.ndarray:
        """(k,) increasing, Hz: those that are replayed."""
        assert self.tracking.swing is not None
        highest = self.tracking.swing.bandwidth
        lowest = min(_FROM, highest)
        count = int(np.ceil(np.log(highest / lowest) / np.log(_OF_SWINGS) - 1e-9)) + 1
        return np.geomspace(lowest, highest, count)

    def added(self, followed: Followed) -> Added:
        """What the joints add: of two phases the root of the sum of squares, as the worst phase between them does."""
        assert self.tracking.swing is not None
        frequencies, joints, middle = self.frequencies, followed.joints, _middle(self.tracking)
        few = replace(followed.with_few_modes(), rate=_SLOW)
        arms = [middle]
        for joint in range(joints):
            amplitude = np.where(np.arange(joints) == joint, self.tracking.swing.amplitude, 0.0)
            for own in frequencies:
                for phase in (0.0, np.pi / 2):
                    swing = replace(middle, amplitude=amplitude, swing=np.full(joints, own))
                    arms.append(replace(swing, phase=np.full(joints, phase)))
        played = _Played.of(few, arms, float(np.max(self.tracking.latest)))
        added, worst = {}, {}
        for row, uses in played.uses.items():
            cosine, sine = np.moveaxis((uses[1:] - uses[0]).reshape(joints, len(frequencies), 2, -1), 2, 0)
            most, angle = np.hypot(cosine, sine), np.arctan2(sine, cosine)
            at = np.argmax(most, axis=1)[:, None]
            added[row] = np.sum(np.take_along_axis(most, at, axis=1)[:, 0], axis=0)
            worst[row] = np.stack([frequencies[at[:, 0]], np.take_along_axis(angle, at, axis=1)[:, 0]], axis=-1)
        off = (played.settled[1:] - played.settled[0]).reshape(joints, len(frequencies), 2, -1)
        turns = np.stack([np.cos(_PHASES), np.sin(_PHASES)], axis=1)
        states = np.einsum("pc,jfck->jfpk", turns, off).reshape(-1, *played.settled.shape[1:]) + played.settled[0]
        for row, use in uses_at_end(few.scene, np.concatenate([played.settled[:1], states])).items():
            by_joint = use[1:].reshape(joints, -1)
            at = np.argmax(by_joint, axis=1)
            added[row] = np.array([np.sum(np.maximum(np.max(by_joint, axis=1) - use[0], 0.0))])
            own = np.stack([frequencies[at // len(_PHASES)], _PHASES[at % len(_PHASES)]], axis=-1)
            worst[row] = own[:, None]
        return Added(played.t, added, worst)


Respect = Late | Elastic | Beside


def respects(tracking: Tracking, *, late_at: float = _FAST) -> tuple[Respect, ...]:
    """Those in which joints of a band may be off; late ones are replayed at a rate in Hz."""
    late = (Late(tracking, late_at),) if np.any(tracking.latest) else ()
    elastic = () if tracking.resonance is None else (Elastic(tracking),)
    return (*late, *elastic, *(() if tracking.swing is None else (Beside(tracking),)))


def rest_after(tracking: Tracking, stated: Controller | None = None) -> float:
    """How long after the end of a plan the joints of a band are followed, behind a stated controller, s."""
    rings = 0.0 if tracking.resonance is None else Elastic(tracking).rings
    lag = tracking.lag if stated is None else tracking.lag + stated.lag
    return float(np.max(tracking.delay)) + _LAGS * float(np.max(lag)) + rings


def _middle(tracking: Tracking) -> Arm:
    """An arm whose joints are all as late as the middle of their band."""
    return Arm.late(Controller(tracking.latest / 2.0, np.zeros(len(tracking.latest))))


@dataclass(frozen=True, slots=True)
class _Played:
    """Some arms played: uses of the rows (a, m), and states (a, 2, k) of the liquids at two instants.

    Attributes:
        t: (m,) s, on the clock of the plan: without the shift that is the middle of the band.
        uses: of the rows during the motion, and of the distances that are near.
        ending: states where the joints should stand.
        settled: states at the end of the replay.
    """

    t: np.ndarray
    uses: dict[RowId, np.ndarray]
    ending: np.ndarray
    settled: np.ndarray

    @classmethod
    def of(cls, few: Followed, arms: Sequence[Arm], after: float) -> _Played:
        start, stop = few.span
        shift = float(np.mean(arms[0].controller.delay))
        uses: dict[RowId, list[np.ndarray]] = {}
        ending, settled, t = [], [], np.empty(0)
        done = done_by(few.motion, start, stop, after + 0.05)
        for first in range(0, len(arms), _AT_ONCE):
            replays = few.played([done(arm) for arm in arms[first : first + _AT_ONCE]], after=after)
            t = replays[0].t - shift
            at = int(np.argmin(np.abs(t - stop)))
            for own in few.during(replays):
                for row, use in own.items():
                    uses.setdefault(row, []).append(use)
            ending += [_state(replay, at) for replay in replays]
            settled += [_state(replay, -1) for replay in replays]
        found = {row: np.array(own) for row, own in uses.items()}
        return cls(t, {row: _of_margin(row, found) for row in found}, np.array(ending), np.array(settled))


def _of_margin(row: RowId, uses: Mapping[RowId, np.ndarray]) -> np.ndarray:
    """Uses (a, m) of a row that are linear in the forces: of a limit that the pressing force sets by its margin.

    Friction over pressing force grows beyond all bounds where an object is hardly pressed, and half of two small
    deviations is not half of that. What is left of the friction, as a part of the friction as planned, is linear.
    """
    constraint, lifts = BY_NAME.get(row.constraint), uses.get(RowId(Lift.name, row.subject))
    if constraint is None or not constraint.relative or constraint.role is not Role.CONTACT or lifts is None:
        return uses[row]
    pressing = np.maximum(1.0 - lifts, _PRESSED)  # in weights
    return 1.0 - pressing / pressing[0] * (1.0 - uses[row])


def _state(played: Replay, index: int) -> np.ndarray:
    """(2, k) displacements and velocities of the liquids at an instant."""
    return np.stack([played.slosh_displacement[index], played.slosh_velocity[index]])
