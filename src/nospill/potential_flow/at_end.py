"""The nonlinear flow of several liquids along a motion from rest: their states when the containers stand again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from nospill.potential_flow.basin import basin_of
from nospill.potential_flow.driven import LiquidKey
from nospill.potential_flow.integration import rows_at
from nospill.potential_flow.orders import LinearTerms, linear_terms
from nospill.potential_flow.solving import flow_ends
from nospill.scene.cargo import Cargo

_STEP_ANGLE = 0.4
"""Largest step, rad of the fastest mode: what is left is within 1 % of that with a third of it. With 0.5 and more some
flows of a third of the radius break down that do not with smaller steps."""


@dataclass(frozen=True, slots=True)
class AtEnd:
    """A liquid when its container stands again.

    Attributes:
        state: (2, J) heights, m, and potentials, m^2/s, in the modes of `flow_terms`; NaN where its flow breaks down.
        breaks_at: when that is, s; None of a flow that goes through.
    """

    state: np.ndarray
    breaks_at: float | None


def flow_terms(cargo: Cargo) -> LinearTerms:
    """The terms of a liquid in all modes of its nonlinear flow; `unsupported` says whether they may be asked for."""
    return _terms_like(LiquidKey(cargo))


@lru_cache(maxsize=32)
def _terms_like(key: LiquidKey) -> LinearTerms:
    return linear_terms(basin_of(key.cargo))


def states_at_end(objects: Sequence[Cargo], t: np.ndarray, body: np.ndarray) -> list[AtEnd]:
    """Each liquid at the last instant.

    Args:
        objects: with the liquids, at rest at the first instant; like ones are followed together.
        t: (m,) s.
        body: (9, m) angular velocity, angular acceleration and specific force of the tray, its axes.
    """
    alike: dict[LiquidKey, list[int]] = {}
    for index, cargo in enumerate(objects):
        alike.setdefault(LiquidKey(cargo), []).append(index)
    found: dict[int, AtEnd] = {}
    for key, places in alike.items():
        terms = _terms_like(key)
        count = int(np.ceil((t[-1] - t[0]) * float(np.max(terms.basin.frequency)) / _STEP_ANGLE))
        instants = np.linspace(t[0], t[-1], 2 * count + 1)
        rows = np.stack([np.interp(instants, t, row) for row in body])
        surface = np.array([0.0, 0.0, terms.basin.depth])
        own = [rows_at(rows_at(rows, objects[place].place, objects[place].yaw), surface) for place in places]
        ends, reached = flow_ends(terms, np.stack(own, axis=-1), float(instants[2] - instants[0]))
        for place, state, steps in zip(places, ends, reached.tolist(), strict=True):
            found[place] = AtEnd(state, None if np.all(np.isfinite(state)) else float(instants[2 * steps]))
    return [found[index] for index in range(len(objects))]
