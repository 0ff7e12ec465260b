"""What the waves of the first order drive the second with, as quadratic forms of their states.

`orders.second_order_sources` multiplies fields at the points of the cross-section and projects the products onto the
modes. The fields are linear in few numbers: heights e, velocities v = (potentials, lean) and what changes them,
r = (changes of the potentials, lean's rate, turn times v). So every projection of a product of fields is a number that
the basin alone decides, and a source is the sum of such numbers times e v, e r, v v and the turn squared.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.potential_flow.orders import LinearTerms, first_order, lean_of


@dataclass(frozen=True, slots=True)
class Interactions:
    """Quadratic forms of n modes that drive, in a basin of J modes.

    Attributes:
        terms: of the basin.
        moved: (n,) places of the modes that drive.
        surface: (n (n + 2), J) rates of the surface per height and velocity.
        pressure: (n (2 n + 4), J) pressure over density per height and change.
        square: ((n + 2) (n + 3) / 2, J) the same per product of two velocities, the pairs of the upper triangle.
        spin: (J,) the same per turn squared.
    """

    terms: LinearTerms
    moved: np.ndarray
    surface: np.ndarray
    pressure: np.ndarray
    square: np.ndarray
    spin: np.ndarray

    def sources(self, first: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """`orders.second_order_sources` of these modes, (m, 2, J); the others of the first order are at rest.

        Args:
            first: (m, 2, J) states of the first order.
            rows: (9, m) as for `orders.first_order`.
        """
        turn, lean, lean_rate = rows[2][:, None], lean_of(rows[:3]).T, lean_of(rows[3:6]).T
        change = first_order(self.terms, first, rows)[:, 1]
        height = first[:, 0, self.moved]
        velocity = np.hstack([first[:, 1, self.moved], lean])
        changes = np.hstack([change[:, self.moved], lean_rate, turn * velocity])
        upper = np.triu_indices(velocity.shape[1])
        source = _products(height, velocity) @ self.surface
        pressure = _products(height, changes) @ self.pressure
        pressure += (velocity[:, upper[0]] * velocity[:, upper[1]]) @ self.square
        pressure += turn**2 * self.spin
        return np.stack([source, pressure], axis=1)


def interactions(terms: LinearTerms, moved: np.ndarray) -> Interactions:
    """The forms of some modes of a basin, (n,) their places; the fields are those of `second_order_sources`."""
    modes, still = terms.basin.modes, terms.level
    kappa, wave = terms.stiffness[moved][:, None], modes.wave_number[moved][:, None]
    shape, slopes = modes.shape[:, moved].T, [slope[:, moved].T for slope in modes.slope]
    velocity = [np.vstack([slope, past]) for slope, past in zip(slopes, still.velocity, strict=False)]
    velocity.append(np.vstack([kappa * shape, still.velocity[2]]))
    bend = np.vstack([wave**2 * shape, still.growth[2]])
    x, y = modes.points.T
    carried = np.einsum("xp,xlp->lp", modes.turn, still.growth[:2]) + np.stack([y, -x])  # per lean and turn
    rising = np.vstack([kappa * shape, still.rise, kappa * terms.shear[:, moved].T, carried])
    weighted = modes.shape * modes.weight[:, None] / modes.norm

    def projected(products: np.ndarray) -> np.ndarray:
        return products.reshape(-1, products.shape[-1]) @ weighted

    def pairs(left: np.ndarray, right: np.ndarray) -> np.ndarray:
        found: np.ndarray = left[:, None] * right[None]
        return found

    squares = np.sum([pairs(part, part) for part in velocity], axis=0) / 2
    squares[-2:, -2:] -= pairs(np.stack([x, y]), np.stack([x, y])) / 2  # of |omega x r|^2, what leans
    upper = np.triu_indices(len(squares))
    twice = np.where(upper[0] == upper[1], 1.0, 2.0)[:, None]
    turned = x**2 + y**2 - np.einsum("xp,xp->p", modes.turn, modes.turn)
    return Interactions(
        terms=terms,
        moved=moved,
        surface=projected(pairs(shape, bend) - pairs(slopes[0], velocity[0]) - pairs(slopes[1], velocity[1])),
        pressure=projected(pairs(shape, rising)),
        square=projected(twice * squares[upper]),
        spin=-turned / 2 @ weighted,
    )


def _products(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Every product (m, n k) of a number of (m, n) with one of (m, k)."""
    found: np.ndarray = (left[:, :, None] * right[:, None]).reshape(len(left), -1)
    return found
