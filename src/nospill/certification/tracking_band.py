"""Rows over a band of arms that are late, ring or are off: how much more of every limit the worst uses, and when.

Two looks, of which the worse counts:

- To the first order in the joints together: what each joint adds alone, instant by instant, all together add at most
  the sum (`joints_off`).
- Sampled: the combinations that bring the fullest rows nearest to their limits are replayed. Where one uses more than
  the sum says, what is added to that row is raised in proportion.

Nothing is proven beyond the first order, and of combinations and frequencies that are not replayed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from nospill.certification.joints_off import Added, Late, Respect, respects, rest_after
from nospill.certification.tracked_rows import Followed, Uses
from nospill.certification.verdict import Row, Trace, margin_at, worst_row
from nospill.laws.constraints.base import RowId
from nospill.motion.tracking import done_by
from nospill.scene.controller import Controller
from nospill.scene.tracking import Arm, Tracking

_REPLAYED = 3
"""Combinations of joints that are replayed."""
_FIRST_LOOK, _BROKEN = 500.0, 1.003
"""Hz, of a first look, and use of a limit from which that is broken: the two rates differ by less."""
_CLEAR = 1e-9
"""Of a limit: a row that is added less than this is as planned."""
_Found = Sequence[tuple[Respect, Added]]


@dataclass(frozen=True, slots=True)
class Band:
    """What the worst arms of a band make of a motion.

    Attributes:
        rows: of the worst one of every row: those that it changes.
        t: (m,) of what is added, s, on the clock of the plan.
        added: part of its limit that every row uses more than planned, (m,); of one on the end (1,).
        use: largest use of every row over the band.
        largest: part of the band, to the first order, up to which every row holds; above 1 where all of it does.
    """

    rows: tuple[Row, ...]
    t: np.ndarray
    added: Uses
    use: Mapping[RowId, float]
    largest: float


OverBand = Callable[[Followed, Tracking, tuple[Trace, ...], Uses, np.ndarray], Band]
"""The arguments of `band_of` -> the rows over a band."""


def band_of(
    followed: Followed, tracking: Tracking, traces: tuple[Trace, ...], corner_use: Uses, corner_times: np.ndarray
) -> Band:
    """The rows of a judged motion over a band.

    Args:
        followed: the motion, as it is judged, reserves and all.
        tracking: the band.
        traces: of the motion as planned.
        corner_use: largest use over variants of the objects, (m,), by row.
        corner_times: (m,) s, of those.

    Raises:
        ModelError: the liquids cannot be integrated.
    """
    found = [(respect, respect.added(followed)) for respect in respects(tracking)]
    return _sampled(followed, tracking, _FirstOrder.of(followed, found, traces, corner_use, corner_times))


def broken_or_band_of(
    followed: Followed, tracking: Tracking, traces: tuple[Trace, ...], corner_use: Uses, corner_times: np.ndarray
) -> Band:
    """`band_of` for a motion under planning: where a first look breaks a row, what that found, else all of it.

    The first look is to the first order alone, of late joints by replays at half of the rate.
    """
    found = [(respect, respect.added(followed)) for respect in respects(tracking, late_at=_FIRST_LOOK)]
    first = _FirstOrder.of(followed, found, traces, corner_use, corner_times)
    if max((float(np.max(bound)) for bound in first.bounds.values()), default=0.0) > _BROKEN:
        return first.band(tracking)
    late = Late(tracking)
    found = [(late, late.added(followed)) if isinstance(own[0], Late) else own for own in found]
    return _sampled(followed, tracking, _FirstOrder.of(followed, found, traces, corner_use, corner_times))


@dataclass(frozen=True, slots=True)
class _FirstOrder:
    """What all joints together add to the first order.

    Attributes:
        t: (m,) of what is added, s.
        found: by respect.
        added: part of its limit that every row uses more, (m,).
        planned: the rows as planned.
        bounds: uses of the rows over the band, on the grids of those.
    """

    t: np.ndarray
    found: _Found
    added: dict[RowId, np.ndarray]
    planned: dict[RowId, Trace]
    bounds: dict[RowId, np.ndarray]

    @classmethod
    def of(
        cls, followed: Followed, found: _Found, traces: tuple[Trace, ...], corner_use: Uses, corner_times: np.ndarray
    ) -> _FirstOrder:
        """Of a motion, arguments as of `band_of`."""
        t = followed.record.t
        added = _together([own for _, own in found], t)
        planned = {trace.id: _with_variants(trace, corner_use, corner_times) for trace in traces if trace.id in added}
        bounds = {row: trace.use + _at(added[row], t, trace.t) for row, trace in planned.items()}
        return cls(t, found, added, planned, bounds)

    def band(self, tracking: Tracking, replayed: Sequence[Row] = ()) -> Band:
        """The rows over the band, with those of some arms that were replayed."""
        of_bounds = [
            worst_row(_exceeded(self.planned[row], bound, tracking.text))
            for row, bound in self.bounds.items()
            if np.max(bound - self.planned[row].use) > _CLEAR
        ]
        use = {row: float(np.max(bound)) for row, bound in self.bounds.items()}
        for row in replayed:
            use[row.id] = max(row.use, use.get(row.id, 0.0))
        return Band((*of_bounds, *replayed), self.t, self.added, use, _largest(self.planned, self.bounds))


def _sampled(followed: Followed, tracking: Tracking, first: _FirstOrder) -> Band:
    """The rows over a band, with the worst arms replayed."""
    planned, added, bounds = first.planned, dict(first.added), dict(first.bounds)
    replayed: list[Row] = []
    after = rest_after(tracking)
    done = done_by(followed.motion, *followed.span, after + 0.05)
    for arm in _worst_arms(bounds, planned, first.found):
        (played,) = followed.played([done(arm)], after=after)
        text = arm.text(followed.record.joints)
        rows = [worst_row(replace(trace, variant=text)) for trace in followed.traces(played)]
        replayed += rows
        for row in rows:
            if row.id in bounds and row.use > np.max(bounds[row.id]):
                at = int(np.argmax(bounds[row.id]))
                more = float(bounds[row.id][at] - planned[row.id].use[at])
                if more > _CLEAR:
                    factor = (row.use - float(planned[row.id].use[at])) / more
                    added[row.id] = factor * added[row.id]
                    bounds[row.id] = planned[row.id].use + _at(added[row.id], first.t, planned[row.id].t)
    return replace(first, added=added, bounds=bounds).band(tracking, replayed)


def _largest(planned: Mapping[RowId, Trace], bounds: Uses) -> float:
    least = np.inf
    for row, bound in bounds.items():
        more = bound - planned[row].use
        shares = np.where(more > _CLEAR, (1.0 - planned[row].use) / np.maximum(more, _CLEAR), np.inf)
        least = min(least, float(np.min(shares)))
    return max(least, 0.0)


def _with_variants(trace: Trace, corner_use: Uses, times: np.ndarray) -> Trace:
    """The trace with the use of the worst variant at every instant."""
    if trace.id not in corner_use or len(trace.t) < 2:
        return trace
    use = np.maximum(trace.use, np.interp(trace.t, times, corner_use[trace.id]))
    return _exceeded(trace, use, trace.variant)


def _at(added: np.ndarray, t: np.ndarray, times: np.ndarray) -> np.ndarray:
    if len(added) == 1:
        return np.full(len(times), added[0])
    own = t if len(added) == len(t) else np.linspace(t[0], t[-1], len(added))
    return np.interp(times, own, added)


def _together(found: Sequence[Added], t: np.ndarray) -> dict[RowId, np.ndarray]:
    """What all respects add to every row at times t (m,), s; the most that is added after the last one counts there."""
    sums: dict[RowId, np.ndarray] = {}
    for own in found:
        for row, added in own.added.items():
            values = added
            if len(added) > 1:
                values = _at(added, own.t, t)
                later = np.linspace(own.t[0], own.t[-1], len(added)) >= t[-1]
                values[-1] = max(values[-1], np.max(added[later], initial=0.0))
            sums[row] = sums.get(row, 0.0) + values
    return sums


def _worst_arms(bounds: Uses, planned: Mapping[RowId, Trace], found: _Found) -> Iterator[Arm]:
    """Arms that bring rows nearest to their limits, the fullest first."""
    seen: list[list[np.ndarray]] = []
    alone_late = len(found) == 1 and isinstance(found[0][0], Late)
    for row in sorted(bounds, key=lambda row: -float(np.max(bounds[row]))):
        time = float(planned[row].t[int(np.argmax(bounds[row]))])
        worst = [own.at(row, time) for _, own in found]
        alike = any(all(map(np.array_equal, worst, other)) for other in seen)
        # a delay that all joints share only shifts the time
        if alike or (alone_late and np.ptp(worst[0]) == 0.0):
            continue
        seen.append(worst)
        arm = Arm.late(Controller(np.zeros(len(worst[0])), np.zeros(len(worst[0]))))
        for (respect, _), own in zip(found, worst, strict=True):
            arm = respect.of(arm, own)
        yield arm
        if len(seen) == _REPLAYED:
            return


def _exceeded(trace: Trace, use: np.ndarray, variant: str) -> Trace:
    """A trace with another use of its limit."""
    margin = margin_at(trace.known, trace.limit, use)
    from_below = float(np.sum((trace.value - trace.limit) * trace.margin)) > 0.0
    value = trace.limit + margin if from_below else trace.limit - margin
    return replace(trace, value=value, margin=margin, variant=variant)
