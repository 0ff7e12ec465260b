"""How soon a chain of integrators comes to rest at zero with a bounded last derivative: linear programs over time."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import linprog

_STEP = 0.01
"""s; the bound is a multiple of it, the last one in which rest cannot be reached."""
_LONGEST = 5.0
"""s; nothing that is planned takes longer to come to rest."""


def soonest_rest(state: np.ndarray, most: float, largest: float = math.inf, *, above: float = 0.0) -> float:
    """The longest time of a grid, s, in which a chain cannot come to rest at zero.

    Args:
        state: (k,) value and its derivatives; the derivative after the last one is the input.
        most: largest input.
        largest: bound on the value on the way.
        above: s; a shorter time is of no interest, and 0 is the answer: one program in the place of a search.
    """
    low = int(above / _STEP)
    if not np.any(state) or (low and _rests(state, most, largest, low)):
        return 0.0
    high = max(1, 2 * low)
    while not _rests(state, most, largest, high) and high * _STEP < _LONGEST:
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if _rests(state, most, largest, middle) else (middle, high)
    return low * _STEP


def _rests(state: np.ndarray, most: float, largest: float, steps: int) -> bool:
    count = len(state)
    step = np.array([[_power(column - row) for column in range(count)] for row in range(count)])
    push = np.array([_power(count - row) for row in range(count)])
    drift, reach, values, offsets = state, np.zeros((count, steps)), [], []
    for number in range(steps):
        drift, reach = step @ drift, step @ reach
        reach[:, number] = push
        values.append(reach[0].copy())
        offsets.append(drift[0])
    table, offset = np.array(values), np.array(offsets)
    bounded = math.isfinite(largest)
    found = linprog(
        np.zeros(steps),
        A_ub=np.vstack([table, -table]) if bounded else None,
        b_ub=np.concatenate([largest - offset, largest + offset]) if bounded else None,
        A_eq=reach,
        b_eq=-drift,
        bounds=(-most, most),
        method="highs",
    )
    return found.status == 0


def _power(order: int) -> float:
    """Of a Taylor series over a step; none of negative order."""
    return _STEP**order / math.factorial(order) if order >= 0 else 0.0
