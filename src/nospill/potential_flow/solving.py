"""The flow along a motion: of first order, of both orders, and in full.

Rows are (9, 2 m + 1) at the ends and middles of m steps, about the middle of the rest surface.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from nospill.core.hermite import cubic_hermite
from nospill.potential_flow.basin import Basin
from nospill.potential_flow.compiled_sections import compiled_sections
from nospill.potential_flow.compiled_steps import Steps, compiled_steps
from nospill.potential_flow.integration import runge_kutta
from nospill.potential_flow.nonlinear import full_flow, room_of
from nospill.potential_flow.orders import LinearTerms, first_order, second_order, second_order_sources

_CHECKED = 20
"""Steps after which states are looked at."""
_HIGHEST = 1.84
"""Heights over 1/k of the slowest mode, a cup's radius, from which on a state is none of a flow any more."""


def linear_flow(terms: LinearTerms, start: np.ndarray, rows: np.ndarray, step: float) -> np.ndarray:
    """States (m + 1, 2, J) of the first order from its state (2, J) at the start, steps of `step` s."""
    return runge_kutta(lambda state, row: first_order(terms, state, row), start, rows, step)


def two_orders(
    terms: LinearTerms, start: np.ndarray, rows: np.ndarray, step: float, *, addition: np.ndarray | None = None
) -> np.ndarray:
    """States (m + 1, 2, 2, J) of the first and of the second order.

    Args:
        terms: of the basin.
        start: (2, J) state of the first order.
        rows: of the motion.
        step: s.
        addition: (2, J) state of the second order at the start; none by default.
    """
    first = linear_flow(terms, start, rows, step)
    sources = second_order_sources(terms, _with_middles(terms, first, rows, step), rows)
    count = sources.shape[2]
    along = np.concatenate([rows, sources.reshape(len(sources), -1).T])  # the sources go along with the motion

    def rate(state: np.ndarray, row: np.ndarray) -> np.ndarray:
        return second_order(terms, state, row[9:].reshape(2, count), row[:9])

    begin = np.zeros_like(start) if addition is None else addition
    return np.stack([first, runge_kutta(rate, begin, along, step)], axis=1)


def _with_middles(terms: LinearTerms, states: np.ndarray, rows: np.ndarray, step: float) -> np.ndarray:
    """States (m + 1, 2, J) of the first order at the ends of steps and in their middles, by cubics: (2 m + 1, 2, J)."""
    rates = first_order(terms, states, rows[:, ::2])
    dense = np.empty((2 * len(states) - 1, *states.shape[1:]))
    dense[::2] = states
    dense[1::2] = cubic_hermite(0.5, step, np.stack([states[:-1], states[1:]]), np.stack([rates[:-1], rates[1:]]))
    return dense


def whole_flow(terms: LinearTerms, start: np.ndarray, rows: np.ndarray, step: float) -> np.ndarray:
    """States (n, 2, J) of the full flow, n <= m + 1: as far as it goes."""
    parts = [start[None, None]]
    for states, holds in _followed([terms], parts[0][0], rows[..., None], np.array([step])):
        parts.append(states[1:] if np.all(holds) else states[1 : np.argmin(holds[:, 0])])
        if not np.all(holds):
            break
    return np.concatenate(parts)[:, 0]


def flow_states(
    terms: Sequence[LinearTerms], start: np.ndarray, rows: np.ndarray, step: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """States (m + 1, c, 2, J) of the full flow of c containers along a motion.

    Args:
        terms: (c,) of the basin of each: cups with the same waves, of any size and depth, or like boxes.
        start: (c, 2, J) heights, m, and potentials, m^2/s, when it begins.
        rows: (9, 2 m + 1, c).
        step: (c,) s.

    Returns:
        Them, NaN from where the flow of a container has broken down on, and the steps (c,) that each goes through.
    """
    count, places = rows.shape[1] // 2, rows.shape[2]
    found = np.full((count + 1, places, 2, len(terms[0].stiffness)), np.nan)
    found[0] = start
    reached, gone = np.full(places, count), 0
    for states, holds in _followed(terms, found[0], rows, step):
        found[gone + 1 : gone + len(states)] = states[1:]
        through = np.maximum(gone + np.argmin(holds, axis=0) - 1, 0)
        reached = np.where(np.all(holds, axis=0), reached, np.minimum(reached, through))
        gone += len(states) - 1
    for place, steps in enumerate(reached.tolist()):
        found[steps + 1 :, place] = np.nan
    return found, reached


def _followed(
    terms: Sequence[LinearTerms], state: np.ndarray, rows: np.ndarray, step: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """States (n + 1, c, 2, J) of the full flow, some steps at a time, and whether each is one of a flow (n + 1, c).

    A container whose flow has broken down goes on as NaN, until all have.
    """
    shape = terms[0].basin.modes.shape  # of discs of any size
    highest = np.array([greatest_height(one.basin) for one in terms])
    compiled = compiled_sections if terms[0].basin.modes.polar is None else compiled_steps
    steps = compiled(terms) or _interpreted_steps(terms)
    for first in range(0, rows.shape[1] - 1, 2 * _CHECKED):
        states = steps(state, rows[:, first : first + 2 * _CHECKED + 1], step)
        with np.errstate(invalid="ignore"):
            holds = np.max(np.abs(states[:, :, 0] @ shape.T), axis=2) < highest
        yield states, holds
        lost = ~np.all(holds, axis=0)
        if np.all(lost):
            break
        state = np.where(lost[:, None, None], np.nan, states[-1])


def _interpreted_steps(terms: Sequence[LinearTerms]) -> Steps:
    """Steps of containers as `compiled_steps` has them, of any shape; like ones together."""
    alike: dict[int, list[int]] = {}
    for index, one in enumerate(terms):
        alike.setdefault(id(one), []).append(index)
    rooms = {places[0]: room_of(terms[places[0]].basin, len(places)) for places in alike.values()}

    def steps(start: np.ndarray, rows: np.ndarray, step: np.ndarray) -> np.ndarray:
        states = np.empty((rows.shape[1] // 2 + 1, *start.shape))
        for first, *others in alike.values():
            places, rate = [first, *others], partial(full_flow, terms[first], room=rooms[first])
            states[:, places] = runge_kutta(rate, start[places], rows[..., places], step[first], holds=lambda _: True)
        return states

    return steps


def greatest_height(basin: Basin) -> float:
    """Height from which on a state is none of a flow any more, m."""
    return min(basin.depth, _HIGHEST / float(np.min(basin.modes.wave_number)))
