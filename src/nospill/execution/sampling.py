"""The clock of a recorder: period, jitter, samples that are missing or doubled, and when the others were taken."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.errors import ScenarioError
from nospill.execution.log import JointLog

_UNEVEN = 1.0
"""Of a period: where the stamps are off an even clock by more (rms), there is no even clock."""
_STEPS_OF_RESOLUTION = 4.0
"""A row that repeats the one before is one sample recorded twice where the arm moves by more than this before and after
it; at rest rows repeat each other anyway."""
_FOURTH = 4
_ROUNDING = 1e-13
"""rad; what rounding of digits leaves of equal positions."""
_ON_GRID, _ON_ONE_GRID = 0.02, 0.98
"""Multiples of the least difference count as whole within the first; of a resolution, so many of them are."""
_PARTS = 4
_APART, _AROUND = 20, 21
"""Rows between the stamps from which the usual step is taken, and rows on either side of a gap from which it is told:
their median is right to a tenth of a period where the stamps are off by a third of it."""
_GAP = 0.1
"""s; longest time without samples that a spline may bridge: a liquid swings on in it, the arm may turn round."""


@dataclass(frozen=True, slots=True, eq=False)
class Sampling:
    """When the samples of a log were taken, and what was found about its clock.

    Attributes:
        t: (k,) s, of the samples that are kept.
        kept: (k,) their rows in the log.
        period: s.
        jitter: of the stamps against an even clock, rms, s.
        largest_jitter: s.
        missing: samples that an even clock would have had besides.
        doubled: rows that repeat the one before while the arm moves, which are left out.
        share: part of the jitter that the positions follow: near 0 it is the recorder's alone, and the samples are
            even; near 1 they were taken at the stamps.
        resolution: (n,) rad, of the positions; 0 where they are not of one grid.
    """

    t: np.ndarray
    kept: np.ndarray
    period: float
    jitter: float
    largest_jitter: float
    missing: int
    doubled: int
    share: float
    resolution: np.ndarray

    @property
    def even(self) -> bool:
        """Whether the samples are taken as even, whatever their stamps."""
        return self.share < 0.5


def sampling_of(log: JointLog) -> Sampling:
    """Estimate when the samples of a log were taken.

    Raises:
        ScenarioError: the clock stands still, or no sample was taken for too long.
    """
    steps = np.diff(log.t)
    apart = min(_APART, len(steps) // 2)
    usual = float(np.median(log.t[apart:] - log.t[:-apart])) / apart
    if not usual > 0.0:
        raise ScenarioError(f"{log.origin}: its time never advances; a column of times in s is needed")
    resolution = np.array([_resolution(column) for column in log.position.T])
    again = (steps == 0.0) & np.all(np.diff(log.position, axis=0) == 0.0, axis=1)
    doubled = _repeated_rows(log.position, float(np.max(resolution))) | np.concatenate([[False], again])
    ticks = _ticks(steps, usual, ~again)
    period, first = np.polyfit(ticks, log.t, 1)
    off = log.t - (first + period * ticks)
    jitter = float(np.sqrt(np.mean(off**2)))
    kept = np.flatnonzero(~doubled & np.concatenate([[True], np.diff(ticks) > 0]))
    uneven = jitter > _UNEVEN * period
    share = 1.0 if uneven else _jitter_share(log.position, ticks, off, kept, float(period))
    if share >= 0.5:
        kept = kept[np.concatenate([[True], np.diff(log.t[kept]) > 0.0])]
    t = log.t[kept] if share >= 0.5 else first + period * ticks[kept]
    gaps = np.diff(t)
    longest = int(np.argmax(gaps))
    if gaps[longest] > _GAP:
        raise ScenarioError(
            f"{log.origin}: no samples from t = {t[longest]:.3f} s to {t[longest + 1]:.3f} s; at most {_GAP:g} s may "
            "be missing: record again, or cut the log where it stops"
        )
    return Sampling(
        t=t,
        kept=kept,
        period=float(period),
        jitter=jitter,
        largest_jitter=float(np.max(np.abs(off))),
        missing=0 if uneven else int(ticks[-1] - ticks[0]) + 1 - len(np.unique(ticks)),
        doubled=int(np.count_nonzero(doubled)),
        share=share,
        resolution=resolution,
    )


def _ticks(steps: np.ndarray, usual: float, new: np.ndarray) -> np.ndarray:
    """Numbers of the samples on an even clock, (m,), from the steps of their stamps (m - 1,) and the usual one, s.

    A row is the next sample, and the one after where the stamps stay late by a period from there on: one late stamp is
    followed by one that is not. `new` (m - 1,) leaves out rows that are the one before once more.
    """
    advance = new.astype(int)
    late = np.concatenate([[0.0], np.cumsum(steps - usual * advance)])
    long = np.flatnonzero(steps > 1.5 * usual) + 1
    for row in long[
        np.argsort(-steps[long - 1], kind="stable")
    ]:  # wide gaps first, which would pass for narrow ones beside them
        behind = np.median(late[row : row + _AROUND]) - np.median(late[max(0, row - _AROUND) : row])
        missing = int(np.round(behind / usual))
        if missing > 0:
            advance[row - 1] += missing
            late[row:] -= missing * usual
    return np.concatenate([[0], np.cumsum(advance)])


def _resolution(values: np.ndarray) -> float:
    """Step of the grid on which positions lie, rad; 0 where they are not of one grid."""
    steps = np.diff(np.unique(values))
    steps = steps[steps > _ROUNDING]
    if not len(steps):
        return 0.0
    # The least step that occurs may be some steps of the grid.
    for part in range(1, _PARTS + 1):
        step = float(np.min(steps)) / part
        if np.mean(np.abs(steps / step - np.round(steps / step)) < _ON_GRID) > _ON_ONE_GRID:
            return step
    return 0.0


def _repeated_rows(position: np.ndarray, resolution: float) -> np.ndarray:
    """Rows that repeat the one before, the arm moving before and after them, (m,)."""
    steps = np.max(np.abs(np.diff(position, axis=0)), axis=1)
    moves = steps > _STEPS_OF_RESOLUTION * resolution
    before, after = np.concatenate([[False], moves[:-1]]), np.concatenate([moves[1:], [False]])
    return np.concatenate([[False], (steps == 0.0) & before & after])


def _jitter_share(position: np.ndarray, ticks: np.ndarray, off: np.ndarray, kept: np.ndarray, period: float) -> float:
    """Part of the jitter that shows in the positions: least squares of fourth differences, which leave the motion out.

    A sample taken late by d is ahead of the even one by its speed times d.
    """
    if np.max(np.abs(off)) < 1e-7:
        return 0.0
    ticks, off, position = ticks[kept], off[kept], position[kept]
    if len(ticks) <= _FOURTH:
        return 0.0
    even = ticks[_FOURTH:] - ticks[:-_FOURTH] == _FOURTH
    speed = np.gradient(position, period * ticks, axis=0)
    differences = np.diff(position, _FOURTH, axis=0)[even]
    expected = np.diff(speed * off[:, None], _FOURTH, axis=0)[even]
    # A leap of the arm itself says nothing: it would weigh more than all the rest.
    usual = np.abs(differences) <= 6.0 * np.median(np.abs(differences), axis=0) + 1e-12
    square = float(np.sum(np.where(usual, expected, 0.0) ** 2))
    return float(np.sum(np.where(usual, expected * differences, 0.0))) / square if square > 0.0 else 0.0
