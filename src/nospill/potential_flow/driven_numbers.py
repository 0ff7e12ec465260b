"""The waves of second order of a cup as numbers: what couples the modes that drive and are driven, without zeros.

Which of these numbers are zero follows from the nodal diameters alone, so it is the same in all cups.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from nospill.potential_flow.basin import COARSE, Basin
from nospill.potential_flow.bessel import slope_root
from nospill.potential_flow.driven import driven
from nospill.potential_flow.interactions import Interactions, interactions
from nospill.potential_flow.orders import linear_terms
from nospill.potential_flow.surface_modes import disc_modes, disc_waves
from nospill.scene.cargo import Cargo

_ROUNDING = 1e-9


def driven_numbers(cargo: Cargo) -> dict[str, np.ndarray]:
    """Of a cup with a liquid; n modes that drive, in the order of the modal masses, and d that are driven.

    Returns:
        surface (n, n + 2, d), pressure (n, 2 n + 4, d), square (n + 2, n + 2, d), upper triangle, and spin (d,) as
        `Interactions` has them; of the driving modes stiffness (n,), friction (n,), turn (n, n), place (n, 2),
        rise (n, 2), lean (n, 2), turned_lean (n, 2), the slip, and of the driven ones own_stiffness (d,),
        own_friction (d,), own_turn (d, d), as `LinearTerms` has them.
    """
    return _numbers(driven(cargo).interactions)


def driven_vector(cargo: Cargo) -> np.ndarray:
    """The same as one vector without zeros, (`driven_size`,)."""
    numbers = driven_numbers(cargo)
    return np.concatenate([numbers[name][pattern] for name, pattern in driven_patterns().items()])


def driven_size() -> int:
    """Length of `driven_vector`."""
    return sum(int(np.count_nonzero(pattern)) for pattern in driven_patterns().values())


def driven_count() -> int:
    """How many modes of a cup are driven."""
    return len(driven_patterns()["own_stiffness"])


@lru_cache(maxsize=1)
def driven_patterns() -> dict[str, np.ndarray]:
    """Which of `driven_numbers` are not zero, (...) bool; and by the names of both turns what these are."""
    waves = [wave for wave in disc_waves(COARSE * slope_root(1, 1)) if wave[0] <= 2]
    modes = disc_modes(1.0, waves)
    count = len(modes.wave_number)
    diameters = np.repeat([m for m, _ in waves], [1 if m == 0 else 2 for m, _ in waves])
    terms = linear_terms(Basin(modes, 1.0, np.full(count, 0.01)))
    numbers = _numbers(interactions(terms, np.flatnonzero(diameters == 1)))
    return {name: np.abs(value) > _ROUNDING * max(np.max(np.abs(value)), 1e-300) for name, value in numbers.items()}


def _numbers(own: Interactions) -> dict[str, np.ndarray]:
    terms, moved = own.terms, own.moved
    n = len(moved)
    swings = np.setdiff1d(np.arange(len(terms.stiffness)), moved)
    square = np.zeros((n + 2, n + 2, len(swings)))
    square[np.triu_indices(n + 2)] = own.square[:, swings]
    return {
        "surface": own.surface[:, swings].reshape(n, n + 2, -1),
        "pressure": own.pressure[:, swings].reshape(n, 2 * n + 4, -1),
        "square": square,
        "spin": own.spin[swings],
        "stiffness": terms.stiffness[moved],
        "friction": terms.friction[moved],
        "turn": terms.spin[np.ix_(moved, moved)],
        "place": terms.place[moved],
        "rise": terms.rise[moved],
        "lean": terms.lean[moved],
        "turned_lean": terms.slip[moved],
        "own_stiffness": terms.stiffness[swings],
        "own_friction": terms.friction[swings],
        "own_turn": terms.spin[np.ix_(swings, swings)],
    }
