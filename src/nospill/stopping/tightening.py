"""What a stop that was rejected keeps more of the next time: back-off, margins at its beginning, margins of waves.

The optimiser's heights are linear. What the second order adds, and where, is known of the stop that was judged; it
grows with the square of the waves that drive it. So the next problem keeps a margin instant by instant: first what
calmer waves would add, of which own and added heights together are the limit, then more where that was not enough.
One back-off for all instants would have to hold for the highest crest too where the plan's own state is near a limit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from nospill.certification.certificate import Judgement
from nospill.certification.verdict import Trace
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.planning.active_set import ActiveSet
from nospill.transcription.margins_along import Margin

_MORE, _MOST_BACKOFF = 0.005, 0.9
"""Back-off beyond what the judge found, and the most of it."""
_EARLY, _AT_START = 0.12, np.array([1.0, 1.0, 0.0])
"""Part of a stop up to which a row that breaks is tightened there alone, and how that fades."""
_SHARES = 50
"""Of a stop, in which margins of waves are noted."""
_NEAR, _MOST_KEPT = 0.95, 0.8
"""Use of a height from which they are, and the most of them."""
_STRONGER, _MOST_STEP, _AROUND = 1.3, 0.1, 2
"""By what of a height's excess they grow, at most at once, and on how many shares about it."""
_FADES = 0.9
"""Of the margins that the stop from the next instant begins with."""


def broken(active: ActiveSet, judgement: Judgement) -> dict[RowId, tuple[float, float]]:
    """Use of the limits that a stop breaks and the part of its duration where it does, by the rows of the problem."""
    return {
        RowId(row.constraint, label): (row.use, row.at_s / judgement.end_time)
        for row in judgement.certificate.rows
        if not row.ok and row.constraint in BY_NAME
        for label in labels(active, row.subject)
    }


def labels(active: ActiveSet, subject: str) -> list[str]:
    """What a subject of the certificate is called in the problem, each of its variants."""
    return [label for (name, _), label in active.names.items() if name == subject] or [subject]


def tightened(active: ActiveSet, over: Mapping[RowId, tuple[float, float]], judgement: Judgement) -> ActiveSet:
    """The set with more back-off and margins; itself where nothing of what breaks is in the problem.

    What breaks right after the beginning keeps more there alone: the motion before may stand on its limits, and with
    more back-off everywhere none may lead on from there.

    Args:
        active: of the last problem.
        over: use of the limits that its answer breaks, and where, as `broken` has them.
        judgement: of its answer.
    """
    backoff, margins = dict(active.backoff), dict(active.margins)
    waves = _of_waves(active, judgement)
    known = (over.keys() & backoff.keys()) - waves.keys()
    for key in known:
        use, share = over[key]
        more = 1.0 - (1.0 - backoff[key]) / use + _MORE
        if share <= _EARLY:
            kept = margins[key].kept[0] if key in margins else 0.0
            margins[key] = Margin(np.array([0.0, _EARLY, 1.5 * _EARLY]), (kept + use - 1.0 + _MORE / 2) * _AT_START)
        else:
            backoff[key] = min(max(backoff[key] + _MORE, more), _MOST_BACKOFF)
    if not known and not waves:
        return active
    return replace(active, backoff=backoff, margins=margins | waves)


def faded(margins: Mapping[RowId, Margin]) -> dict[RowId, Margin]:
    """Margins of a stop as the one from the next instant begins with them."""
    return {row: replace(item, kept=_FADES * item.kept) for row, item in margins.items()}


def _of_waves(active: ActiveSet, judgement: Judgement) -> dict[RowId, Margin]:
    """Margins of the heights of second order that are near their limits or above them."""
    found: dict[RowId, Margin] = {}
    share = np.linspace(0.0, 1.0, _SHARES + 1)
    for trace in judgement.traces:
        if trace.linear is None or trace.constraint != SloshHeight.name or trace.use.max() < _NEAR:
            continue
        part = np.minimum((trace.t - trace.t[0]) / judgement.end_time * _SHARES, _SHARES).astype(int)
        first, more = _greatest(part, _of_calmer_waves(trace)), _greatest(part, np.maximum(trace.use - 1.0, 0.0))
        more = np.where(more > 0.0, np.minimum(_STRONGER * more, _MOST_STEP) + _MORE, 0.0)
        around = np.pad(more, _AROUND)
        more = np.max([around[shift : shift + len(more)] for shift in range(2 * _AROUND + 1)], axis=0)
        for label in labels(active, trace.subject):
            row = RowId(trace.constraint, label)
            if row in active.backoff:
                last = active.margins.get(row)
                kept = first if last is None else np.interp(share, last.share, last.kept) + more
                found[row] = Margin(share, np.minimum(kept, _MOST_KEPT))
    return found


def _of_calmer_waves(trace: Trace) -> np.ndarray:
    """What the second order adds over time, as a part of the limit, with waves that just keep it where it is worst.

    With all waves by the factor h it is h^2 times as much: own h + added h^2 = 1.
    """
    assert trace.linear is not None  # it is a trace of second order
    limit = np.abs(trace.limit)
    over = np.maximum(trace.value - np.maximum(trace.linear, 0.0), 0.0) / limit
    worst = int(np.argmax(trace.use))
    own, added = float(trace.linear[worst] / limit[worst]), float(over[worst])
    return over * min(2.0 / (own + np.sqrt(own**2 + 4.0 * added)), 1.0) ** 2


def _greatest(part: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The greatest of some values (m,) in each of the shares (m,) that they are in."""
    kept = np.zeros(_SHARES + 1)
    np.maximum.at(kept, part, values)
    return kept
