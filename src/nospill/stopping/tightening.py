"""What a stop that was rejected keeps more of the next time: back-off, margins at its beginning, margins of waves.

Where the motion of plan and stop together breaks a limit as the stop takes over, the stop begins with less jerk.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from nospill.certification.certificate import Judgement
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.jerk import PathJerk, TiltJerk
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.planning.active_set import ActiveSet
from nospill.planning.wave_margins import margins_of_waves
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
_FADES, _FADES_AT_START = 0.9, 0.97
"""Of the margins of waves, and of those at the beginning, that the stop from the next instant begins with."""


def broken(active: ActiveSet, judgement: Judgement) -> dict[RowId, tuple[float, float]]:
    """Use of the limits that a stop breaks, or of which it leaves too little, and where in it, by rows of the problem.

    What breaks after the end does so because liquids swing on: it is a matter of the rows on how far these do. A rack
    feels the liquids of all its vials.
    """
    swinging = {row.subject for row in active.possible if row.constraint == ResidualHeight.name}
    over: dict[RowId, tuple[float, float]] = {}
    for row in judgement.certificate.rows:
        if row.shortfall <= 0.0 or row.constraint not in BY_NAME:
            continue
        name, subjects = row.constraint, set(active.labels_of(row.subject))
        if row.at_s > judgement.end_time and not row.at_end:
            name, subjects = ResidualHeight.name, swinging & subjects or swinging
        for label in subjects:
            key = RowId(name, label)
            use = 1.0 + row.shortfall / row.size
            over[key] = max((use, row.at_s / judgement.end_time), over.get(key, (0.0, 1.0)))
    return over


def tightened(
    active: ActiveSet, over: Mapping[RowId, tuple[float, float]], judgement: Judgement, pace: float = 1.0
) -> ActiveSet:
    """The set with more back-off and margins; itself where nothing of what breaks is in the problem.

    What breaks right after the beginning keeps more there alone: the motion before may stand on its limits, and with
    more back-off everywhere none may lead on from there.

    Args:
        active: of the last problem.
        over: use of the limits that its answer breaks, and where, as `broken` has them.
        judgement: of its answer.
        pace: factor on what they are raised by beyond what the judge found.
    """
    backoff, margins = dict(active.backoff), dict(active.margins)
    waves, driven = margins_of_waves(active.backoff, active.margins, judgement, active.labels_of, pace)
    for row, scale in driven.items():
        backoff[row] = min(max(backoff[row] + _MORE, 1.0 - scale * (1.0 - backoff[row])), _MOST_BACKOFF)
    known = (over.keys() & backoff.keys()) - waves.keys()
    for key in known:
        use, share = over[key]
        power = _AFTER_END if key.constraint == ResidualHeight.name else 1.0
        more = 1.0 - (1.0 - backoff[key]) / use**power + _MORE * pace
        if share <= _EARLY:
            kept = margins[key].kept[0] if key in margins else 0.0
            kept += use - 1.0 + _MORE * pace / 2
            margins[key] = Margin(np.array([0.0, _EARLY, 1.5 * _EARLY]), kept * _AT_START)
        else:
            backoff[key] = min(max(backoff[key] + _MORE * pace, more), _MOST_BACKOFF)
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
