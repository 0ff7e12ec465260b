"""The path inside an expression: the polynomial of one span, whose coefficients are parameters.

Which span holds is looked up beforehand, for all instants at once. So an expression knows neither how many spans a path
has nor, up to the usual degree, of which degree they are, and its derivatives are those of the span's polynomial.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from nospill.core.frames import SX
from nospill.laws.structure import Structure
from nospill.paths.joint_curves import POSE

_USUAL_DEGREE = 5
"""Of arcs and paths through points; lower ones get coefficients of zero, higher ones have expressions of their own."""


@dataclass(frozen=True, slots=True)
class PathPiece:
    """The polynomial of one span.

    Attributes:
        origin: s at its start.
        coefficients: (c, degree + 1) of what the path says, `Path.prescribed`, highest power of (s - origin) first.
    """

    origin: SX
    coefficients: SX

    @classmethod
    def of(cls, column: SX, columns: int = 4) -> PathPiece:
        """The piece that a column of `path_table` is, of so many columns of the path."""
        return cls(column[0], ca.reshape(column[1:], -1, columns).T)

    def at(self, s: SX) -> tuple[SX, SX, SX]:
        """r(s), r'(s), r''(s) of what the path says, each (c, 1)."""
        local, none = s - self.origin, SX.zeros(self.coefficients.shape[0])
        value, first, second = self.coefficients[:, 0], none, none
        for power in range(1, self.coefficients.shape[1]):
            second = second * local + first
            first = first * local + value
            value = value * local + self.coefficients[:, power]
        return value, first, 2 * second

    def third(self, s: SX) -> SX:
        """r'''(s), (c, 1)."""
        symbol = SX.sym("s")
        return ca.substitute(ca.jacobian(self.at(symbol)[2], symbol), symbol, s)

    @property
    def of_tray(self) -> PathPiece:
        """Of a path of the joints: the tray's pose."""
        return PathPiece(self.origin, self.coefficients[:POSE, :])

    @property
    def of_joints(self) -> PathPiece:
        """Of a path of the joints: the joints."""
        return PathPiece(self.origin, self.coefficients[POSE:, :])


def piece_degree(structure: Structure) -> int:
    """Degree of the pieces that the expressions of a structure read."""
    return max(structure.degree, _USUAL_DEGREE)


def piece_size(degree: int, columns: int = 4) -> int:
    """Numbers of a piece."""
    return 1 + columns * (degree + 1)


def path_table(breaks: np.ndarray, coefficients: np.ndarray, *, degree: int, filling: float = 0.0) -> np.ndarray:
    """The spans of a path as columns, (piece_size, m): s at the start, then the coefficients column by column.

    Args:
        breaks: (m + 1,).
        coefficients: (k + 1, m, c), highest power first, k at most `degree`.
        degree: of the pieces.
        filling: what stands for the powers that the path does not have.
    """
    missing = degree + 1 - len(coefficients)
    padded = np.concatenate([np.full((missing, *coefficients.shape[1:]), filling), coefficients])
    return np.concatenate([breaks[None, :-1], *np.moveaxis(padded, 2, 0)])


def span_of(breaks: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Index (n,) of the span that holds at s (n,): the first and the last one also beyond their ends."""
    return np.searchsorted(breaks[1:-1], s, side="right")
