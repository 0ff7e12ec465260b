"""Crests of a liquid along a motion: linear, to the second order, and of the full flow, with what they are worth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.potential_flow.basin import COARSE, Basin, basin_of, linear_basin
from nospill.potential_flow.courses import BodyRows, Course, course_of
from nospill.potential_flow.solving import two_orders, whole_flow
from nospill.scene.cargo import Cargo

SAMPLING = 0.002
"""s between the instants of the crests."""
TRUSTED = 0.05
"""Largest difference of the highest crests with fewer and with more modes, relative, at which the flow is trusted."""
STEEPEST = 1.0
"""Largest slope at which the flow is trusted: the highest standing wave ends in a crest of 90 deg [Penney and Price
1952, found by Taylor 1953]; what is steeper in the flow's numbers breaks in water."""


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
    def doubt(self) -> str | None:
        """Why the full flow is not to be trusted, as the end of a sentence; None where it is."""
        return doubt_of(self.breaks_at, self.t[: len(self.steepness)], self.steepness, self.spread)

    def highest(self, values: np.ndarray) -> tuple[float, float]:
        """Greatest height of one of the three, m, and when, s."""
        index = int(np.argmax(values))
        return float(values[index]), float(self.t[index])

    def after_end(self, values: np.ndarray) -> float | None:
        """Greatest height after the end of the motion, m; None of a flow that does not get there."""
        late = values[self.t[: len(values)] >= self.end]
        return float(np.max(late)) if len(values) == len(self.t) and len(late) else None


def doubt_of(breaks_at: float | None, t: np.ndarray, slopes: np.ndarray, spread: float) -> str | None:
    """Why a full flow is not to be trusted, as the end of a sentence; None where it is.

    Args:
        breaks_at: when it breaks down with more modes or with fewer, s; None where it goes through with both.
        t: (n,) s.
        slopes: (n,) largest slope of the surface then.
        spread: relative difference of the highest crests with fewer modes and with more.
    """
    if breaks_at is not None:
        return f"the flow's numbers break down at {breaks_at:.2f} s"
    steep = slopes > STEEPEST
    if np.any(steep):
        since = float(t[np.argmax(steep)])
        return f"from {since:.2f} s on the surface is steeper than 45 deg, where standing waves break"
    return f"with fewer modes the highest crest is {1e2 * spread:.0f} % off" if spread > TRUSTED else None


def largest_slopes(basin: Basin, states: np.ndarray) -> np.ndarray:
    """Largest slope of the surface (n,) in axes of the container, of states (n, 2, J)."""
    slope = np.einsum("xpj,nj->xnp", basin.modes.slope, states[:, 0], optimize=True)
    found: np.ndarray = np.max(np.hypot(*slope), axis=1)
    return found


def crests_along(cargo: Cargo, rows: BodyRows, start: float, end: float, *, after: float) -> Crests:
    """Follow the liquid of a container.

    Args:
        cargo: of which `unsupported` says that it can be asked for.
        rows: motion of its container, at rest from `end` on.
        start: of the motion, s.
        end: of the motion, s.
        after: how long the liquid is followed beyond it, s.
    """
    t = sampled(start, end + after)
    wide, fine, coarse = (
        course_of(cargo, basin, rows, t) for basin in (linear_basin(cargo), basin_of(cargo), basin_of(cargo, COARSE))
    )
    linear = wide.wall(wide.first()) + wide.follows(rows(t))
    orders = two_orders(coarse.terms, coarse.begin, coarse.rows, coarse.step)
    second = linear + coarse.wall(orders[:, 1])
    full, fewer = (whole_flow(item.terms, item.begin, item.rows, item.step) for item in (fine, coarse))
    highest = [np.max(item, axis=1) for item in (linear, second)]
    for course, states, first in ((fine, full, fine.first()), (coarse, fewer, orders[:, 0])):
        wall, fast = course.wall(states), linear - course.wall(first)  # fast: modes that the full flow does not carry
        highest.append(np.max(wall + fast[: len(wall)], axis=1))
    return Crests(t, end, *highest, steepness=_steepness(fine, full)[: len(highest[2])])


@dataclass(frozen=True, slots=True)
class SecondOrder:
    """Crests of the first and of both orders alone, in a fraction of the time.

    Attributes:
        t: (m,) s, on the clock of the motion.
        end: s, when the motion is over.
        linear: (m,) m, of the linear modes.
        second: (m,) m, to the second order.
    """

    t: np.ndarray
    end: float
    linear: np.ndarray
    second: np.ndarray

    @property
    def highest(self) -> tuple[float, float]:
        """Greatest height to the second order, m, and when, s."""
        index = int(np.argmax(self.second))
        return float(self.second[index]), float(self.t[index])

    @property
    def after_end(self) -> float:
        """Greatest height to the second order after the end of the motion, m."""
        return float(np.max(self.second[self.t >= self.end], initial=0.0))


def second_order_along(cargo: Cargo, rows: BodyRows, start: float, end: float, *, after: float) -> SecondOrder:
    """Follow the liquid of a container to the second order; arguments as of `crests_along`."""
    t = sampled(start, end + after)
    wide, coarse = (course_of(cargo, basin, rows, t) for basin in (linear_basin(cargo), basin_of(cargo, COARSE)))
    linear = wide.wall(wide.first()) + wide.follows(rows(t))
    orders = two_orders(coarse.terms, coarse.begin, coarse.rows, coarse.step)
    return SecondOrder(t, end, np.max(linear, axis=1), np.max(linear + coarse.wall(orders[:, 1]), axis=1))


def sampled(start: float, end: float) -> np.ndarray:
    """Instants (m,) of the crests, s."""
    return start + SAMPLING * np.arange(int((end - start) / SAMPLING) + 1)


def _steepness(course: Course, states: np.ndarray) -> np.ndarray:
    """Largest slope of the surface (m,) at the output times."""
    return np.interp(course.t, course.instants(states), largest_slopes(course.terms.basin, states))
