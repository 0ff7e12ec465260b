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
from nospill.potential_flow.turning import TiltFields, Tilting, tilting


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
        level: fields at the rest level of a lean of 1 rad/s along x and of one along y, which come next to last.
        shear: (P, J) growth upwards of the flow past the container that a turn and a mode's potential share, 1/m.
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
    level: TiltFields
    shear: np.ndarray
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
        level=TiltFields(
            potential=np.stack([fields.potential for fields in along]),
            rise=np.stack([fields.rise for fields in along]),
            velocity=np.stack([fields.velocity for fields in along], axis=1),
            growth=np.stack([fields.growth for fields in along], axis=1),
        ),
        shear=np.einsum("xpj,xp->pj", modes.slope, modes.turn),
        friction=basin.friction,
        stiffness=basin.stiffness,
    )


def lean_of(rates: np.ndarray) -> np.ndarray:
    """(omega_y, -omega_x) of a rate (3, ...)."""
    return np.stack([rates[1], -rates[0]])


def first_order(terms: LinearTerms, state: np.ndarray, row: np.ndarray) -> np.ndarray:
    """Rates (..., 2, J) of surface and potential, m/s and m^2/s^2.

    Args:
        terms: of the basin.
        state: (..., 2, J) beta, m, and p, m^2/s.
        row: (9, ...) angular velocity, angular acceleration, specific force in the middle of the rest surface.
    """
    surface, potential = state[..., 0, :], state[..., 1, :]
    lean, force = lean_of(row[:3]), row[6:]
    rate = terms.stiffness * potential + (terms.rise @ lean).T
    pressure = force[2][..., None] * surface + (terms.place @ force[:2] + terms.lean @ lean_of(row[3:6])).T
    pressure = pressure + np.multiply.outer(row[5], terms.turn)
    if np.any(row[2]):
        spin = row[2][..., None]
        rate = rate - spin * (surface @ terms.spin.T)
        pressure = pressure + spin * (potential @ terms.spin.T + (terms.slip @ lean).T)
    return np.stack([rate, -pressure - terms.friction * rate], axis=-2)


def second_order(terms: LinearTerms, state: np.ndarray, source: np.ndarray, row: np.ndarray) -> np.ndarray:
    """Rates (2, J) of the second order's part of surface and potential.

    Args:
        terms: of the basin.
        state: (2, J) of the second order.
        source: (2, J) of `second_order_sources` at this instant.
        row: (9,) as for `first_order`.
    """
    rate = terms.stiffness * state[1] + source[0]
    push = row[8] * state[0] + source[1]
    if row[2]:
        rate = rate - row[2] * (terms.spin @ state[0])
        push = push + row[2] * (terms.spin @ state[1])
    return np.stack([rate, -push - terms.friction * rate])


def second_order_sources(terms: LinearTerms, first: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """What the first order drives the second with, (m, 2, J): rates of the surface, and pressures over density.

    Args:
        terms: of the basin.
        first: (m, 2, J) states of the first order.
        rows: (9, m) as for `first_order`.
    """
    modes, still, stiffness = terms.basin.modes, terms.level, terms.stiffness
    surface, potential = first[:, 0], first[:, 1]
    spin, lean, lean_rate = rows[2][:, None], lean_of(rows[:3]).T, lean_of(rows[3:6]).T
    change = first_order(terms, first, rows)[:, 1]
    moved = np.flatnonzero(np.any(surface, axis=0) | np.any(potential, axis=0) | np.any(change, axis=0))  # of a cup few
    surface, potential, change, kappa = surface[:, moved], potential[:, moved], change[:, moved], stiffness[moved]
    shape, slopes = modes.shape[:, moved].T, [slope[:, moved].T for slope in modes.slope]
    eta, steep = surface @ shape, [surface @ slope for slope in slopes]
    velocity = [potential @ slope + lean @ past for slope, past in zip(slopes, still.velocity, strict=False)]
    velocity.append((kappa * potential) @ shape + lean @ still.velocity[2])
    bend = (modes.wave_number[moved] ** 2 * potential) @ shape + lean @ still.growth[2]
    rising = (kappa * change) @ shape + lean_rate @ still.rise
    sheared = (kappa * potential) @ terms.shear[:, moved].T
    sheared = sheared + lean @ np.einsum("xp,xlp->lp", modes.turn, still.growth[:2])
    rising = rising + spin * (sheared + rows[:2].T @ modes.points.T)
    source = eta * bend - steep[0] * velocity[0] - steep[1] * velocity[1]
    x, y = modes.points.T
    turned = (x**2 + y**2 - np.einsum("xp,xp->p", modes.turn, modes.turn)) * spin**2
    turned = turned + (np.outer(rows[0], y) - np.outer(rows[1], x)) ** 2
    pressure = eta * rising + (velocity[0] ** 2 + velocity[1] ** 2 + velocity[2] ** 2 - turned) / 2
    weighted = modes.shape * modes.weight[:, None] / modes.norm
    return np.stack([source @ weighted, pressure @ weighted], axis=1)
