"""What the noise of a log and its smoothing leave open: intervals of margins and heights, and the verdict with them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.special import stdtrit  # scipy.stats takes as long to load as all else of a command

from nospill.certification.verdict import Row, Trace, worst_row
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.slosh_height import SloshHeight

DRAWS = 6
"""Motions drawn from the band of the splines; each is judged."""
WIDE = float(stdtrit(DRAWS, 0.975))
"""Standard deviations, known from so many draws, to either side of a band of 95 %."""
CERTIFIED, NOT_CERTIFIED, OPEN = "certified", "not certified", "cannot be told"
"""Verdicts: every row holds beyond the noise; one is broken beyond noise and smoothing; neither."""


def row_bands(rough: Sequence[Trace], drawn: Sequence[Sequence[Trace] | None]) -> dict[RowId, float]:
    """Half width of the 95 % band of every row's margin; infinite where a drawn motion's liquid cannot be followed."""
    return {trace.id: WIDE * _spread(index, trace, drawn) for index, trace in enumerate(rough)}


def _spread(index: int, trace: Trace, drawn: Sequence[Sequence[Trace] | None]) -> float:
    margin, off = worst_row(trace).worst_margin, []
    for own in drawn:
        if own is None:
            return np.inf
        off.append(worst_row(own[index]).worst_margin - margin)
    return float(np.sqrt(np.mean(np.square(off)))) if off else 0.0


def smoothing_errors(motion: Sequence[Trace], read: Sequence[Trace] | None) -> dict[RowId, float]:
    """By how much every margin differs between a motion and what is read of it, with knots twice as far apart perhaps.

    Infinite where a liquid cannot be followed along what is read.
    """
    if read is None:
        return {trace.id: np.inf for trace in motion}
    return {
        trace.id: abs(worst_row(other).worst_margin - worst_row(trace).worst_margin)
        for trace, other in zip(motion, read, strict=True)
    }


def height_bands(
    rough: Sequence[Trace], drawn: Sequence[Sequence[Trace] | None], t: np.ndarray
) -> dict[str, np.ndarray]:
    """Half width of the 95 % bands of the heights (m,) at times t, by object; infinite likewise."""
    bands = {}
    for index, trace in enumerate(rough):
        if trace.constraint == SloshHeight.name:
            # a drawn motion may be played on a finer grid
            off = [np.interp(t, traces[index].t, traces[index].value) for traces in drawn if traces is not None]
            off = np.array(off).reshape(-1, len(t)) - np.interp(t, trace.t, trace.value)
            wide = np.sqrt(np.mean(off**2, axis=0)) if len(off) else np.zeros(len(t))
            bands[trace.subject] = WIDE * wide if len(off) == len(drawn) else np.full(len(t), np.inf)
    return bands


def outcome(row: Row, bands: Mapping[RowId, float], smoothing: Mapping[RowId, float], rows: int) -> str:
    """Whether a row holds, fails or cannot be told, all rows at once with 95 % confidence.

    Smoothing rounds what is played, and rings where a jerk jumps: it counts against a failure alone.

    Args:
        row: of the certificate.
        bands: half width of the 95 % band of each margin by itself.
        smoothing: what smoothing may have changed it by.
        rows: how many there are.
    """
    band = bands.get(row.id, 0.0)
    band *= float(stdtrit(DRAWS, 1.0 - 0.025 / rows)) / WIDE if band else 1.0
    if row.worst_margin >= band:
        return CERTIFIED
    return NOT_CERTIFIED if row.worst_margin < -band - smoothing.get(row.id, 0.0) else OPEN
