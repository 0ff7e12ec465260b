"""The flow in full: Galerkin's method in the modes of the surface, nothing expanded in its height.

The surface conditions of `orders`, with every function taken at the surface itself. The kinematic one is weighted with
the potentials' values there, Q_j = F_j cosh(k_j (eta + h))/cosh(k_j h), the dynamic one with F_j: the equations of
Luke's variational principle for these modes [Miles 1976; Faltinsen and Timokha, Sloshing, ch. 7]. With N_mj the
integral of F_m Q_j,

    N^T beta' = integrals of Q_j (phi_z + W_z - grad eta . (grad phi + W))
    N p'      = -integrals of F_m (f . r + alpha . Omega + |grad phi + W|^2/2 - |omega x r|^2/2) - damping.

Volume is kept exactly, energy too but for the quadrature, whatever the number of modes; third order and all that follow
are in it. What limits it is its number of modes: a potential's value at a crest grows as exp(k eta), so short waves can
neither be left out nor be carried where the surface is steep.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.potential_flow.basin import Basin
from nospill.potential_flow.orders import LinearTerms, lean_of


@dataclass(frozen=True, slots=True)
class Fields:
    """What the flow is at the surface.

    Attributes:
        height: (P,) eta, m.
        steep: (2, P) its slope.
        value: (P, J) Q, of every mode's potential per its amplitude.
        velocity: (3, P) grad phi, m/s.
    """

    height: np.ndarray
    steep: np.ndarray
    value: np.ndarray
    velocity: np.ndarray


def fields_of(basin: Basin, state: np.ndarray) -> Fields:
    """The flow of a state (2, J), surface and potential."""
    modes, (surface, potential) = basin.modes, state
    k = modes.wave_number
    height = modes.shape @ surface
    bottom = np.exp(-2 * k * basin.depth)
    rising = np.exp(np.multiply.outer(height, k))
    falling = bottom / rising
    depth = (rising + falling) / (1 + bottom)
    drop = k * (rising - falling) / (1 + bottom)
    value = modes.shape * depth
    along = (modes.slope * depth) @ potential
    return Fields(height, modes.slope @ surface, value, np.stack([*along, (modes.shape * drop) @ potential]))


def full_flow(terms: LinearTerms, state: np.ndarray, row: np.ndarray) -> np.ndarray:
    """Rates (2, J) of surface and potential, m/s and m^2/s^2; arguments as of `orders.first_order`."""
    from scipy.linalg import lu_factor, lu_solve  # slow to load

    basin = terms.basin
    modes, flow = basin.modes, fields_of(basin, state)
    weighted = modes.shape * modes.weight[:, None]
    omega, force = row[:3], row[6:]
    lean, lean_rate = lean_of(omega), lean_of(row[3:6])
    x, y = modes.points.T
    velocity = flow.velocity + omega[2] * np.stack([*modes.turn, np.zeros_like(x)])
    pressure = force[0] * x + force[1] * y + force[2] * flow.height + row[5] * modes.turn_potential
    if lean.any():
        velocity = velocity + terms.tilting.at(lean, flow.height).velocity
    if lean_rate.any():
        pressure = pressure + terms.tilting.at(lean_rate, flow.height).potential
    wall = np.stack(
        [omega[1] * flow.height - omega[2] * y, omega[2] * x - omega[0] * flow.height, omega[0] * y - omega[1] * x]
    )
    pressure = pressure + (np.einsum("xp,xp->p", velocity, velocity) - np.einsum("xp,xp->p", wall, wall)) / 2
    through = velocity[2] - np.einsum("xp,xp->p", flow.steep, velocity[:2])
    factors = lu_factor(weighted.T @ flow.value, check_finite=False)
    rate = lu_solve(factors, flow.value.T @ (modes.weight * through), trans=1, check_finite=False)
    push = weighted.T @ pressure + modes.norm * terms.friction * rate
    return np.stack([rate, -lu_solve(factors, push, check_finite=False)])


def energy(basin: Basin, state: np.ndarray, gravity: float) -> float:
    """Kinetic and potential energy over density, m^5/s^2, in a container that stands; zero at rest."""
    modes, flow = basin.modes, fields_of(basin, state)
    through = flow.velocity[2] - np.einsum("xp,xp->p", flow.steep, flow.velocity[:2])
    kinetic = modes.weight @ (flow.value @ state[1] * through) / 2
    return float(kinetic + gravity / 2 * modes.weight @ flow.height**2)
