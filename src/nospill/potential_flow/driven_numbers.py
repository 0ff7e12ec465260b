"""Waves that the modal masses of a liquid leave out, as numbers: what couples the modes of a problem, without zeros.

Of a problem are the modes of the slowest masses, which come first, and others that these drive to the second order.
In a cup, and in a box that does not turn, the masses have the first order, and states are the others' heights. In a
box that turns they do not: a turn mixes all its modes, which moves to the first order what a mass along one side does
not know of. There the masses' own modes have states too, what their heights are beyond the masses'.

Which of these numbers are zero follows from the waves alone, so it is the same in all containers of a kind.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from nospill.potential_flow.basin import COARSE, Basin, basin_with
from nospill.potential_flow.bessel import slope_root
from nospill.potential_flow.driven import LiquidKey, height_gains
from nospill.potential_flow.interactions import interactions
from nospill.potential_flow.orders import LinearTerms, linear_terms
from nospill.potential_flow.surface_modes import disc_modes, disc_waves, rectangle_modes
from nospill.scene.cargo import Cargo
from nospill.scene.containers.cylinder import Cylinder

DrivenKind = Literal["", "cup", "box", "box that turns"]
"""Of liquids by what drives what; empty without such states."""

_ROUNDING, _LEAST = 1e-9, 1e-3
"""Part of the largest of a kind of numbers below which one is zero, and the least that counts as largest, in the
containers of `_typical`."""


@dataclass(frozen=True, slots=True)
class DrivenModes:
    """Modes of a problem.

    Attributes:
        waves: of the container, those of the masses first; in a cup each is a cosine and a sine, but for m = 0.
        moved: how many modes are those of masses.
        masses: how many masses along each direction have them, the slowest ones.
        first: the first mode that has a state; all that follow have.
        count: how many modes there are.
    """

    waves: tuple[tuple[int, int], ...]
    moved: int
    masses: int
    first: int
    count: int

    @property
    def states(self) -> int:
        """How many modes have states."""
        return self.count - self.first


@lru_cache(maxsize=3)
def driven_modes(kind: DrivenKind) -> DrivenModes:
    """The modes of a kind."""
    if kind == "cup":  # products of two modes of one nodal diameter have none and two
        waves = disc_waves(COARSE * slope_root(1, 1))
        ordered = tuple(wave for m in (1, 0, 2) for wave in waves if wave[0] == m)
        circles = sum(m == 1 for m, _ in ordered)
        return DrivenModes(ordered, 2 * circles, circles, 2 * circles, sum(1 + (m > 0) for m, _ in ordered))
    if kind == "box":
        return DrivenModes(((1, 0), (0, 1), (1, 1), (2, 0), (0, 2)), 2, 1, 2, 5)
    assert kind == "box that turns"
    return DrivenModes(((1, 0), (0, 1), (1, 1), (2, 0), (0, 2), (2, 1), (1, 2), (2, 2)), 3, 1, 0, 8)


def driven_kind(cargo: Cargo) -> DrivenKind:
    """Of an object with a liquid."""
    if isinstance(cargo.container, Cylinder):
        return "cup"
    return "box that turns" if cargo.filling is not None and cargo.filling.turns else "box"


def driven_numbers(cargo: Cargo) -> dict[str, np.ndarray]:
    """Of an upright cup or box with a liquid; J modes, n of them those of masses, d with states.

    Returns:
        surface (n, n + 2, d), pressure (n, 2 n + 4, d), square (n + 2, n + 2, d), upper triangle, and spin (d,) as
        `Interactions` has them; stiffness (J,), friction (J,), turn (J, J), rise (J, 2), turned_lean (J, 2), the slip,
        and of the modes of masses place (n, 2), lean (n, 2), turning (n,), as `LinearTerms` has them.
    """
    return _numbers_like(LiquidKey(cargo), driven_kind(cargo))


def driven_terms(cargo: Cargo) -> LinearTerms:
    """Of the modes of a liquid's problem."""
    return _terms_like(LiquidKey(cargo), driven_kind(cargo))


def driven_gains(cargo: Cargo) -> np.ndarray:
    """Heights (J, k) of these per displacement of its modal masses, nothing of modes that are none of masses here."""
    kind = driven_modes(driven_kind(cargo))
    gains = height_gains(cargo.oscillators, driven_terms(cargo).basin)
    gains[kind.moved :] = 0.0
    return gains


def driven_vector(cargo: Cargo) -> np.ndarray:
    """`driven_numbers` as one vector without zeros, (`driven_size`,)."""
    numbers = driven_numbers(cargo)
    return np.concatenate([numbers[name][pattern] for name, pattern in driven_patterns(driven_kind(cargo)).items()])


def driven_size(kind: DrivenKind) -> int:
    """Length of `driven_vector`."""
    return sum(int(np.count_nonzero(pattern)) for pattern in driven_patterns(kind).values()) if kind else 0


@lru_cache(maxsize=3)
def driven_patterns(kind: DrivenKind) -> dict[str, np.ndarray]:
    """Which of `driven_numbers` are not zero, (...) bool."""
    numbers = _numbers(linear_terms(_typical(kind)), kind)
    return {name: np.abs(value) > _ROUNDING * max(np.max(np.abs(value)), _LEAST) for name, value in numbers.items()}


def _typical(kind: DrivenKind) -> Basin:
    """A container of a kind whose numbers are of the order of 1."""
    waves = driven_modes(kind).waves
    modes = disc_modes(1.0, list(waves)) if kind == "cup" else rectangle_modes((1.0, 0.83), list(waves))
    return Basin(modes, 1.0, np.full(len(modes.wave_number), 0.01))


@lru_cache(maxsize=32)
def _terms_like(key: LiquidKey, kind: DrivenKind) -> LinearTerms:
    return linear_terms(basin_with(key.cargo, driven_modes(kind).waves))


@lru_cache(maxsize=32)
def _numbers_like(key: LiquidKey, kind: DrivenKind) -> dict[str, np.ndarray]:
    return _numbers(_terms_like(key, kind), kind)


def _numbers(terms: LinearTerms, kind: DrivenKind) -> dict[str, np.ndarray]:
    modes = driven_modes(kind)
    n, states = modes.moved, slice(modes.first, None)
    moved = np.arange(n)
    forms = interactions(terms, moved)
    square = np.zeros((n + 2, n + 2, modes.states))
    square[np.triu_indices(n + 2)] = forms.square[:, states]
    turns = 0.0 if kind == "box" else 1.0  # one that turns slowly is of the other kind
    return {
        "surface": forms.surface[:, states].reshape(n, n + 2, -1),
        "pressure": forms.pressure[:, states].reshape(n, 2 * n + 4, -1),
        "square": square,
        "spin": turns * forms.spin[states],
        "stiffness": terms.stiffness,
        "friction": terms.friction,
        "turn": turns * terms.spin,
        "rise": terms.rise,
        "turned_lean": turns * terms.slip,
        "place": terms.place[:n],
        "lean": terms.lean[:n],
        "turning": turns * terms.turn[:n],
    }


def masses_of_modes(directions: Sequence[tuple[int, ...]], kind: DrivenKind) -> list[int]:
    """Which modal masses, moving along `directions` each, have modes of the problem, in the order of these."""
    most, count, found = driven_modes(kind).masses, dict[tuple[int, ...], int](), []
    for index, own in enumerate(directions):
        count[own] = count.get(own, 0) + 1
        if count[own] <= most:
            found.append(index)
    return found
