"""What is left after the end to the second order, where it is too much and no problem has its waves.

The optimiser's row is about the modes, and so are back-off, members and modes that join. Smooth motions hardly leave
any waves of second order, so where the judge finds too many, the jerks weigh more. Where a problem has those waves
among its states, `driven_waves` has the rules.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from nospill.certification.verdict import Row
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.planning.tightening import (
    backoff_with_room,
    excess_of_order,
    is_settled,
    lower_crest_backoff,
)

_NEARLY = 1.3
"""Of what a limit leaves the second order; where motions are smoother already, crests a little lower do for less."""
_FAR_BELOW = 0.8
"""Use of a residual limit of second order below which the jerks may weigh less again."""


def by_modes(row: Row) -> Row:
    """A row on the final state of second order as the modes alone have it, as the optimiser sees it; others as is."""
    if not _is_left(row) or row.linear_value is None:
        return row
    margin = row.size - row.linear_value
    return replace(row, worst_value=row.linear_value, worst_margin=margin, ok=margin >= 0.0, linear_value=None)


def beyond_crests(rows: Iterable[Row], backoff: Mapping[RowId, float], *, smooth: bool) -> float:
    """What the second order leaves most too much of, over what the limit leaves it; 0 where lower crests are enough.

    What stirs its modes are quick changes of the waves that drive them: of a smooth motion they follow at once and are
    gone with them. So smoothness helps more than lower crests do, but for the last of it.

    Args:
        rows: as judged, by the names of the members.
        backoff: of every row of the problem.
        smooth: whether jerks weigh more than usual already.
    """
    found = [(_over(row, backoff), _settled(row, backoff)) for row in rows if _falls_short(row)]
    return max((over for over, settled in found if settled or over > _NEARLY or not smooth), default=0.0)


def taken_by_order(rows: Iterable[Row]) -> float:
    """Part that the second order takes of what limits on the final state leave it; 1 where nothing is to be changed."""
    left = [_uses(row) for row in rows if _is_left(row)]
    if not left or any(second > _FAR_BELOW for _, second in left):
        return 1.0
    return max(max(second - linear, 0.0) / (1.0 - linear) for linear, second in left)


def with_room(rows: Iterable[Row], backoff: Mapping[RowId, float]) -> dict[RowId, float]:
    """Back-off that leaves the second order its part of the limits on the final state.

    That of these rows, and where that is not enough of the crests; arguments as of `beyond_crests`.
    """
    raised = dict(backoff)
    for row in filter(_falls_short, rows):
        crest = RowId(SloshHeight.name, row.subject)
        if row.id in backoff:
            raised[row.id] = max(raised[row.id], backoff_with_room(backoff[row.id], _uses(row)[0]))
        if crest in backoff:
            raised[crest] = max(raised[crest], lower_crest_backoff(backoff[crest], _over(row, backoff)))
    return raised


def _over(row: Row, backoff: Mapping[RowId, float]) -> float:
    return excess_of_order(*_uses(row), settled=_settled(row, backoff))


def _settled(row: Row, backoff: Mapping[RowId, float]) -> bool:
    return is_settled(backoff.get(row.id, 1.0), _uses(row)[0])


def _is_left(row: Row) -> bool:
    return row.at_end and row.linear_value is not None


def _falls_short(row: Row) -> bool:
    return _is_left(row) and row.shortfall > 0.0


def _uses(row: Row) -> tuple[float, float]:
    """Height by the modes alone and of second order with what a finer grid may find, over the limit."""
    assert row.linear_value is not None
    return row.linear_value / row.size, (row.size + row.shortfall) / row.size
