"""Piecewise polynomials: their values, from B-splines and by interpolation, and their refinement onto common breaks."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from nospill.errors import ScenarioError

SAME_KNOT = 1e-9
"""Knots and breaks closer than this in s are one."""


@dataclass(frozen=True, slots=True)
class Pieces:
    """A piecewise polynomial: breaks (m + 1,), coefficients (degree + 1, m, k), in the convention of `paths.Path`."""

    breaks: np.ndarray
    coefficients: np.ndarray

    def __call__(self, x: np.ndarray, order: int = 0, /) -> np.ndarray:
        """The derivative of an order at x (n,), shape (n, k); see `paths.Path.derivative`."""
        last = self.coefficients.shape[1] - 1
        span = np.clip(np.searchsorted(self.breaks, x, side="right") - 1, 0, last)
        offset = (x - self.breaks[span])[:, None]
        degree = self.coefficients.shape[0] - 1
        result = np.zeros((x.size, self.coefficients.shape[2]))
        for index in range(degree - order + 1):
            result *= offset
            result += math.perm(degree - index, order) * self.coefficients[index].take(span, axis=0)
        return result


def bspline_pieces(points: np.ndarray, degree: int, knots: np.ndarray) -> Pieces:
    """The B-spline's spans within [0, 1] as Taylor polynomials.

    Args:
        points: (n, k) control points.
        degree: polynomial degree below n.
        knots: (n + degree + 1,) not decreasing, with a base interval that contains [0, 1].

    Raises:
        ScenarioError: repeated knots inside make the second derivative jump.
    """
    # Knots equal but for rounding are made equal, also where they meet the ends, so that no sliver of a span is left.
    knots = knots.copy()
    for index in range(1, knots.size):
        if knots[index] - knots[index - 1] <= SAME_KNOT:
            knots[index] = knots[index - 1]
    inner = knots[(knots > SAME_KNOT) & (knots < 1 - SAME_KNOT)]
    for knot in np.unique(inner):
        if degree - np.count_nonzero(inner == knot) < 2:
            raise ScenarioError(
                f"B-spline of degree {degree} with knot {knot:g}: its second derivative jumps there, so the tray's "
                "acceleration would; raise the degree or remove the repeated knot"
            )
    return _expanded(points, degree, knots, np.concatenate(([0.0], np.unique(inner), [1.0])))


def _expanded(points: np.ndarray, degree: int, knots: np.ndarray, breaks: np.ndarray) -> Pieces:
    """A B-spline about the left ends of its spans between `breaks`."""
    control = points[_window(_spans(knots, breaks), degree)]
    return Pieces(breaks, _taylor(control, degree, knots, breaks))


def _spans(knots: np.ndarray, breaks: np.ndarray) -> np.ndarray:
    """Index (m,) of the knot at which every span between breaks begins."""
    return np.searchsorted(knots, (breaks[:-1] + breaks[1:]) / 2) - 1


def _window(span: np.ndarray, degree: int) -> np.ndarray:
    """Indices (m, degree + 1) of the control points that govern spans (m,)."""
    return span[:, None] + np.arange(-degree, 1)


def _taylor(control: np.ndarray, degree: int, knots: np.ndarray, breaks: np.ndarray) -> np.ndarray:
    """Taylor coefficients (degree + 1, m, k) about the left ends of spans [de Boor, Practical Guide to Splines, ch. X].

    `control` are the control points (m, degree + 1, k) that govern each of them.
    """
    left = breaks[:-1]
    local = knots[_spans(knots, breaks)[:, None] + np.arange(-degree, degree + 2)]
    coefficients = np.zeros((degree + 1, left.size, control.shape[2]))
    for order in range(degree + 1):
        value = _de_boor(control, local[:, order:], degree - order, left)
        coefficients[degree - order] = value / math.factorial(order)
        # The derivative's control points and, by dropping the outermost knots, its knots.
        width = local[:, degree + 1 : 2 * degree + 1 - order] - local[:, order + 1 : degree + 1]
        control = (degree - order) * np.diff(control, axis=1) / width[:, :, None]
    return coefficients


def _de_boor(control: np.ndarray, knots: np.ndarray, degree: int, s: np.ndarray) -> np.ndarray:
    """Values (m, k) at s (m,), each in the one span that its control points (m, degree + 1, k) govern.

    Those are the spans [knots[:, degree], knots[:, degree + 1]].
    """
    values = control
    for level in range(1, degree + 1):
        low = knots[:, level : degree + 1]
        weight = ((s[:, None] - low) / (knots[:, degree + 1 : 2 * degree + 2 - level] - low))[:, :, None]
        values = (1 - weight) * values[:, :-1] + weight * values[:, 1:]
    return values[:, 0]


def interpolating_spline(x: np.ndarray, values: np.ndarray, degree: int) -> Pieces:
    """Not-a-knot spline through values: no break beside the ends, so that n conditions suffice [de Boor, ch. XIII].

    CasADi solves for the control points: loading SciPy for its `make_interp_spline`, which does the same in a fifth of
    these three milliseconds, takes a third of a second.

    Args:
        x: (n,) increasing, n > degree.
        values: (n, k).
        degree: odd, or n - 1, which gives the polynomial through all values.

    Raises:
        ValueError: x does not increase, or there are too few of them.
    """
    count = len(x)
    if count <= degree or not np.all(np.diff(x) > 0.0):
        raise ValueError(f"{count} values do not make a spline of degree {degree}, or their places do not increase")
    return _interpolation(np.asarray(x, dtype=float).tobytes(), degree).through(values)


@dataclass(frozen=True, slots=True)
class _Interpolation:
    """What splines through values at the same places have in common.

    Attributes:
        breaks: (m + 1,).
        matrix: CasADi's, of the B-splines at the places: control points -> values.
        window: (m, degree + 1) control points that govern a span.
        taylor: (m, degree + 1, degree + 1) control points of a span -> its coefficients.
    """

    breaks: np.ndarray
    matrix: Any
    window: np.ndarray
    taylor: np.ndarray

    def through(self, values: np.ndarray) -> Pieces:
        """The spline through values (n, k)."""
        import casadi as ca  # reading a scenario needs none of it

        solved = ca.Linsol("spline", "csparse", self.matrix.sparsity()).solve(self.matrix, ca.DM(values))
        coefficients = self.taylor @ np.asarray(solved)[self.window]
        return Pieces(self.breaks, np.ascontiguousarray(np.swapaxes(coefficients, 0, 1)))


@lru_cache(maxsize=8)
def _interpolation(places: bytes, degree: int) -> _Interpolation:
    """Of places (n,) as bytes: motions, tilt and progress of one record are splines on the same ones."""
    x, beside = np.frombuffer(places), (degree + 1) // 2
    inner = x[beside:-beside] if len(x) > degree + 1 else x[:0]
    knots = np.concatenate([np.repeat(x[0], degree + 1), inner, np.repeat(x[-1], degree + 1)])
    breaks = np.concatenate([x[:1], inner, x[-1:]])
    span = _spans(knots, breaks)
    units = np.broadcast_to(np.eye(degree + 1), (len(span), degree + 1, degree + 1))
    taylor = np.ascontiguousarray(np.swapaxes(_taylor(units, degree, knots, breaks), 0, 1))
    return _Interpolation(breaks, _matrix(*_basis(x, knots, degree)), _window(span, degree), taylor)


def _basis(x: np.ndarray, knots: np.ndarray, degree: int) -> tuple[np.ndarray, np.ndarray]:
    """The B-splines (degree + 1, n) that are not zero at x (n,), and the index (n,) of the first of them."""
    span = np.clip(np.searchsorted(knots, x, side="right") - 1, degree, len(knots) - degree - 2)
    basis = np.zeros((degree + 1, len(x)))
    basis[0] = 1.0
    for level in range(1, degree + 1):
        carried = np.zeros(len(x))
        for index in range(level):
            right, left = knots[span + index + 1], knots[span + 1 - level + index]
            share = basis[index] / (right - left)
            basis[index] = carried + (right - x) * share
            carried = (x - left) * share
        basis[level] = carried
    return basis, span - degree


def design_matrix(x: np.ndarray, knots: np.ndarray, degree: int) -> np.ndarray:
    """All B-splines on some knots at x (n,), shape (n, len(knots) - degree - 1)."""
    basis, first = _basis(x, knots, degree)
    matrix = np.zeros((len(x), len(knots) - degree - 1))
    matrix[np.arange(len(x)), first + np.arange(degree + 1)[:, None]] = basis
    return matrix


def _matrix(basis: np.ndarray, first: np.ndarray) -> Any:
    """CasADi's matrix (n, n) with basis[j, i] in row i and column first[i] + j."""
    import casadi as ca

    count, band = basis.shape[1], len(basis) - 1
    places = first + np.arange(band + 1)[:, None]
    columns = np.zeros((count, 2 * band + 1))
    columns[places, np.arange(count) - places + band] = basis
    row = np.arange(count)[:, None] + np.arange(-band, band + 1)
    return ca.DM(ca.Sparsity.banded(count, band), columns[(row >= 0) & (row < count)])


def interpolating_pieces(s: np.ndarray, values: np.ndarray) -> Pieces:
    """Polynomial through up to five values, not-a-knot spline of degree 5 (C4) through more.

    Args:
        s: (n,) increasing from 0 to 1, n >= 2.
        values: (n, k).
    """
    return interpolating_spline(s, values, min(5, len(s) - 1))


def spline_of_curve(curve: Callable[[np.ndarray, int], np.ndarray], *, tolerance: float) -> Pieces | None:
    """C4 spline of degree 5 on as few equal spans as keep it within `tolerance` of a smooth curve; None beyond 256.

    Args:
        curve: function of s (n,) and the order of the derivative, giving (n, k); slope and curvature are met at the
            ends.
        tolerance: largest distance at equal s.
    """
    from scipy.interpolate import make_interp_spline

    ends = np.array([0.0, 1.0])
    conditions = tuple([(order, curve(ends, order)[side]) for order in (1, 2)] for side in (0, 1))
    probe = np.linspace(0.0, 1.0, 2001)
    for spans in (4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 256):
        nodes = np.linspace(0.0, 1.0, spans + 1)
        spline = make_interp_spline(nodes, curve(nodes, 0), k=5, bc_type=conditions)
        if np.max(np.linalg.norm(spline(probe) - curve(probe, 0), axis=1)) < tolerance:
            return bspline_pieces(spline.c, spline.k, spline.t)
    return None


def refined(pieces: Pieces, breaks: np.ndarray, *, degree: int) -> np.ndarray:
    """The same polynomials about the left ends of finer spans, padded with zeros up to `degree`."""
    own_degree = len(pieces.coefficients) - 1
    middle = (breaks[1:] + breaks[:-1]) / 2
    source = np.clip(np.searchsorted(pieces.breaks, middle, side="right") - 1, 0, pieces.breaks.size - 2)
    offset = (breaks[:-1] - pieces.breaks[source])[:, None]
    result = np.zeros((degree + 1, middle.size, pieces.coefficients.shape[2]))
    for power in range(own_degree + 1):
        total = np.zeros(result.shape[1:])
        for higher in range(own_degree, power - 1, -1):
            total = total * offset + math.comb(higher, power) * pieces.coefficients[own_degree - higher, source]
        result[degree - power] = total
    return result
