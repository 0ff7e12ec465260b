"""Constraint tightening: how much more of a budget is kept from the optimiser once the judge finds a row violated.

And how much less once it finds a certified motion far below.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from nospill.laws.constraints import END_NAMES, LIQUID_NAMES, OBJECT_NAMES
from nospill.laws.constraints.base import RowId

_MORE, _LEAST = 1.5, 3e-4
_MOST, _MOST_AT_END = 0.1, 0.3
ROUGH = 3.0
"""Use of a row on the final state from which no number of modes in the problem would do."""
_TOO_MUCH, _STUCK = 0.8, 0.6
"""Back-off of such a row, and part of its excess that a round of back-off has left, from which more of it would not;
that of a height of second order has to be more then."""
_CONTACTS = OBJECT_NAMES - LIQUID_NAMES
_NEAR, _SHARE = 0.03, 0.8
"""Part of its limit that a contact leaves, or less, where it is near it; and what it gets of another's back-off."""
_FREE, _MOST_OVER = 1e-3, 0.04
"""Part of a limit of second order that is left free, and the most that a height is taken to be over it when
half of that is added."""
_SLIGHTLY_OVER, _BY_SECANT = 0.004, 5.0
"""Part of a limit of second order by which a height is over it at most where a secant is asked, and how many times the
step of the law it may take."""
_SLIGHTLY_AT_END = 0.05
"""The same of a height after the end by its modes alone."""
_WELL_BELOW = 0.95
"""Use of such a limit below which a certified motion gets back-off back."""
_DRIVEN_BY_TURNS, _SCATTER = 2.0, 0.02
"""What the second order adds over the linear height, from which waves are not what drives it; and by how much of its
limit a motion with a little less budget may be higher all the same."""
_LEFT, _RELAXED = 2e-3, 0.8
"""Part of a limit that is left free all the same, and part of what is free beyond it that is no longer kept."""

_OWN = 0.35
"""Part of a residual limit that the modes get where the second order needs the rest; it costs next to no time."""
_SPARE = 0.1
"""Part by which they may have more and count as having no more than that."""
_MOST_ROOM = 0.85
"""Most back-off that this makes of it."""


def tightened_backoff(
    backoff: float, excess: float, unused: float, *, at_end: bool, before: tuple[float, float] | None = None
) -> float:
    """Back-off of a row for the next problem, a fraction of its budget below 1.

    Args:
        backoff: fraction of the budget that the last problem kept.
        excess: by which the judged motion exceeds the limit, as a fraction of it.
        unused: fraction of the budget that the last answer left unused, which the judge found used all the same.
        at_end: whether the row is about the final state. What that is allowed may change at once.
        before: of such a row, back-off of the problem before that, and the height that its answer had, over the limit.
            Where the step between them left most of a small excess, since modes outside the problem hardly fall with
            it, the secant asks for more.
    """
    most = _MOST_AT_END if at_end else _MOST
    step = min(_MORE * excess + _LEAST, most) + max(0.0, unused) / 2
    if before is not None and backoff > before[0] and is_stuck(excess, before[1] - 1.0) and excess < _SLIGHTLY_AT_END:
        fall = (before[1] - 1.0 - excess) / (backoff - before[0])
        longest = _BY_SECANT * step
        if fall > 0.0:  # a height that more back-off has raised is made by other waves
            step = max(step, longest if fall * longest < excess else excess / fall)
    return backoff + min(step, (1.0 - backoff) / 2)  # of a cone it is a difference of squares


def second_order_backoff(
    backoff: float, linear: float, second: float, allowed: float, before: tuple[float, float] | None = None
) -> float:
    """Back-off of a height of second order, of which the optimiser sees the linear part.

    What the second order adds grows with the square of the linear height, and this in proportion to what is left of the
    budget; heights are fractions of the limit. Where it adds far more than that, turns of the tray drive it, which fall
    with a tighter budget too, but hardly faster than that.

    Args:
        backoff: fraction of the budget that the last problem kept.
        linear: greatest linear height of its answer, as judged.
        second: greatest height of second order.
        allowed: what that may be.
        before: back-off of the problem before that, and the height of second order that its answer had. Where that is
            over by little, and the step between them brought next to nothing, the secant asks for more.
    """
    more = (_MORE - 1.0) * min(max(second - allowed, 0.0), _MOST_OVER)  # what it adds falls more slowly than that
    least, wanted = backoff + min(_LEAST, (1.0 - backoff) / 2), allowed - more - _FREE
    if second - linear > _DRIVEN_BY_TURNS * linear:
        found = max(1.0 - (1.0 - backoff) * (wanted - _SCATTER) / second, least)
    else:
        found = max(_backoff_for(backoff, linear, second, wanted), least)
    over = second - allowed
    if before is None or backoff <= before[0] or not _STUCK * (before[1] - allowed) < over < _SLIGHTLY_OVER:
        return found  # far from the limit a long step may end beside another optimum
    most = backoff + min(_BY_SECANT * (found - backoff), (1.0 - backoff) / 2)
    fall = (before[1] - second) / (backoff - before[0])
    return max(found, most if fall * (most - backoff) < second - wanted else backoff + (second - wanted) / fall)


def growth_by_order(linear: float, second: float) -> float:
    """How much more than the linear height one of second order falls with it; arguments as of `second_order_backoff`.

    own h + added h^2 at h = 1 falls by own + 2 added; where turns of the tray drive it, hardly faster than they do.
    """
    added = max(second - linear, 0.0) / max(linear, _LEAST)
    return 1.0 + min(2.0 * added, _DRIVEN_BY_TURNS)


def relaxed_second_order(backoff: float, linear: float, second: float, band: float = 0.0) -> float:
    """The same of a motion whose height of second order is far below its limit; arguments as there.

    Args:
        backoff: as there.
        linear: as there.
        second: as there.
        band: what arms of a band add to that height, over the limit.
    """
    if second + band > _WELL_BELOW:
        return backoff
    kept = band / growth_by_order(linear, second)
    enough = _backoff_for(backoff, linear, second, 1.0 - _LEFT - band, kept)
    return max(min(backoff + _RELAXED * (enough - backoff), backoff), 0.0)


def _backoff_for(backoff: float, linear: float, second: float, wanted: float, kept: float = 0.0) -> float:
    """Back-off with which the height of second order is the part `wanted` of its limit, beside a margin there."""
    added = max(second - linear, 0.0) / linear**2
    height = 2.0 * wanted / (1.0 + math.sqrt(1.0 + 4.0 * added * wanted))  # height + added height^2 = wanted
    left = max(1.0 - backoff - kept, _LEAST)
    ahead = max(linear / left, 1.0)  # of what the problem allowed: by modes and instants that it has not
    return 1.0 - kept - height / ahead


def relaxed_backoff(backoff: Mapping[RowId, float], uses: Mapping[RowId, float]) -> dict[RowId, float]:
    """Back-off of every row without most of what a judged motion shows to be more than it needs.

    That of the final state stays: the sum of all modes there does not go down in proportion to the row's bound.

    Args:
        backoff: fraction of each budget that the problem kept.
        uses: of the rows of what is in the problem, as judged.
    """
    unneeded = {row: max(1.0 - _LEFT - use, 0.0) for row, use in uses.items() if row.constraint not in END_NAMES}
    return {row: max(value - _RELAXED * unneeded.get(row, 0.0), 0.0) for row, value in backoff.items()}


def shared_backoff(
    backoff: Mapping[RowId, float], before: Mapping[RowId, float], uses: Mapping[RowId, float]
) -> dict[RowId, float]:
    """Back-off of every row; contacts near a limit get `_SHARE` of what the worst one of their constraint got.

    Objects on one tray feel the same motion: where one exceeds its limit between the nodes, its neighbours do so as
    soon as it no longer holds the motion back.

    Args:
        backoff: of every row, for the next problem, each for itself.
        before: of the last problem.
        uses: of the rows of what is in the problem, as judged.
    """
    most: dict[str, float] = {}
    for row, value in backoff.items():
        if row.constraint in _CONTACTS and value > before[row]:
            shared = before[row] + _SHARE * (value - before[row])
            most[row.constraint] = max(shared, most.get(row.constraint, 0.0))
    near = {row for row, use in uses.items() if use > 1.0 - _NEAR and row in backoff}
    return {row: max(value, most.get(row.constraint, 0.0)) if row in near else value for row, value in backoff.items()}


def is_saturated(backoff: float) -> bool:
    """Whether more of the back-off of a row on the final state would not do."""
    return backoff > _TOO_MUCH


def beyond_backoff(at_end: Mapping[RowId, float], backoff: Mapping[RowId, float], excess: float) -> float:
    """The largest use of a row on the final state where more back-off would not do; 0 where it may.

    Modes that the problem does not carry are over by themselves then, and jumps of the jerk make them swing.

    Args:
        at_end: uses of the rows on the final state, as judged.
        backoff: fraction of each budget that the problem kept.
        excess: by which they were over before that, as a fraction of the limit; 0 where they were not, or not known.
    """
    over = {row: use for row, use in at_end.items() if use > 1.0}
    most, tightest = max(over.values(), default=0.0), max((backoff[row] for row in over), default=0.0)
    return most if most > ROUGH or is_saturated(tightest) or is_stuck(most - 1.0, excess) else 0.0


def is_stuck(over: float, before: float) -> bool:
    """Whether a round of back-off has left most of an excess.

    Args:
        over: part of its limit by which a row is over it.
        before: the same before that round; 0 where it was not over, or not known.
    """
    return 0.0 < _STUCK * before < over


def backoff_with_room(backoff: float, linear: float) -> float:
    """Back-off of a residual height whose modes are to leave the second order its part of the limit.

    Args:
        backoff: fraction of the budget that the last problem kept.
        linear: height after the end by the modes alone, as judged, over the limit.
    """
    return max(backoff, min(1.0 - (1.0 - backoff) * _OWN / linear, _MOST_ROOM)) if linear > _OWN else backoff


def is_settled(backoff: float, linear: float) -> bool:
    """Whether more back-off of a residual height would not do: modes that the problem has not are what is left.

    Args:
        backoff: fraction of the budget that the last problem kept.
        linear: height after the end by the modes alone, as judged, over the limit.
    """
    return is_saturated(backoff) and linear > _OWN + _SPARE


def excess_of_order(linear: float, second: float, *, settled: bool) -> float:
    """How many times what the second order adds to a residual height is what the limit leaves it; 0 where it is kept.

    Args:
        linear: height after the end by the modes alone, as judged, over the limit.
        second: of second order, likewise.
        settled: as `is_settled` has it.
    """
    if second <= 1.0:
        return 0.0
    own = min(linear, 1.0 - _OWN if settled else _OWN)
    over = max(second - linear, 0.0) / (1.0 - own)
    return max(over, 1.0) if settled else over


def lower_crest_backoff(backoff: float, over: float) -> float:
    """Back-off of a slosh height with which what the second order adds is less by that part, as the crest's square."""
    return 1.0 - (1.0 - backoff) / math.sqrt(over) if over > 1.0 else backoff
