"""Rows over a band of arms that are late: how much more of every limit the worst of them uses, and when.

Two looks, of which the worse counts:

- To the first order in the joints together: replays with one joint as early, and as late, as its band allows, the
  others in the middle of theirs, say what that joint adds to every row at every instant; all joints together add at
  most the sum. A lag is a delay to that order. Rows on the final state: see `end_states`.
- Sampled: the combinations that bring the fullest rows nearest to their limits are replayed with their delays and lags.
  Where one uses more than the sum says, what is added to that row is raised in proportion.

Nothing is proven beyond the first order, and of combinations that are not replayed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from nospill.certification.end_states import added_at_end
from nospill.certification.replay import Replay
from nospill.certification.tracked_rows import Followed, Uses
from nospill.certification.verdict import Row, Trace, margin_at, worst_row
from nospill.laws.constraints.base import RowId
from nospill.motion.interpolation import JointMotion
from nospill.motion.tracking import late
from nospill.scene.controller import Controller
from nospill.scene.tracking import Tracking

_REPLAYED = 3
"""Combinations of joints that are replayed."""
_CLEAR = 1e-9
"""Of a limit: a row that is added less than this is as planned."""


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
    first = _first_order(followed, tracking)
    added, t = first.added, first.t
    planned = {trace.id: _with_variants(trace, corner_use, corner_times) for trace in traces if trace.id in added}
    bounds = {row: trace.use + _at(added[row], t, trace.t) for row, trace in planned.items()}
    replayed: list[Row] = []
    for share in _worst_combinations(bounds, planned, first.signs, t):
        rows = list(_combination(followed, tracking, share))
        replayed += rows
        for row in rows:
            if row.id in bounds and row.use > np.max(bounds[row.id]):
                at = int(np.argmax(bounds[row.id]))
                more = float(bounds[row.id][at] - planned[row.id].use[at])
                if more > _CLEAR:
                    factor = (row.use - float(planned[row.id].use[at])) / more
                    added[row.id] = factor * added[row.id]
                    bounds[row.id] = planned[row.id].use + _at(added[row.id], t, planned[row.id].t)
    of_bounds = [
        worst_row(_exceeded(planned[row], bound, tracking.text))
        for row, bound in bounds.items()
        if np.max(bound - planned[row].use) > _CLEAR
    ]
    use = {row: float(np.max(bound)) for row, bound in bounds.items()}
    for row in replayed:
        use[row.id] = max(row.use, use.get(row.id, 0.0))
    return Band((*of_bounds, *replayed), t, added, use, _largest(planned, bounds))


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


@dataclass(frozen=True, slots=True)
class _FirstOrder:
    """What is added to every row, (m,), and the joints (n, m) that are late, 1, or early, 0, there; t (m,) in s."""

    added: dict[RowId, np.ndarray]
    signs: dict[RowId, np.ndarray]
    t: np.ndarray


def _first_order(followed: Followed, tracking: Tracking) -> _FirstOrder:
    few, half = followed.with_few_modes(), tracking.latest / 2.0
    start, stop = followed.span
    after = float(np.max(tracking.latest))

    def arm(off: np.ndarray) -> JointMotion:
        return late(followed.motion, Controller(half + off, np.zeros_like(off)), start, stop)

    uncertain = np.flatnonzero(half)
    alone = half * (np.arange(len(half)) == uncertain[:, None])
    replays = few.played([arm(0.0 * half), *map(arm, alone), *map(arm, -alone)], after=after)
    (middle, *moved), (state, *ends) = few.during(replays), [_last(replay) for replay in replays]
    behind, ahead = moved[: len(alone)], moved[len(alone) :]
    last, first = (np.array([state] * len(half)) for _ in range(2))
    last[uncertain], first[uncertain] = ends[: len(alone)], ends[len(alone) :]
    added, found = {}, {}
    for row, use in middle.items():
        more, less = (np.array([own[row] for own in side]) for side in (behind, ahead))
        added[row] = np.sum(np.maximum(np.maximum(more, less) - use, 0.0), axis=0)
        found[row] = np.ones((len(half), len(use)))
        found[row][uncertain] = more >= less
    for row, (most, share) in added_at_end(few.scene, state, last, first).items():
        added[row], found[row] = np.array([most]), share[:, None]
    # the plan's clock: the middle of the band only shifts the time
    t = replays[0].t - float(np.mean(half))
    return _FirstOrder(added, found, t)


def _last(played: Replay) -> np.ndarray:
    """(2, k) displacements and velocities at the end."""
    return np.stack([played.slosh_displacement[-1], played.slosh_velocity[-1]])


def _worst_combinations(
    bounds: Uses, planned: Mapping[RowId, Trace], signs: Uses, t: np.ndarray
) -> Iterator[np.ndarray]:
    """Which joints are late, (n,), where rows come nearest to their limits, the fullest first."""
    found: list[np.ndarray] = []
    for row in sorted(bounds, key=lambda row: -float(np.max(bounds[row]))):
        at = float(planned[row].t[int(np.argmax(bounds[row]))])
        own = signs[row]
        place = 0 if own.shape[1] == 1 else int(np.argmin(np.abs(np.linspace(t[0], t[-1], own.shape[1]) - at)))
        share = own[:, place]
        if 0 < np.sum(share) < len(share) and not any(np.array_equal(share, other) for other in found):
            found.append(share)
            yield share
        if len(found) == _REPLAYED:
            return


def _combination(followed: Followed, tracking: Tracking, share: np.ndarray) -> Iterator[Row]:
    """Rows where some joints have all of their delay and lag, the others none."""
    arm = Controller(share * tracking.delay, share * tracking.lag)
    names = [name for name, late_one in zip(followed.record.joints, share, strict=True) if late_one]
    text = f"{', '.join(names)} late"
    (played,) = followed.played([_played(followed, arm)], after=_after(arm))
    for trace in followed.traces(played):
        yield worst_row(replace(trace, variant=text))


def _played(followed: Followed, arm: Controller) -> JointMotion:
    return late(followed.motion, arm, *followed.span)


def _after(arm: Controller) -> float:
    return arm.latest + 6.0 * float(np.max(arm.lag))


def _exceeded(trace: Trace, use: np.ndarray, variant: str) -> Trace:
    """A trace with another use of its limit."""
    margin = margin_at(trace.known, trace.limit, use)
    from_below = float(np.sum((trace.value - trace.limit) * trace.margin)) > 0.0
    value = trace.limit + margin if from_below else trace.limit - margin
    return replace(trace, value=value, margin=margin, variant=variant)
