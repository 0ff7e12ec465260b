"""Liquids whose second order follows from known waves of the first: modes that drive, oscillators that are driven.

In a cup a turn about the axis takes waves with m nodal diameters round as exp(-i m theta): a cosine and its sine are
one oscillator, in axes that do not turn. In a box a turn mixes all modes; that part is left out of the second order, as
the modal model leaves it out of the first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from nospill.potential_flow.basin import SAME_WAVE, Basin, driven_basin
from nospill.potential_flow.interactions import Interactions, interactions
from nospill.potential_flow.orders import LinearTerms, linear_terms
from nospill.scene.cargo import Cargo
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.sloshing.modes import Oscillator

_ROUNDING = 1e-9
"""Part of the largest share of a mode below which it is none."""


@dataclass(frozen=True, slots=True, eq=False)
class Driven:
    """A liquid whose second order is asked for; equal only to itself.

    Attributes:
        terms: of the first and the second order, in the modes that drive and are driven.
        gains: (J, k) height of every mode per displacement of the modal masses.
        axes: (J, L) amplitudes of the driven oscillators per height of a mode, complex for a pair of cosine and sine.
        diameters: (L,) nodal diameters of a cup's oscillators; 0 in a box.
        interactions: of the modes that drive.
    """

    terms: LinearTerms
    gains: np.ndarray
    axes: np.ndarray
    diameters: np.ndarray
    interactions: Interactions


def driven(cargo: Cargo) -> Driven:
    """Set up the second order of a liquid; `unsupported` says whether it may be asked for."""
    assert cargo.filling is not None  # what is asked for is a liquid
    return _driven_like(LiquidKey(cargo))


@lru_cache(maxsize=64)
def _driven_like(key: LiquidKey) -> Driven:
    return driven_in(linear_terms(driven_basin(key.cargo)), key.cargo)


def driven_in(terms: LinearTerms, cargo: Cargo) -> Driven:
    """The second order of a liquid in some of its modes."""
    count = len(terms.stiffness)
    axes, diameters = np.eye(count, dtype=complex), np.zeros(count)
    if isinstance(cargo.container, Cylinder):
        turned = np.rint(np.max(np.abs(terms.spin), axis=0))
        columns = []
        for mode in np.flatnonzero(turned != 1):
            partner = int(np.argmax(terms.spin[:, mode]))
            if turned[mode] == 0 or terms.spin[partner, mode] > 0.5:
                column = np.zeros(count, complex)
                column[mode] = 1.0
                column[partner] += 1j if turned[mode] else 0.0
                columns.append((column, turned[mode]))
        axes, diameters = np.stack([item[0] for item in columns], axis=1), np.array([item[1] for item in columns])
    gains = height_gains(cargo.oscillators, terms.basin)
    return Driven(terms, gains, axes, diameters, interactions(terms, _driving(terms, gains)))


def _driving(terms: LinearTerms, gains: np.ndarray) -> np.ndarray:
    """Places (n,) of the modes that the masses, the tray or a turn move to the first order, rounding left out."""
    turned = (np.abs(terms.spin) > _ROUNDING * np.max(np.abs(terms.spin), initial=1e-300)).astype(float)
    reached = np.any(gains, axis=1)
    for column in (terms.rise, terms.lean, terms.place, terms.slip, terms.turn[:, None]):
        size = np.max(np.abs(column), axis=1)
        reached |= size > _ROUNDING * np.max(size, initial=1e-300)
    return np.flatnonzero(reached | (turned @ reached > 0.0))


class LiquidKey:
    """A liquid by what its terms follow from; equal of like ones."""

    def __init__(self, cargo: Cargo) -> None:
        filling = cargo.filling
        assert filling is not None
        slowest = filling.modes.slowest
        self.cargo = cargo
        self.values = (
            cargo.container,
            filling.liquid_height,
            slowest.wave_number,
            slowest.damping,
            filling.liquid.kinematic_viscosity,
            filling.oscillators,
        )

    def __hash__(self) -> int:
        return hash(self.values)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, LiquidKey) and self.values == other.values


def height_gains(oscillators: Sequence[Oscillator], basin: Basin) -> np.ndarray:
    """Heights (J, k) of a basin's modes per displacement of modal masses; nothing of masses whose mode it has not.

    Of modes of one frequency a mass along a side has the one that lies along it, and a yaw mode the one that a turn
    pushes as it pushes the mass: in a square box (1, 3) and (3, 1) are pushed against each other.
    """
    modes, shares = basin.modes, np.abs(basin.place)
    turned = modes.coefficients(modes.turn_potential)
    masses = [(mode, direction) for mode in oscillators for direction in mode.directions]
    number, gain = np.array([(mode.wave_number, mode.surface_gain) for mode, _ in masses]).T
    near = np.abs(modes.wave_number[:, None] - number) <= SAME_WAVE * number
    pushed = [mode.arm * turned if mode.yaws else shares[:, "xy".index(direction)] for mode, direction in masses]
    nearest = np.argmax(np.where(near, np.transpose(pushed), -np.inf), axis=0)
    return np.where(near & (np.arange(len(near))[:, None] == nearest), gain, 0.0)
