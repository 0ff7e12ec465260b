"""Runge-Kutta steps of the flow along a motion, until it ends or the flow does."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

STEP_ANGLE = 0.3
"""Largest step, rad of the fastest mode; classical Runge-Kutta then loses 1e-5 of that mode in a period, of the slowest
less than 1e-8."""


def runge_kutta(
    rate: Callable[[np.ndarray, np.ndarray], np.ndarray],
    start: np.ndarray,
    rows: np.ndarray,
    step: float,
    *,
    holds: Callable[[np.ndarray], bool] = lambda state: bool(np.all(np.isfinite(state))),
) -> np.ndarray:
    """States (m + 1, ...) at the ends of m steps, fewer where a state no longer holds: the last one then still does.

    Args:
        rate: of a state along a row.
        start: the first state.
        rows: (9, 2 m + 1) at the ends and middles of the steps, of several containers (9, 2 m + 1, c).
        step: s.
        holds: whether a state is one of a flow.
    """
    states = [start]
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        for index in range(rows.shape[1] // 2):
            first, middle, last = (rows[:, 2 * index + place] for place in range(3))
            state = states[-1]
            k1 = rate(state, first)
            k2 = rate(state + step / 2 * k1, middle)
            k3 = rate(state + step / 2 * k2, middle)
            k4 = rate(state + step * k3, last)
            state = state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            if not holds(state):
                break
            states.append(state)
    return np.array(states)


def rows_at(body: np.ndarray, place: np.ndarray, yaw: float = 0.0) -> np.ndarray:
    """Rows (9, m) about a point as rows about `place` (3,), m, in the same axes, then in axes turned by `yaw`, rad."""
    (p, q, r), (a, b, c), force = body[:3], body[3:6], body[6:]
    x, y, z = (float(part) for part in place)
    along, square = x * p + y * q + z * r, p * p + q * q + r * r  # omega x (omega x d) = (omega d) omega - omega^2 d
    there = np.empty_like(body)
    there[:6] = body[:6]
    there[6] = force[0] + (b * z - c * y + along * p - square * x)
    there[7] = force[1] + (c * x - a * z + along * q - square * y)
    there[8] = force[2] + (a * y - b * x + along * r - square * z)
    if yaw:
        cosine, sine = np.cos(yaw), np.sin(yaw)
        for vector in there[:3], there[3:6], there[6:]:
            vector[:2] = cosine * vector[0] + sine * vector[1], cosine * vector[1] - sine * vector[0]
    return there
