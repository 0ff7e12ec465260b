"""Crests of a liquid along a motion: linear, to the second order, and of the full flow, with what they are worth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from nospill.potential_flow.basin import COARSE, Basin, basin_of, linear_basin
from nospill.potential_flow.integration import STEP_ANGLE, rows_at
from nospill.potential_flow.orders import LinearTerms, first_order, linear_terms
from nospill.potential_flow.solving import linear_flow, two_orders, whole_flow
from nospill.scene.cargo import Cargo
from nospill.scene.swing import coordinates

SAMPLING = 0.002
"""s between the instants of the crests."""
TRUSTED = 0.05
"""Largest difference of the highest crests with fewer and with more modes, relative, at which the flow is trusted."""
STEEPEST = 1.0
"""Largest slope at which the flow is trusted: the highest standing wave ends in a crest of 90 deg [Penney and Price
1952, found by Taylor 1953]; what is steeper in the flow's numbers breaks in water."""

_SPLINED = 4
"""States that a cubic spline needs."""

BodyRows = Callable[[np.ndarray], np.ndarray]
"""Times (m,), s -> angular velocity, angular acceleration and specific force of the bottom's centre, container axes,
(9, m)."""


@dataclass(frozen=True, slots=True)
class Crests:
    """Greatest heights round the wall over time, along the container's axis from the rest level.

    Attributes:
        t: (m,) s, on the clock of the motion.
        end: s, when the motion is over.
        linear: (m,) m, of the linear modes.
        second: (m,) m, to the second order.
        full: (n,) m, of the full flow, n < m where it breaks down.
        coarse: (n',) m, of the full flow with fewer modes.
        steepness: (n,) largest slope of the surface in the full flow, in axes of the container.
    """

    t: np.ndarray
    end: float
    linear: np.ndarray
    second: np.ndarray
    full: np.ndarray
    coarse: np.ndarray
    steepness: np.ndarray

    @property
    def breaks_at(self) -> float | None:
        """When the full flow breaks down, s; None if it goes through."""
        reached = min(len(self.full), len(self.coarse))
        return None if reached == len(self.t) else float(self.t[reached])

    @property
    def spread(self) -> float:
        """Relative difference of the highest crests with fewer modes and with more, until either breaks down."""
        reached = min(len(self.full), len(self.coarse))
        fine, coarse = (float(np.max(values[:reached], initial=0.0)) for values in (self.full, self.coarse))
        return abs(fine - coarse) / fine if fine > 0.0 else 0.0

    @property
    def steep_from(self) -> float | None:
        """When the surface of the full flow first is steeper than `STEEPEST`, s; None if it never is."""
        steep = self.steepness > STEEPEST
        return float(self.t[np.argmax(steep)]) if np.any(steep) else None

    @property
    def doubt(self) -> str | None:
        """Why the full flow is not to be trusted, as the end of a sentence; None where it is."""
        if self.breaks_at is not None:
            return f"the flow's numbers break down at {self.breaks_at:.2f} s"
        if self.steep_from is not None:
            return f"from {self.steep_from:.2f} s on the surface is steeper than 45 deg, where standing waves break"
        if self.spread > TRUSTED:
            return f"with fewer modes the highest crest is {1e2 * self.spread:.0f} % off"
        return None

    def highest(self, values: np.ndarray) -> tuple[float, float]:
        """Greatest height of one of the three, m, and when, s."""
        index = int(np.argmax(values))
        return float(values[index]), float(self.t[index])

    def after_end(self, values: np.ndarray) -> float | None:
        """Greatest height after the end of the motion, m; None of a flow that does not get there."""
        late = values[self.t[: len(values)] >= self.end]
        return float(np.max(late)) if len(values) == len(self.t) and len(late) else None


def crests_along(cargo: Cargo, rows: BodyRows, start: float, end: float, *, after: float) -> Crests:
    """Follow the liquid of a container.

    Args:
        cargo: of which `unsupported` says that it can be asked for.
        rows: motion of its container, at rest from `end` on.
        start: of the motion, s.
        end: of the motion, s.
        after: how long the liquid is followed beyond it, s.
    """
    t = start + SAMPLING * np.arange(int((end + after - start) / SAMPLING) + 1)
    wide, fine, coarse = (
        _driven(cargo, basin, rows, t) for basin in (linear_basin(cargo), basin_of(cargo), basin_of(cargo, COARSE))
    )
    linear = wide.wall(wide.first()) + wide.follows(rows(t))
    orders = two_orders(coarse.terms, coarse.begin, coarse.rows, coarse.step)
    second = linear + coarse.wall(orders[:, 1])
    full, fewer = (whole_flow(item.terms, item.begin, item.rows, item.step) for item in (fine, coarse))
    highest = [np.max(item, axis=1) for item in (linear, second)]
    for driven, course, first in ((fine, full, fine.first()), (coarse, fewer, orders[:, 0])):
        wall, fast = driven.wall(course), linear - driven.wall(first)  # fast: modes that the full flow does not carry
        highest.append(np.max(wall + fast[: len(wall)], axis=1))
    return Crests(t, end, *highest, steepness=_steepness(fine, full)[: len(highest[2])])


@dataclass(frozen=True, slots=True)
class _Driven:
    """A basin on its way: linear terms, state (2, J) at the start, rows (9, 2 m + 1) of steps s long, output times."""

    terms: LinearTerms
    begin: np.ndarray
    rows: np.ndarray
    step: float
    t: np.ndarray

    def first(self) -> np.ndarray:
        """States (m, 2, J) of the first order."""
        return linear_flow(self.terms, self.begin, self.rows, self.step)

    def wall(self, states: np.ndarray) -> np.ndarray:
        """Heights (n, V) at the wall of states (m, 2, J), at the output times that these reach."""
        heights = states[:, 0] @ self.terms.basin.modes.wall_shape.T
        instants = self.instants(states)
        if len(states) < _SPLINED:
            return heights[:1]
        return CubicSpline(instants, heights)(self.t[self.t <= instants[-1]])

    def follows(self, body: np.ndarray) -> np.ndarray:
        """Heights (m, V) at the wall of all modes that are not carried, which follow the apparent gravity at once."""
        basin = self.terms.basin
        force = rows_at(body, np.array([0.0, 0.0, basin.depth]))[6:]
        left = basin.modes.wall - basin.modes.wall_shape @ self.terms.place  # of x and y
        return -(force[:2] / force[2]).T @ left.T

    def instants(self, states: np.ndarray) -> np.ndarray:
        """Of states, s."""
        return self.t[0] + self.step * np.arange(len(states))


def _driven(cargo: Cargo, basin: Basin, rows: BodyRows, t: np.ndarray) -> _Driven:
    step = STEP_ANGLE / float(np.max(basin.frequency))
    count = int(np.ceil((t[-1] - t[0]) / step)) + 1
    along = rows_at(rows(t[0] + step / 2 * np.arange(2 * count + 1)), np.array([0.0, 0.0, basin.depth]))
    terms = linear_terms(basin)
    return _Driven(terms, _start(cargo, terms, along[:, 0]), along, step, t)


def _steepness(driven: _Driven, states: np.ndarray) -> np.ndarray:
    """Largest slope of the surface (m,) at the output times."""
    slope = np.einsum("xpj,nj->xnp", driven.terms.basin.modes.slope, states[:, 0], optimize=True)
    return np.interp(driven.t, driven.instants(states), np.max(np.hypot(*slope), axis=1))


def _start(cargo: Cargo, terms: LinearTerms, row: np.ndarray) -> np.ndarray:
    """State (2, J) when the motion begins: level and at rest, or the swing that the scene states."""
    state = np.zeros((2, len(terms.stiffness)))
    filling = cargo.filling
    if filling is None or filling.initial_swing is None:
        return state
    height, rate = np.zeros(state.shape[1]), np.zeros(state.shape[1])
    displaced, moving = coordinates(filling.initial_swing, filling.oscillators)
    modes, column = terms.basin.modes, 0
    for mode in filling.oscillators:
        for direction in mode.directions:
            near = np.isclose(modes.wave_number, mode.wave_number, rtol=1e-6)
            share = np.ones(state.shape[1]) if mode.yaws else np.abs(terms.place[:, "xy".index(direction)])
            if np.any(near):
                index = int(np.argmax(np.where(near, share, -1.0)))
                height[index] += mode.surface_gain * displaced[column]
                rate[index] += mode.surface_gain * moving[column]
            column += 1
    state[0] = height
    state[1] = (rate - first_order(terms, state, np.r_[row[:3], np.zeros(6)])[0]) / terms.stiffness
    return state
