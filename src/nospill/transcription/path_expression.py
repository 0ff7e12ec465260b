"""The path inside an expression: the polynomial of one span, whose coefficients are parameters.

Which span holds is looked up beforehand, for all instants at once. So an expression knows neither how many spans a path
has nor, up to the usual degree, of which degree they are, and its derivatives are those of the span's polynomial.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from nospill.core.frames import SX
from nospill.laws.parameters import Structure

_USUAL_DEGREE = 5
"""Of arcs and paths through points; lower ones get coefficients of zero, higher ones have expressions of their own."""


@dataclass(frozen=True, slots=True)
class PathPiece:
    """The polynomial of one span.

    Attributes:
        origin: s at its start.
        coefficients: (4, degree + 1) of x, y, z in m and the yaw in rad, highest power of (s - origin) first.
    """

    origin: SX
    coefficients: SX

    @classmethod
    def of(cls, column: SX) -> PathPiece:
        """The piece that a column of `path_table` is."""
        return cls(column[0], ca.reshape(column[1:], -1, 4).T)

    def at(self, s: SX) -> tuple[SX, SX, SX]:
        """r(s), r'(s), r''(s) of x, y, z, yaw, each (4, 1)."""
        local = s - self.origin
        value, first, second = self.coefficients[:, 0], SX.zeros(4), SX.zeros(4)
        for power in range(1, self.coefficients.shape[1]):
            second = second * local + first
            first = first * local + value
            value = value * local + self.coefficients[:, power]
        return value, first, 2 * second


def piece_degree(structure: Structure) -> int:
    """Degree of the pieces that the expressions of a structure read."""
    return max(structure.degree, _USUAL_DEGREE)


def piece_size(degree: int) -> int:
    """Numbers of a piece."""
    return 1 + 4 * (degree + 1)


def path_table(breaks: np.ndarray, coefficients: np.ndarray, *, degree: int, filling: float = 0.0) -> np.ndarray:
    """The spans of a path as columns, (piece_size, m): s at the start, then the coefficients of x, y, z, yaw.

    Args:
        breaks: (m + 1,).
        coefficients: (k + 1, m, 4), highest power first, k at most `degree`.
        degree: of the pieces.
        filling: what stands for the powers that the path does not have.
    """
    missing = degree + 1 - len(coefficients)
    padded = np.concatenate([np.full((missing, *coefficients.shape[1:]), filling), coefficients])
    return np.concatenate([breaks[None, :-1], *np.moveaxis(padded, 2, 0)])


def span_of(breaks: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Index (n,) of the span that holds at s (n,): the first and the last one also beyond their ends."""
    return np.searchsorted(breaks[1:-1], s, side="right")
