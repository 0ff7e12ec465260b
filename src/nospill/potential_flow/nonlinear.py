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
    """What flows of one basin are at the surface; ... are the axes of their states, none of one.

    Attributes:
        height: (..., P) eta, m.
        steep: (2, ..., P) its slope.
        value: (..., P, J) Q, of every mode's potential per its amplitude; a view of the room it was computed in.
        velocity: (3, ..., P) grad phi, m/s.
    """

    height: np.ndarray
    steep: np.ndarray
    value: np.ndarray
    velocity: np.ndarray


def room_of(basin: Basin, *axes: int) -> np.ndarray:
    """Room (3, ..., P, J) for one evaluation of states with these axes; the next one writes over it.

    Fresh arrays of this size cost three times what is computed in them: the system clears each when it hands it out.
    """
    return np.empty((3, *axes, *basin.modes.shape.shape))


def fields_of(basin: Basin, state: np.ndarray, room: np.ndarray | None = None) -> Fields:
    """The flow of states (..., 2, J), surface and potential; `room` as of `room_of`, its own by default."""
    modes, surface, potential = basin.modes, state[..., 0, :], state[..., 1, :]
    k = modes.wave_number
    height = surface @ modes.shape.T
    rising, falling, value = room_of(basin, *height.shape[:-1]) if room is None else room
    bottom = np.exp(-2 * k * basin.depth)
    share = potential / (1 + bottom)
    np.multiply(height[..., None], k, out=rising)
    np.exp(rising, out=rising)
    np.divide(bottom, rising, out=falling)
    np.add(rising, falling, out=value)
    rising -= falling
    rising *= (k * share)[..., None, :]
    along = np.multiply(value, share[..., None, :], out=falling)
    velocity = [np.einsum("pj,...pj->...p", slope, along) for slope in modes.slope]
    velocity.append(np.einsum("pj,...pj->...p", modes.shape, rising))
    value *= modes.shape / (1 + bottom)
    steep = np.stack([surface @ slope.T for slope in modes.slope])
    return Fields(height, steep, value, np.stack(velocity))


def full_flow(terms: LinearTerms, state: np.ndarray, row: np.ndarray, room: np.ndarray | None = None) -> np.ndarray:
    """Rates (..., 2, J) of surface and potential, m/s and m^2/s^2.

    Arguments as of `orders.first_order`; `room` as of `room_of`, its own by default.
    """
    basin = terms.basin
    modes, flow = basin.modes, fields_of(basin, state, room)
    x, y = modes.points.T
    omega, alpha, force = (part[..., None] for part in row.reshape(3, 3, *row.shape[1:]))
    lean, lean_rate = (np.moveaxis(lean_of(part[..., 0]), 0, -1) for part in (omega, alpha))
    past = modes.turn.reshape(2, *[1] * (row.ndim - 1), -1)
    velocity = flow.velocity
    velocity[:2] += omega[2] * past
    pressure = force[0] * x + force[1] * y + force[2] * flow.height + alpha[2] * modes.turn_potential
    if lean.any() or lean_rate.any():
        leaned, pushed = terms.tilting.at_surface(lean, lean_rate, flow.height)
        velocity += leaned
        pressure += pushed
    wall = (omega[1] * flow.height - omega[2] * y, omega[2] * x - omega[0] * flow.height, omega[0] * y - omega[1] * x)
    pressure += (np.einsum("x...p,x...p->...p", velocity, velocity) - sum(part * part for part in wall)) / 2
    through = velocity[2] - np.einsum("x...p,x...p->...p", flow.steep, velocity[:2])
    weighted = modes.shape * modes.weight[:, None]
    coupling = weighted.T @ flow.value
    carried = ((modes.weight * through)[..., None, :] @ flow.value)[..., 0, :]
    rate = _solved(np.swapaxes(coupling, -1, -2), carried)
    push = pressure @ weighted + modes.norm * terms.friction * rate
    return np.stack([rate, -_solved(coupling, push)], axis=-2)


def _solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solutions (..., J) of linear systems; NaN where one is singular, as where a flow has broken down."""
    try:
        found: np.ndarray = np.linalg.solve(matrix, right[..., None])[..., 0]
    except np.linalg.LinAlgError:
        if matrix.ndim == 2:
            return np.full_like(right, np.nan)
        return np.stack([_solved(*pair) for pair in zip(matrix, right, strict=True)])
    return found


def energy(basin: Basin, state: np.ndarray, gravity: float) -> float:
    """Kinetic and potential energy over density, m^5/s^2, in a container that stands; zero at rest."""
    modes, flow = basin.modes, fields_of(basin, state)
    through = flow.velocity[2] - np.einsum("xp,xp->p", flow.steep, flow.velocity[:2])
    kinetic = modes.weight @ (flow.value @ state[1] * through) / 2
    return float(kinetic + gravity / 2 * modes.weight @ flow.height**2)
