"""The flow to the first and to the second order in the steepness of its waves.

With eta = sum beta_j F_j, potential phi = sum p_j F_j cosh(k_j (z + h))/cosh(k_j h) in the moving container and W,
Omega as in `turning`, the conditions at the surface are, in axes of the container [Faltinsen and Timokha, Sloshing]

    eta' = phi_z + W_z - grad eta . (grad phi + W)
    phi' + f . r + alpha . Omega + |grad phi + W|^2/2 - |omega x r|^2/2 = C(t)    at z = eta,

f the specific force in the middle of the rest surface. Steepness, lean and turning rate across the axis are small; the
axial force and the turn about the axis need not be. The first order then is the modal system of the linear model,

    beta1' = kappa p1 + W_z,        p1' = -f_z beta1 - (f_x x + f_y y + alpha . Omega)_j - 2 zeta omega beta1'/kappa

(W_turn . grad on both sides left out here), and the second a linear system that it drives: at z = 0

    beta2' = kappa p2 + [div of -eta1 (grad phi1 + W)],
    p2'    = -f_z beta2 - [eta1 (phi1' + alpha . Omega)_z + |grad phi1 + W|^2/2 - |omega x r|^2/2] - damping.

So the second order is a function of the states of the modes with one nodal diameter, and swings at frequencies of its
own: of the modes with none and two in a cup. It has no resonance to feed and cannot run away.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.potential_flow.basin import Basin
from nospill.potential_flow.turning import Tilting, tilting


@dataclass(frozen=True, slots=True)
class LinearTerms:
    """What drives and couples the modes of a basin in linear theory.

    Attributes:
        basin: of the modes.
        tilting: of its lean.
        spin: (J, J) rate of every mode per mode and turn about the axis, and of its potential likewise.
        place: (J, 2) shares of x and y, m.
        rise: (J, 2) rate of the surface per lean (omega_y, -omega_x), m.
        lean: (J, 2) pressure over density per rate of the lean, m^2.
        slip: (J, 2) pressure over density per lean and turn, m^2.
        turn: (J,) pressure over density per angular acceleration about the axis, m^2.
        friction: (J,) as of the basin.
        stiffness: (J,) likewise.
    """

    basin: Basin
    tilting: Tilting
    spin: np.ndarray
    place: np.ndarray
    rise: np.ndarray
    lean: np.ndarray
    slip: np.ndarray
    turn: np.ndarray
    friction: np.ndarray
    stiffness: np.ndarray


def linear_terms(basin: Basin) -> LinearTerms:
    """Set up the linear flow of a basin."""
    modes, leaning = basin.modes, tilting(basin)
    along = [leaning.at(unit, 0.0) for unit in np.eye(2)]
    slip = [np.einsum("xp,xp->p", modes.turn, fields.velocity[:2]) for fields in along]
    return LinearTerms(
        basin=basin,
        tilting=leaning,
        spin=modes.coefficients(np.einsum("xp,xpj->pj", modes.turn, modes.slope)),
        place=basin.place,
        rise=modes.coefficients(np.stack([fields.velocity[2] for fields in along], axis=1)),
        lean=modes.coefficients(np.stack([fields.potential for fields in along], axis=1)),
        slip=modes.coefficients(np.stack(slip, axis=1)),
        turn=modes.coefficients(modes.turn_potential),
        friction=basin.friction,
        stiffness=basin.stiffness,
    )


def lean_of(rates: np.ndarray) -> np.ndarray:
    """(omega_y, -omega_x) of a rate (3, ...)."""
    return np.stack([rates[1], -rates[0]])


def first_order(terms: LinearTerms, state: np.ndarray, row: np.ndarray) -> np.ndarray:
    """Rates (2, J) of surface and potential (2, J), m/s and m^2/s^2.

    Args:
        terms: of the basin.
        state: (2, J) beta, m, and p, m^2/s.
        row: (9,) angular velocity, angular acceleration, specific force in the middle of the rest surface.
    """
    surface, potential = state
    spin, lean, force = row[2], lean_of(row[:3]), row[6:]
    rate = terms.stiffness * potential + terms.rise @ lean
    pressure = force[2] * surface + terms.place @ force[:2] + terms.lean @ lean_of(row[3:6]) + terms.turn * row[5]
    if spin:
        rate = rate - spin * (terms.spin @ surface)
        pressure = pressure + spin * (terms.spin @ potential + terms.slip @ lean)
    return np.stack([rate, -pressure - terms.friction * rate])


def second_order(terms: LinearTerms, first: np.ndarray, state: np.ndarray, row: np.ndarray) -> np.ndarray:
    """Rates (2, J) of the second order's part of surface and potential.

    Args:
        terms: of the basin.
        first: (2, J) state of the first order.
        state: (2, J) state of the second.
        row: as for `first_order`.
    """
    modes, stiffness = terms.basin.modes, terms.stiffness
    surface, potential = first
    spin, lean = row[2], lean_of(row[:3])
    change = first_order(terms, first, row)[1]
    eta, steep = modes.shape @ surface, modes.slope @ surface
    along = modes.slope @ potential
    up, bend = modes.shape @ (stiffness * potential), modes.shape @ (modes.wave_number**2 * potential)
    rising = modes.shape @ (stiffness * change)
    velocity, growth = np.stack([*along, up]), np.zeros((3, len(eta)))
    if lean.any() or row[3:5].any():
        fields = terms.tilting.at(lean, 0.0)
        velocity, growth = velocity + fields.velocity, fields.growth
        rising = rising + terms.tilting.at(lean_of(row[3:6]), 0.0).rise
    source = eta * (bend + growth[2]) - np.einsum("xp,xp->p", steep, velocity[:2])
    pressure = eta * rising + np.einsum("xp,xp->p", velocity, velocity) / 2 - _still(terms, row)
    if spin:
        sheared = np.einsum("xpj,xp->pj", modes.slope, modes.turn) @ (stiffness * potential)
        sheared = sheared + np.einsum("xp,xp->p", modes.turn, growth[:2])
        pressure = pressure + spin * eta * (sheared + modes.points @ row[:2])
    rate = stiffness * state[1] + modes.coefficients(source)
    push = row[8] * state[0] + modes.coefficients(pressure)
    if spin:
        rate = rate - spin * (terms.spin @ state[0])
        push = push + spin * (terms.spin @ state[1])
    return np.stack([rate, -push - terms.friction * rate])


def _still(terms: LinearTerms, row: np.ndarray) -> np.ndarray:
    """(|omega x r|^2 - |W_turn|^2)/2 at the rest level, (P,)."""
    modes, (x, y) = terms.basin.modes, terms.basin.modes.points.T
    turned = x**2 + y**2 - np.einsum("xp,xp->p", modes.turn, modes.turn)
    return (row[2] ** 2 * turned + (row[0] * y - row[1] * x) ** 2) / 2
