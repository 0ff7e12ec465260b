"""Constraint tightening: how much more of a budget is kept from the optimiser once the judge finds a row violated."""

from __future__ import annotations

from nospill.laws.constraints.base import EvaluationPoint

_MORE, _LEAST = 1.5, 3e-4
_MOST, _MOST_AT_END = 0.1, 0.3


def tightened_backoff(backoff: float, excess: float, unused: float, point: EvaluationPoint) -> float:
    """Back-off of a row for the next problem, a fraction of its budget below 1.

    Args:
        backoff: fraction of the budget that the last problem kept.
        excess: by which the judged motion exceeds the limit, as a fraction of it.
        unused: fraction of the budget that the last answer left unused, which the judge found used all the same.
        point: of the motion at which the row is evaluated. What the final state is allowed may change at once.
    """
    most = _MOST_AT_END if point is EvaluationPoint.END else _MOST
    step = min(_MORE * excess + _LEAST, most)
    return backoff + min(step + max(0.0, unused) / 2, (1.0 - backoff) / 2)  # of a cone it is a difference of squares
