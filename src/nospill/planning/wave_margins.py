"""Margins of waves: what the second order adds to a height, kept from the optimiser instant by instant.

For motions that go on from a state. The optimiser's heights are linear. What the second order adds, and where, is known
of the motion that was judged; it grows with the square of the waves that drive it. So the next problem keeps a margin
instant by instant: first what calmer waves would add, of which own and added heights together are the limit, then more
where that was not enough. One back-off for all instants would have to hold for the highest crest too where the state
itself is near a limit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from nospill.certification.certificate import Judgement
from nospill.certification.verdict import Trace
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.transcription.margins_along import Margin

_MORE = 0.005
"""Margin beyond what the judge found."""
_SHARES = 50
"""Of a motion, in which margins of waves are noted."""
_NEAR, _MOST_KEPT = 0.95, 0.8
"""Use of a height from which they are, and the most of them."""
_STRONGER, _MOST_STEP, _AROUND = 1.3, 0.1, 2
"""By what of a height's excess they grow, at most at once, and on how many shares about it."""
_FREE = 0.1
"""Part of a limit by which a linear height is below what a margin leaves it where more of that would change nothing."""
_SLIGHTLY = 0.03
"""Part of a limit by which a height is too high at most where a margin has to bind: more of it is driven by others."""


def margins_of_waves(
    backoff: Mapping[RowId, float],
    margins: Mapping[RowId, Margin],
    judgement: Judgement,
    labels: Callable[[str], Iterable[str]],
    pace: float = 1.0,
) -> tuple[dict[RowId, Margin], dict[RowId, float]]:
    """Margins of the heights of second order that are near their limits or above them.

    And by what factor waves have to fall at all instants, where a height is too high with margins that leave its linear
    part free at that instant: what it adds swings on from earlier ones.

    Args:
        backoff: of every row of the last problem.
        margins: of its rows.
        judgement: of its answer.
        labels: subject of the certificate -> what it is called in the problem, each of its variants.
        pace: factor on what margins grow by.
    """
    found: dict[RowId, Margin] = {}
    driven: dict[RowId, float] = {}
    share = np.linspace(0.0, 1.0, _SHARES + 1)
    for trace in judgement.traces:
        if trace.linear is None or trace.constraint != SloshHeight.name or trace.use.max() < _NEAR:
            continue
        part = np.minimum((trace.t - trace.t[0]) / judgement.end_time * _SHARES, _SHARES).astype(int)
        scale = _calmer(trace)
        first = _greatest(part, scale**2 * _added(trace))
        more = _greatest(part, np.maximum(_excess(trace), 0.0))
        more = np.where(more > 0.0, np.minimum(_STRONGER * pace * more, _MOST_STEP) + _MORE * pace, 0.0)
        around = np.pad(more, _AROUND)
        more = np.max([around[shift : shift + len(more)] for shift in range(2 * _AROUND + 1)], axis=0)
        for label in labels(trace.subject):
            row = RowId(trace.constraint, label)
            if row not in backoff:
                continue
            last = margins.get(row)
            kept = first if last is None else np.interp(share, last.share, last.kept) + more
            if last is not None:
                kept = np.maximum(kept, _binding(backoff[row], last, trace, part) + more)
            found[row] = Margin(share, np.minimum(kept, _MOST_KEPT))
            if last is not None and scale < 1.0 and _is_free(backoff[row], last, trace, judgement.end_time):
                driven[row] = scale
    return found, driven


def _binding(backoff: float, margin: Margin, trace: Trace, part: np.ndarray) -> np.ndarray:
    """Of each share the margin with which a height slightly too high there begins to bind; 0 where it binds or is free.

    Less of it would be a round in which nothing changes.
    """
    assert trace.linear is not None
    share = np.linspace(0.0, 1.0, _SHARES + 1)
    own = _greatest(part, np.abs(trace.linear / trace.limit)) / (1.0 - backoff)
    excess = _greatest(part, np.maximum(_excess(trace), 0.0))
    over = (excess > 0.0) & (excess < _SLIGHTLY)
    loose = 1.0 - own - np.interp(share, margin.share, margin.kept)
    return np.where(over & (loose > 0.0) & (loose < _FREE), 1.0 - own, 0.0)


def _is_free(backoff: float, margin: Margin, trace: Trace, end_time: float) -> bool:
    """Whether a problem left a height's linear part free at the instant at which the whole is highest."""
    assert trace.linear is not None
    worst = int(np.argmax(trace.use))
    own = float(np.abs(trace.linear[worst] / trace.limit[worst]))
    kept = float(np.interp((trace.t[worst] - trace.t[0]) / end_time, margin.share, margin.kept))
    return own < (1.0 - backoff) * (1.0 - kept) - _FREE


def _excess(trace: Trace) -> np.ndarray:
    """By which part of the limit a height is too high over time, (m,), with what a finer grid may find."""
    return trace.use - 1.0 + _resolution(trace)


def _resolution(trace: Trace) -> np.ndarray:
    return SloshHeight.judge_resolution + SloshHeight.integration_error / np.abs(trace.limit)


def _added(trace: Trace) -> np.ndarray:
    """What the second order adds over time, (m,), as a part of the limit."""
    assert trace.linear is not None  # it is a trace of second order
    return np.maximum(trace.value - np.maximum(trace.linear, 0.0), 0.0) / np.abs(trace.limit)


def _calmer(trace: Trace) -> float:
    """The factor on all waves with which the height just keeps its limit where it is worst, at most 1.

    What the second order adds then falls with its square: own h + added h^2 = 1, less what a finer grid may find.
    """
    assert trace.linear is not None
    worst = int(np.argmax(trace.use))
    own, added = float(trace.linear[worst] / np.abs(trace.limit[worst])), float(_added(trace)[worst])
    kept = 1.0 - float(_resolution(trace)[worst])
    return min(2.0 * kept / (own + float(np.sqrt(own**2 + 4.0 * added * kept))), 1.0)


def _greatest(part: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The greatest of some values (m,) in each of the shares (m,) that they are in."""
    kept = np.zeros(_SHARES + 1)
    np.maximum.at(kept, part, values)
    return kept
