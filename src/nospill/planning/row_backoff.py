"""Back-off of the rows of a problem, by what the judge finds of its answer: more where one is broken, less below."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from types import MappingProxyType

from nospill.certification.verdict import Row, condensed
from nospill.laws.constraints.base import RowId
from nospill.planning.tightening import (
    growth_by_order,
    relaxed_second_order,
    second_order_backoff,
    tightened_backoff,
)
from nospill.transcription.problem import WIDER

Crests = Mapping[RowId, tuple[float, float]]
"""Row of a height of second order, or of one after the end -> its back-off in a problem, and that height of its answer,
over the limit."""


def tightened(
    rows: Iterable[Row],
    active: Collection[RowId],
    backoff: Mapping[RowId, float],
    slack: Mapping[RowId, float],
    crests: Crests = MappingProxyType({}),
) -> tuple[dict[RowId, float], frozenset[RowId]]:
    """Back-off of every row for the next problem, and the rows that are broken without taking part in this one.

    Args:
        rows: that break their limits, by the names of the members.
        active: rows that take part.
        backoff: of every row that may.
        slack: part of its budget that each left unused.
        crests: of the round before.
    """
    joining, raised = set[RowId](), dict(backoff)
    for row in condensed(rows):
        key = row.id
        if key in active:
            raised[key] = _raised_backoff(row, raised[key], slack.get(key, 0.0), crests.get(key))
        elif key in raised:
            joining.add(key)
    return raised, frozenset(joining)


def without_ease(
    rows: Iterable[Row], backoff: Mapping[RowId, float], before: Mapping[RowId, float], until: float
) -> dict[RowId, float]:
    """Back-off of every row; what breaks where a motion from a state has wider rows gets half of what they are wider.

    Args:
        rows: that break their limits, by the names of the members.
        backoff: of every row, for the next problem.
        before: of the last problem.
        until: s, to which rows are wider.
    """
    early = {row.id for row in rows if row.at_s < until} & before.keys()
    return {row: max(value, (before[row] + WIDER) / 2) if row in early else value for row, value in backoff.items()}


def crests_of(rows: Iterable[Row], backoff: Mapping[RowId, float]) -> dict[RowId, tuple[float, float]]:
    """`Crests` of a judged motion; arguments as of `tightened`."""
    rows = list(rows)
    crests = {row.id: _parts(row)[1] for row in condensed(filter(_is_crest, rows))}
    after_end = {row.id: 1.0 + row.shortfall / row.size for row in condensed(filter(_by_modes_at_end, rows))}
    return {row: (backoff[row], height) for row, height in (crests | after_end).items() if row in backoff}


def _raised_backoff(row: Row, backoff: float, unused: float, before: tuple[float, float] | None = None) -> float:
    """Back-off of a broken row for the next problem."""
    if row.linear_value is None:
        return tightened_backoff(backoff, row.shortfall / row.size, unused, at_end=row.at_end, before=before)
    allowed = row.limit - row.shortfall - row.worst_margin  # less what a finer grid may find
    return second_order_backoff(backoff, *_parts(row), allowed / row.limit, before)


def backoff_by_order(rows: Iterable[Row], backoff: Mapping[RowId, float]) -> dict[RowId, float]:
    """Back-off of the broken rows of second order alone, whose excess over the linear law has just been seen.

    Arguments as of `tightened`.
    """
    broken = condensed(row for row in rows if _is_crest(row) and row.shortfall > 0.0)
    return {row.id: _raised_backoff(row, backoff[row.id], 0.0) for row in broken if row.id in backoff}


def relaxed_by_order(
    rows: Iterable[Row], backoff: Mapping[RowId, float], over: Mapping[RowId, float] = MappingProxyType({})
) -> dict[RowId, float]:
    """Back-off of the rows of second order, less where a motion stays far below their limits.

    Args:
        rows: as judged, by the names of the members.
        backoff: of every row of the problem.
        over: uses over a band of arms, where there is one.
    """
    found = condensed(row for row in rows if _is_crest(row) and row.id in backoff)
    added = {row.id: max(over.get(row.id, 0.0) - row.use, 0.0) for row in found}
    return {row.id: relaxed_second_order(backoff[row.id], *_parts(row), added[row.id]) for row in found}


def growths_by_order(rows: Iterable[Row]) -> dict[RowId, float]:
    """Of the heights of second order by how much more they fall than the linear heights that problems have."""
    return {row.id: growth_by_order(*_parts(row)) for row in condensed(filter(_is_crest, rows))}


def _is_crest(row: Row) -> bool:
    """Whether it is about a height of second order during the motion, which back-off lowers."""
    return row.linear_value is not None and not row.at_end


def _by_modes_at_end(row: Row) -> bool:
    """Whether it is about a height after the end that modes alone make."""
    return row.linear_value is None and row.of_liquid and row.at_end


def _parts(row: Row) -> tuple[float, float]:
    """Linear height and height of second order of a row, as parts of its limit."""
    assert row.linear_value is not None
    return row.linear_value / row.size, row.worst_value / row.size


def uses_of(rows: Iterable[Row]) -> dict[RowId, float]:
    """The largest use of each row."""
    uses: dict[RowId, float] = {}
    for row in rows:
        uses[row.id] = max(row.use, uses.get(row.id, 0.0))
    return uses
