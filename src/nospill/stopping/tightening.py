"""What a stop that was rejected keeps more of the next time: back-off, margins at its beginning, margins of waves.

Where the motion of plan and stop together breaks a limit as the stop takes over, the stop begins with less jerk.

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
from nospill.laws.constraints.jerk import PathJerk, TiltJerk
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.planning.active_set import ActiveSet
from nospill.transcription.margins_along import Margin

_MORE, _MOST_BACKOFF = 0.005, 0.9
"""Back-off beyond what the judge found, and the most of it."""
_AFTER_END = 1.5
"""Power of the use by which what swings on after the end falls: the waves of second order fall more slowly."""
_EARLY, _AT_START = 0.12, np.array([1.0, 1.0, 0.0])
"""Part of a stop up to which a row that breaks is tightened there alone, and how that fades."""
_JERKS = (PathJerk.name, TiltJerk.name)
_HEADROOM, _MOST_OF_JERK = 0.01, 0.97
"""Of a limit, on which a plan stands with so much to spare; part of the jerk that is taken away at most."""
_SHARES = 50
"""Of a stop, in which margins of waves are noted."""
_NEAR, _MOST_KEPT = 0.95, 0.8
"""Use of a height from which they are, and the most of them."""
_STRONGER, _MOST_STEP, _AROUND = 1.3, 0.1, 2
"""By what of a height's excess they grow, at most at once, and on how many shares about it."""
_FREE = 0.1
"""Part of a limit by which a linear height is below what a margin leaves it where more of that would change nothing."""
_SLIGHTLY = 0.03
"""Part of a limit by which a height is too high at most where a margin has to bind: more of it is driven by others."""
_FADES, _FADES_AT_START = 0.9, 0.97
"""Of the margins of waves, and of those at the beginning, that the stop from the next instant begins with."""


def broken(active: ActiveSet, judgement: Judgement) -> dict[RowId, tuple[float, float]]:
    """Use of the limits that a stop breaks and the part of its duration where it does, by the rows of the problem.

    What breaks after the end does so because liquids swing on: it is a matter of the rows on how far these do. A rack
    feels the liquids of all its vials.
    """
    swinging = {row.subject for row in active.possible if row.constraint == ResidualHeight.name}
    over: dict[RowId, tuple[float, float]] = {}
    for row in judgement.certificate.rows:
        if row.ok or row.constraint not in BY_NAME:
            continue
        name, subjects = row.constraint, set(labels(active, row.subject))
        if row.at_s > judgement.end_time and not row.at_end:
            name, subjects = ResidualHeight.name, swinging & subjects or swinging
        for label in subjects:
            key = RowId(name, label)
            over[key] = max((row.use, row.at_s / judgement.end_time), over.get(key, (0.0, 1.0)))
    return over


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
    waves, driven = _of_waves(active, judgement)
    for row, scale in driven.items():
        backoff[row] = min(max(backoff[row] + _MORE, 1.0 - scale * (1.0 - backoff[row])), _MOST_BACKOFF)
    known = (over.keys() & backoff.keys()) - waves.keys()
    for key in known:
        use, share = over[key]
        power = _AFTER_END if key.constraint == ResidualHeight.name else 1.0
        more = 1.0 - (1.0 - backoff[key]) / use**power + _MORE
        if share <= _EARLY:
            kept = margins[key].kept[0] if key in margins else 0.0
            margins[key] = Margin(np.array([0.0, _EARLY, 1.5 * _EARLY]), (kept + use - 1.0 + _MORE / 2) * _AT_START)
        else:
            backoff[key] = min(max(backoff[key] + _MORE, more), _MOST_BACKOFF)
    if not known and not waves:
        return active
    return replace(active, backoff=backoff, margins=margins | waves)


def gentler(active: ActiveSet, over: Mapping[RowId, float], judgement: Judgement) -> ActiveSet:
    """The set with less jerk at the beginning of a stop; itself where there is none to take away.

    Args:
        active: of the last problem.
        over: use of the limits that plan and stop break together where the stop takes over.
        judgement: of its answer alone.
    """
    part = float(np.clip(_HEADROOM / (max(over.values()) - 1.0 + _HEADROOM), 0.1, 0.5))
    less: dict[RowId, Margin] = {}
    for trace in judgement.traces:
        row = RowId(trace.constraint, trace.subject)
        if trace.constraint not in _JERKS or row not in active.backoff:
            continue
        first = float(np.max(trace.use[trace.t - trace.t[0] <= _EARLY * judgement.end_time]))
        kept = min(1.0 - part * first, _MOST_OF_JERK)
        if row not in active.margins or kept > active.margins[row].kept[0]:
            less[row] = Margin(np.array([0.0, _EARLY, 1.5 * _EARLY]), kept * _AT_START)
    return replace(active, margins={**active.margins, **less}) if less else active


def faded(margins: Mapping[RowId, Margin]) -> dict[RowId, Margin]:
    """Margins of a stop as the one from the next instant begins with them."""
    return {
        row: replace(item, kept=(_FADES if row.constraint == SloshHeight.name else _FADES_AT_START) * item.kept)
        for row, item in margins.items()
    }


def _of_waves(active: ActiveSet, judgement: Judgement) -> tuple[dict[RowId, Margin], dict[RowId, float]]:
    """Margins of the heights of second order that are near their limits or above them.

    And by what factor waves have to fall at all instants, where a height is too high with margins that leave its linear
    part free at that instant: what it adds swings on from earlier ones.
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
        more = _greatest(part, np.maximum(trace.use - 1.0, 0.0))
        more = np.where(more > 0.0, np.minimum(_STRONGER * more, _MOST_STEP) + _MORE, 0.0)
        around = np.pad(more, _AROUND)
        more = np.max([around[shift : shift + len(more)] for shift in range(2 * _AROUND + 1)], axis=0)
        for label in labels(active, trace.subject):
            row = RowId(trace.constraint, label)
            if row not in active.backoff:
                continue
            last = active.margins.get(row)
            kept = first if last is None else np.interp(share, last.share, last.kept) + more
            if last is not None:
                kept = np.maximum(kept, _binding(active.backoff[row], last, trace, part) + more)
            found[row] = Margin(share, np.minimum(kept, _MOST_KEPT))
            if last is not None and scale < 1.0 and _is_free(active.backoff[row], last, trace, judgement.end_time):
                driven[row] = scale
    return found, driven


def _binding(backoff: float, margin: Margin, trace: Trace, part: np.ndarray) -> np.ndarray:
    """Of each share the margin with which a height slightly too high there begins to bind; 0 where it binds or is free.

    Less of it would be a round in which nothing changes.
    """
    assert trace.linear is not None
    share = np.linspace(0.0, 1.0, _SHARES + 1)
    own = _greatest(part, np.abs(trace.linear / trace.limit)) / (1.0 - backoff)
    excess = _greatest(part, np.maximum(trace.use - 1.0, 0.0))
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


def _added(trace: Trace) -> np.ndarray:
    """What the second order adds over time, (m,), as a part of the limit."""
    assert trace.linear is not None  # it is a trace of second order
    return np.maximum(trace.value - np.maximum(trace.linear, 0.0), 0.0) / np.abs(trace.limit)


def _calmer(trace: Trace) -> float:
    """The factor on all waves with which the height just keeps its limit where it is worst, at most 1.

    What the second order adds then falls with its square: own h + added h^2 = 1.
    """
    assert trace.linear is not None
    worst = int(np.argmax(trace.use))
    own, added = float(trace.linear[worst] / np.abs(trace.limit[worst])), float(_added(trace)[worst])
    return min(2.0 / (own + float(np.sqrt(own**2 + 4.0 * added))), 1.0)


def _greatest(part: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The greatest of some values (m,) in each of the shares (m,) that they are in."""
    kept = np.zeros(_SHARES + 1)
    np.maximum.at(kept, part, values)
    return kept
