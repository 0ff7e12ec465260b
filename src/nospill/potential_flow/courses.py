"""A basin on a given motion: rows at the flow's own steps, the state it starts from, heights at the wall over time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nospill.potential_flow.basin import Basin
from nospill.potential_flow.driven import height_gains
from nospill.potential_flow.integration import STEP_ANGLE, rows_at
from nospill.potential_flow.orders import LinearTerms, first_order, linear_terms
from nospill.potential_flow.solving import linear_flow
from nospill.scene.cargo import Cargo
from nospill.scene.swing import coordinates

_SPLINED = 4
"""States that a cubic spline needs."""

BodyRows = Callable[[np.ndarray], np.ndarray]
"""Times (m,), s -> angular velocity, angular acceleration and specific force of the bottom's centre, container axes,
(9, m)."""


@dataclass(frozen=True, slots=True)
class Course:
    """A basin on its way.

    Attributes:
        terms: of the basin.
        begin: (2, J) state at the start.
        rows: (9, 2 m + 1) at the ends and middles of the flow's steps, about the middle of the rest surface.
        step: s.
        t: (n,) s, when heights are asked for; the first is the start.
    """

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
        from scipy.interpolate import CubicSpline  # slow to load

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


def course_of(cargo: Cargo, basin: Basin, rows: BodyRows, t: np.ndarray) -> Course:
    """A liquid with the modes of a basin along the motion of its container, heights wanted at t (n,), s."""
    step = STEP_ANGLE / float(np.max(basin.frequency))
    count = int(np.ceil((t[-1] - t[0]) / step)) + 1
    along = rows_at(rows(t[0] + step / 2 * np.arange(2 * count + 1)), np.array([0.0, 0.0, basin.depth]))
    terms = linear_terms(basin)
    return Course(terms, _start(cargo, terms, along[:, 0]), along, step, t)


def _start(cargo: Cargo, terms: LinearTerms, row: np.ndarray) -> np.ndarray:
    """State (2, J) when the motion begins: level and at rest, or the swing that the scene states."""
    state = np.zeros((2, len(terms.stiffness)))
    filling = cargo.filling
    if filling is None or filling.initial_swing is None:
        return state
    gains = height_gains(filling.oscillators, terms.basin)
    state[0], rate = coordinates(filling.initial_swing, filling.oscillators) @ gains.T
    state[1] = (rate - first_order(terms, state, np.r_[row[:3], np.zeros(6)])[0]) / terms.stiffness
    return state
