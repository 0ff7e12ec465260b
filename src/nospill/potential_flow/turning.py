"""What a turn of the container does to the flow: Stokes-Joukowski potentials of a prism that is open at the top.

The absolute velocity is u_O + grad(omega . Omega) + grad phi, u_O that of the middle of the rest surface. The vector
Omega is harmonic and moves with the walls; at the surface it may be anything, so it is taken as what decays from the
bottom upwards,

    Omega = (-A_y, A_x, Z),    A_x = x z - 2 chi_x,    chi_x = -sum c_n F_n exp(-k_n (z + h))/k_n,

c_n the share of the mode n in the function x: A_x moves with the wall as z does, and the bottom of chi_x as x. Z is
Zhukovsky's potential, zero in a disc. The velocity past the container is then W + grad phi,

    W = omega_y V_x - omega_x V_y + omega_z (grad Z - e_z x r),    V_x = (0, 0, 2 x) - 2 grad chi_x.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.potential_flow.basin import Basin

_NOTHING = 40.0
"""k h from which on what comes from the bottom is lost at the surface."""


@dataclass(frozen=True, slots=True)
class TiltFields:
    """A and V of a lean u = (omega_y, -omega_x), summed over x and y, at the points of a basin.

    Attributes:
        potential: (P,) u . A per u, m^2 rad/s.
        rise: (P,) its derivative by z.
        velocity: (3, P) u . V, m/s.
        growth: (3, P) its derivative by z, 1/s.
    """

    potential: np.ndarray
    rise: np.ndarray
    velocity: np.ndarray
    growth: np.ndarray


@dataclass(frozen=True, slots=True)
class Tilting:
    """Modes that carry the bottom's part of a lean: (J', 2) shares, and what they need at P points."""

    basin: Basin
    index: np.ndarray
    share: np.ndarray

    def at(self, lean: np.ndarray, height: np.ndarray | float) -> TiltFields:
        """Fields at heights (P,) or one height, m, above rest, for a lean (2,), rad/s."""
        modes = self.basin.modes
        side = modes.points @ lean
        z = np.broadcast_to(height, side.shape)
        k, part = modes.wave_number[self.index], self.share @ lean
        faded = np.exp(-np.multiply.outer(z + self.basin.depth, k)) * part  # (P, J')
        shape, slope = modes.shape[:, self.index], modes.slope[:, :, self.index]
        up = np.einsum("pj,pj->p", shape, faded)
        along = np.einsum("xpj,pj->xp", slope, faded)
        return TiltFields(
            potential=side * z + 2 * np.einsum("pj,pj->p", shape, faded / k),
            rise=side - 2 * up,
            velocity=np.stack([*(2 * np.einsum("xpj,pj->xp", slope, faded / k)), 2 * (side - up)]),
            growth=np.stack([*(-2 * along), 2 * np.einsum("pj,pj->p", shape, faded * k)]),
        )

    def at_surface(self, lean: np.ndarray, lean_rate: np.ndarray, height: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """V of leans (..., 2), rad/s, and A of their rates, rad/s^2, at heights (..., P), m, above rest.

        Returns:
            (3, ..., P) m/s and (..., P) m^2/s^2.
        """
        modes = self.basin.modes
        k = modes.wave_number[self.index, None]
        shape, slope = modes.shape.T[self.index], modes.slope.transpose(0, 2, 1)[:, self.index]
        faded = np.exp(-np.multiply.outer(k[:, 0], height + self.basin.depth))  # (J', ..., P)
        own, own_rate = (np.moveaxis(of @ self.share.T, -1, 0)[..., None] for of in (lean, lean_rate))
        velocity = 2 * np.einsum("xjp,j...p->x...p", np.stack([*(slope / k), -shape]), faded * own)
        velocity[2] += 2 * (lean @ modes.points.T)
        potential = 2 * np.einsum("jp,j...p->...p", shape / k, faded * own_rate)
        return velocity, potential + (lean_rate @ modes.points.T) * height


def tilting(basin: Basin) -> Tilting:
    """Set up `Tilting` with the modes of the basin whose bottom is felt at the surface."""
    place = basin.place
    size = np.max(np.abs(place))
    felt = np.max(np.abs(place), axis=1) > 1e-9 * size
    felt &= basin.modes.wave_number * basin.depth < _NOTHING
    index = np.flatnonzero(felt)
    return Tilting(basin, index, place[index])
