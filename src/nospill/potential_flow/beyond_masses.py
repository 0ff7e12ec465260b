"""Heights that the modal masses of a liquid leave out, along a motion from rest, in the modes of its problem."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from nospill.potential_flow.driven import Driven, LiquidKey, driven_in
from nospill.potential_flow.driven_along import second_order_states
from nospill.potential_flow.driven_numbers import driven_gains, driven_kind, driven_modes, driven_terms
from nospill.potential_flow.integration import STEP_ANGLE, rows_at
from nospill.potential_flow.solving import two_orders
from nospill.scene.cargo import Cargo


def beyond_masses(
    cargo: Cargo, t: np.ndarray, body: np.ndarray, displacement: np.ndarray, velocity: np.ndarray
) -> np.ndarray:
    """Heights (m, d), m, of the modes with states: what the masses drive to the second order.

    Of a box that turns they are those of the flow of both orders less those of the masses.

    Args:
        cargo: with the liquid.
        t: (m,) even instants, s.
        body: (9, m) angular velocity, angular acceleration and specific force of the bottom's centre, container axes.
        displacement: (m, k) of the modal masses, m.
        velocity: (m, k) likewise, m/s.
    """
    kind = driven_kind(cargo)
    if kind == "box that turns":
        return _by_both_orders(cargo, t, body) - displacement @ driven_gains(cargo).T
    states = second_order_states(_driven_like(LiquidKey(cargo)), body, displacement, velocity, float(t[1] - t[0]))
    return states[:, 0, driven_modes(kind).first :]


@lru_cache(maxsize=32)
def _driven_like(key: LiquidKey) -> Driven:
    return driven_in(driven_terms(key.cargo), key.cargo)


def _by_both_orders(cargo: Cargo, t: np.ndarray, body: np.ndarray) -> np.ndarray:
    """Heights (m, J), m, of the modes of a problem in the flow of both orders."""
    terms, count = driven_terms(cargo), driven_modes(driven_kind(cargo)).count
    steps = int(np.ceil((t[-1] - t[0]) * float(np.max(terms.basin.frequency)) / STEP_ANGLE))
    instants = np.linspace(t[0], t[-1], 2 * steps + 1)
    rows = rows_at(np.stack([np.interp(instants, t, row) for row in body]), np.array([0.0, 0.0, terms.basin.depth]))
    states = two_orders(terms, np.zeros((2, count)), rows, float(2 * instants[1] - 2 * instants[0]))
    return np.stack([np.interp(t, instants[::2], row) for row in states[:, :, 0].sum(axis=1).T], axis=1)
