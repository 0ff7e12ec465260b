"""What the nonlinear flow leaves after the end of liquids whose waves of second order are states of the problem.

The optimiser stills the waves of its problem by their phase. What it cannot see are waves of the third order and above,
which fall with smoothness and with lower waves. So where the flow leaves too much, the jerks weigh more, and for the
last of it the row gets back-off. Offsets of the final state by what the flow has otherwise do not converge: a motion
that stills waves by others is rougher, and the offsets grow.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace

from nospill.certification.verdict import Row
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight

FIRST_BACKOFF = 0.5
"""Of the row on the final state: the optimiser has the root of the squares, the judge the flow's highest surface."""
_FAR_OVER, _SMOOTH_ENOUGH = 6.0, 3.0
"""Uses of a residual limit: from the first on waves are stilled by smoothness before they are states, to the second."""
_NEARLY, _SPENT = 1.2, 0.7
"""Use of the limit up to which back-off is enough, and back-off from which more of it would not be."""
_SHARE, _MOST_ROOM = 0.25, 0.75
"""Part of what back-off leaves the waves of the problem that they lose at once beside that, and the most of it."""
_STEEPLY, _AIM = 3.0, 0.95
"""Power of the crests with which waves of the third order grow, and the use that crests get room for; it scatters."""


def as_carried(row: Row) -> Row:
    """A row on the final state whose second order a problem has among its states: one like others; others as is."""
    return replace(row, linear_value=None) if row.at_end else row


def far_over(rows: Iterable[Row], driven: Collection[str]) -> bool:
    """Whether some of these objects leave so much after the end that no solve with their waves as states gets there."""
    return any(row.use > _FAR_OVER for row in _left(rows, driven))


def smooth_enough(rows: Iterable[Row], driven: Collection[str]) -> bool:
    """Whether a solve with the waves of these objects as states gets there from a smooth motion."""
    return all(row.use <= _SMOOTH_ENOUGH for row in _left(rows, driven))


def beyond_backoff_of_flow(rows: Iterable[Row], driven: Collection[str], backoff: Mapping[RowId, float]) -> float:
    """The largest use by the flow that back-off alone does not bring back; 0 where it does.

    Args:
        rows: as judged by the flow, by the names of the members.
        driven: members whose waves are states.
        backoff: of every row of the problem.
    """
    uses = (((row.size + row.shortfall) / row.size, backoff.get(row.id, 0.0)) for row in _left(rows, driven))
    return max((use for use, kept in uses if use > _NEARLY or (use > 1.0 and kept > _SPENT)), default=0.0)


def most_left(rows: Iterable[Row], driven: Collection[str]) -> float:
    """The largest use by the flow; 0 where it follows nothing. Arguments as of `beyond_backoff_of_flow`."""
    return max(((row.size + row.shortfall) / row.size for row in _left(rows, driven)), default=0.0)


def is_nearly_kept(use: float) -> bool:
    """Whether the flow leaves little more than a limit allows."""
    return use <= _NEARLY


def steadier_backoff(
    rows: Iterable[Row], driven: Collection[str], backoff: Mapping[RowId, float]
) -> dict[RowId, float]:
    """Back-off of every row with which the jerks then weigh more: of the rows that are over, a part of what they had.

    Arguments as of `beyond_backoff_of_flow`.
    """
    raised = dict(backoff)
    for row in {row.id for row in _left(rows, driven) if row.shortfall > 0.0} & backoff.keys():
        raised[row] = max(backoff[row], min(backoff[row] + _SHARE * (1.0 - backoff[row]), _MOST_ROOM))
    return raised


def relaxed_by_flow(
    relaxed: Mapping[RowId, float], rows: Iterable[Row], driven: Collection[str], backoff: Mapping[RowId, float]
) -> dict[RowId, float]:
    """Back-off of every row where a certified motion gets some back: of crests no less than what is left allows.

    What no state has grows with the cube of the crests, or faster.

    Args:
        relaxed: back-off as what is left does not count.
        rows: as judged by the flow, by the names of the members.
        driven: members whose waves are states.
        backoff: of every row of the problem that the motion is the answer of.
    """
    found = dict(relaxed)
    for row in _left(rows, driven):
        crest, use = RowId(SloshHeight.name, row.subject), (row.size + row.shortfall) / row.size
        if crest in found and crest in backoff:
            least = 1.0 - (1.0 - backoff[crest]) * (_AIM / use) ** (1.0 / _STEEPLY)
            found[crest] = max(found[crest], min(backoff[crest], least))
    return found


def _left(rows: Iterable[Row], driven: Collection[str]) -> Iterable[Row]:
    return (row for row in rows if row.constraint == ResidualHeight.name and row.subject in driven)
