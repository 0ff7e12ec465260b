"""Heights that the modal masses of a liquid leave out, along a motion from rest, in the modes of its problem."""

from __future__ import annotations

import numpy as np

from nospill.potential_flow.driven_numbers import driven_gains, driven_kind, driven_modes, driven_terms
from nospill.potential_flow.integration import STEP_ANGLE, rows_at
from nospill.potential_flow.solving import two_orders
from nospill.scene.cargo import Cargo


def beyond_masses(cargo: Cargo, t: np.ndarray, body: np.ndarray, displacement: np.ndarray) -> np.ndarray:
    """Heights (m, d), m, of the modes with states: of the flow of both orders less those of the masses.

    Args:
        cargo: with the liquid.
        t: (m,) s.
        body: (9, m) angular velocity, angular acceleration and specific force of the bottom's centre, container axes.
        displacement: (m, k) of the modal masses, m.
    """
    terms, modes = driven_terms(cargo), driven_modes(driven_kind(cargo))
    count = int(np.ceil((t[-1] - t[0]) * float(np.max(terms.basin.frequency)) / STEP_ANGLE))
    instants = np.linspace(t[0], t[-1], 2 * count + 1)
    rows = rows_at(np.stack([np.interp(instants, t, row) for row in body]), np.array([0.0, 0.0, terms.basin.depth]))
    states = two_orders(terms, np.zeros((2, modes.count)), rows, float(2 * instants[1] - 2 * instants[0]))
    heights = np.stack([np.interp(t, instants[::2], row) for row in states[:, :, 0].sum(axis=1).T], axis=1)
    return (heights - displacement @ driven_gains(cargo).T)[:, modes.first :]
