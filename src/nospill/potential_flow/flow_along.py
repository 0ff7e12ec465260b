"""The nonlinear flow of several liquids along a motion, from rest or from what another motion has left of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from nospill.core.units import as_written
from nospill.errors import ModelError
from nospill.potential_flow.basin import FINE, SAME_WAVE, basin_of
from nospill.potential_flow.driven import LiquidKey, height_gains
from nospill.potential_flow.integration import rows_at
from nospill.potential_flow.orders import LinearTerms, linear_terms
from nospill.potential_flow.solving import flow_states
from nospill.scene.cargo import Cargo
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.swing import coordinates

_STEP_ANGLE = 0.4
"""Largest step, rad of the fastest mode: what is left is within 1 % of that with a third of it. With 0.5 and more some
flows of a third of the radius break down that do not with smaller steps. In syrups the damping is faster than
the modes, most on high crests."""
_OF_DAMPING = 4.0
"""Rate at which the damping acts on crests of 0.3 of the radius over zeta omega: with half of it syrups break down."""


@dataclass(frozen=True, slots=True)
class FlowAlong:
    """A liquid along a motion.

    Attributes:
        states: (n, 2, J) heights, m, and potentials, m^2/s, in the modes of `flow_terms`, at even instants from the
            first one on, as far as the flow goes.
        step: s, between them.
        breaks_at: when the flow breaks down, s; None of one that goes through.
    """

    states: np.ndarray
    step: float
    breaks_at: float | None

    @property
    def end(self) -> np.ndarray:
        """(2, J) at the last instant of the motion; NaN where the flow breaks down."""
        return self.states[-1] if self.breaks_at is None else np.full_like(self.states[-1], np.nan)


def flow_terms(cargo: Cargo, finest: float = FINE) -> LinearTerms:
    """The terms of a liquid in the modes of its nonlinear flow; arguments as of `basin_of`."""
    return _terms_like(LiquidKey(cargo), finest)


@lru_cache(maxsize=32)
def _terms_like(key: LiquidKey, finest: float) -> LinearTerms:
    return linear_terms(basin_of(key.cargo, finest))


def flows_along(objects: Sequence[Cargo], t: np.ndarray, body: np.ndarray, finest: float = FINE) -> list[FlowAlong]:
    """The flow of each liquid.

    Args:
        objects: with the liquids; each begins with its initial swing, at rest where it has none. Cups are followed
            together, and like boxes.
        t: (m,) s.
        body: (9, m) angular velocity, angular acceleration and specific force of the tray, its axes.
        finest: largest wave number over that of the slowest mode.
    """
    together: dict[LiquidKey | None, list[int]] = {}
    for index, cargo in enumerate(objects):
        together.setdefault(None if isinstance(cargo.container, Cylinder) else LiquidKey(cargo), []).append(index)
    found: dict[int, FlowAlong] = {}
    for places in together.values():
        own = [objects[place] for place in places]
        terms = [flow_terms(cargo, finest) for cargo in own]
        counts = [int(np.ceil(float(t[-1] - t[0]) * _fastest(one) / _STEP_ANGLE)) for one in terms]
        step = np.array([2.0 * _instants(t, count)[1] for count in counts])
        along = [_rows(*one, t, body, max(counts)) for one in zip(own, terms, counts, strict=True)]
        start = np.stack([_beginning(*one) for one in zip(own, terms, strict=True)])
        states, reached = flow_states(terms, start, np.stack(along, axis=-1), step)
        for index, place in enumerate(places):
            steps = min(int(reached[index]), counts[index])
            breaks_at = None if steps == counts[index] else float(t[0] + steps * step[index])
            found[place] = FlowAlong(states[: steps + 1, index], float(step[index]), breaks_at)
    return [found[index] for index in range(len(objects))]


def of_masses(cargo: Cargo, terms: LinearTerms, displacement: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Heights, m, and potentials, m^2/s, of the modes of a flow that modal masses move, (..., 2, J).

    Args:
        cargo: whose liquid.
        terms: of its flow.
        displacement: (..., k) of the masses, m.
        velocity: (..., k) likewise, m/s.
    """
    gains = height_gains(cargo.oscillators, terms.basin).T
    return np.stack([displacement @ gains, velocity @ gains / terms.stiffness], axis=-2)


def _beginning(cargo: Cargo, terms: LinearTerms) -> np.ndarray:
    """(2, J) state at the first instant: what the initial swing moves, and what its flow has beyond that."""
    swing = None if cargo.filling is None else cargo.filling.initial_swing
    if swing is None:
        return np.zeros((2, len(terms.stiffness)))
    beyond = np.array([swing.flow_height, swing.flow_potential])
    known = flow_terms(cargo).basin.modes.wave_number
    if beyond.shape != (2, len(known)):
        raise ModelError(
            f"cargo {as_written(cargo.name)}: initial_swing has the flow in {beyond.shape[1]} modes; its liquid has "
            f"{len(known)}"
        )
    carried = known <= np.max(terms.basin.modes.wave_number) * (1.0 + SAME_WAVE)
    return of_masses(cargo, terms, *coordinates(swing, cargo.oscillators)) + beyond[:, carried]


def _fastest(terms: LinearTerms) -> float:
    """Rate of what is fastest in a liquid, a mode or its damping, 1/s."""
    basin = terms.basin
    return float(np.max(basin.frequency * np.maximum(1.0, _OF_DAMPING * basin.damping)))


def _instants(t: np.ndarray, count: int) -> np.ndarray:
    """Ends and middles of even steps (2 count + 1,), s from the first instant on."""
    return np.linspace(0.0, t[-1] - t[0], 2 * count + 1)


def _rows(cargo: Cargo, terms: LinearTerms, count: int, t: np.ndarray, body: np.ndarray, most: int) -> np.ndarray:
    """Rows (9, 2 most + 1) of a liquid in `count` steps; after the last one it goes on for nothing as it is then."""
    rows = _at(_instants(t, count), t - t[0], body)
    surface = np.array([0.0, 0.0, terms.basin.depth])
    own = rows_at(rows_at(rows, cargo.place, cargo.yaw), surface)
    return np.pad(own, ((0, 0), (0, 2 * (most - count))), mode="edge")


def _at(instants: np.ndarray, t: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Rows (k, m), straight between times (m,), at even instants (n,), s: (k, n).

    Not samples, in which what is faster than the steps, as of joints that are recorded with few digits, would look like
    something slow: means under a hat as wide as two intervals, over which such things cancel, less a twelfth of their
    second difference, which the mean of anything slow is off by. Before and after the motion rows stay as they are.
    """
    width = float(instants[1] - instants[0])
    t = np.concatenate([[t[0] - 3.0 * width], t, [t[-1] + 3.0 * width]])
    rows = np.pad(rows, ((0, 0), (1, 1)), mode="edge")
    steps, rises = np.diff(t), np.diff(rows)
    once = _summed(0.5 * steps * (rows[:, 1:] + rows[:, :-1]))
    twice = _summed(steps * (once[:, :-1] + steps * (rows[:, :-1] / 2.0 + rises / 6.0)))
    places = instants[0] + width * np.arange(-2, len(instants) + 2)
    at = np.searchsorted(t, places, side="right") - 1
    after = places - t[at]
    slopes = rises[:, at] / steps[at]
    means = np.diff(twice[:, at] + after * (once[:, at] + after * (rows[:, at] / 2.0 + after * slopes / 6.0)), 2)
    means /= width**2
    return means[:, 1:-1] - np.diff(means, 2) / 12.0


def _summed(parts: np.ndarray) -> np.ndarray:
    """Sums (k, n + 1) of parts (k, n), the first of none."""
    return np.pad(np.cumsum(parts, axis=1), ((0, 0), (1, 0)))
