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
        span = np.searchsorted(self.breaks[1:-1], x, side="right")
        # as wide as the values: a product with one column is taken row by row
        offset = np.repeat((x - self.breaks[span])[:, None], self.coefficients.shape[2], axis=1)
        degree = self.coefficients.shape[0] - 1
        result = np.zeros(offset.shape)
        for index in range(degree - order + 1):
            result *= offset
            result += (math.perm(degree - index, order) * self.coefficients[index]).take(span, axis=0)
        return result

    def by_columns(self, x: np.ndarray, order: int = 0) -> np.ndarray:
        """The same, shape (n, k), each column at its own places: x (n, k)."""
        span = np.searchsorted(self.breaks[1:-1], x, side="right")
        offset, degree = x - self.breaks[span], self.coefficients.shape[0] - 1
        places = span * x.shape[1] + np.arange(x.shape[1])  # np.take_along_axis does the same in twice the time
        result = np.zeros(x.shape)
        for index in range(degree - order + 1):
            result *= offset
            result += math.perm(degree - index, order) * self.coefficients[index].take(places)
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
    return _expand(points, degree, knots, np.concatenate(([0.0], np.unique(inner), [1.0])))


def _expand(points: np.ndarray, degree: int, knots: np.ndarray, breaks: np.ndarray) -> Pieces:
    """A B-spline about the left ends of its spans between `breaks`."""
    return Pieces(breaks, _Expansion.between(breaks, knots, degree).of(points))


@dataclass(frozen=True, slots=True)
class _Expansion:
    """Taylor coefficients of splines on the same knots [de Boor, A Practical Guide to Splines, ch. X].

    The control points of a derivative are divided differences of those before, and its value is their sum weighted by
    the B-splines of the degree that is left.

    Attributes:
        first: (m,) the first of the control points that govern a span.
        basis: by order of derivative, the B-splines at the left ends over order!, (degree + 1 - order, m, 1).
        factors: by order of derivative, differences of control points -> those of the next, (n - 1 - order, 1).
    """

    first: np.ndarray
    basis: tuple[np.ndarray, ...]
    factors: tuple[np.ndarray, ...]

    @classmethod
    def between(cls, breaks: np.ndarray, knots: np.ndarray, degree: int) -> _Expansion:
        """About the left ends of the spans between breaks (m + 1,)."""
        span, last = np.searchsorted(knots, (breaks[:-1] + breaks[1:]) / 2) - 1, len(knots) - 1
        basis = tuple(
            _basis(breaks[:-1], knots[order : last + 1 - order], degree - order, span - order)[:, :, None]
            / math.factorial(order)
            for order in range(degree + 1)
        )
        widths = [knots[degree + 1 : last - order] - knots[order + 1 : last - degree] for order in range(degree)]
        # between knots repeated beyond the degree stands a control point that governs no span
        factors = tuple(
            np.divide(degree - order, width, out=np.zeros_like(width), where=width > 0.0)[:, None]
            for order, width in enumerate(widths)
        )
        return cls(span - degree, basis, factors)

    @property
    def degree(self) -> int:
        """Of the splines."""
        return len(self.factors)

    def of(self, control: np.ndarray) -> np.ndarray:
        """Coefficients (degree + 1, m, k), as in `Pieces`, of the spline with control points (n, k)."""
        coefficients = np.zeros((self.degree + 1, len(self.first), control.shape[1]))
        for order, basis in enumerate(self.basis):
            for index, weight in enumerate(basis):
                coefficients[self.degree - order] += weight * control.take(self.first + index, axis=0)
            if order < self.degree:
                control = self.factors[order] * np.diff(control, axis=0)
        return coefficients


def interpolating_spline(x: np.ndarray, values: np.ndarray, degree: int) -> Pieces:
    """Not-a-knot spline through values: no break next to the ends, so that n conditions suffice [de Boor, ch. XIII].

    CasADi solves for the control points: loading SciPy for its `make_interp_spline`, which does the same, takes a third
    of a second.

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
        entries: of the band matrix of the B-splines at the places, control points -> values, see `_entries`.
        expansion: about the breaks.
    """

    breaks: np.ndarray
    entries: np.ndarray
    expansion: _Expansion

    def through(self, values: np.ndarray) -> Pieces:
        """The spline through values (n, k)."""
        from nospill.core.batches import call  # CasADi: reading a scenario needs none of it

        solve = _band_solver(*values.shape, self.expansion.degree)
        return Pieces(self.breaks, self.expansion.of(call(solve, self.entries, values)))


@lru_cache(maxsize=8)
def _interpolation(places: bytes, degree: int) -> _Interpolation:
    """Of places (n,) as bytes: motions, tilt and progress of one record are splines on the same ones."""
    x, ends = np.frombuffer(places), (degree + 1) // 2
    inner = x[ends:-ends] if len(x) > degree + 1 else x[:0]
    knots = np.concatenate([np.repeat(x[0], degree + 1), inner, np.repeat(x[-1], degree + 1)])
    breaks = np.concatenate([x[:1], inner, x[-1:]])
    span = _span_of(x, knots, degree)
    entries = _entries(_basis(x, knots, degree, span), span - degree)
    return _Interpolation(breaks, entries, _Expansion.between(breaks, knots, degree))


def _span_of(x: np.ndarray, knots: np.ndarray, degree: int) -> np.ndarray:
    """Index (n,) of the knot at which the span of each x (n,) begins."""
    return np.clip(np.searchsorted(knots, x, side="right") - 1, degree, len(knots) - degree - 2)


def _basis(x: np.ndarray, knots: np.ndarray, degree: int, span: np.ndarray) -> np.ndarray:
    """The B-splines (degree + 1, n) that are not zero in spans (n,), at x (n,); the first of them is span - degree."""
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
    return basis


def design_matrix(x: np.ndarray, knots: np.ndarray, degree: int) -> np.ndarray:
    """All B-splines on some knots at x (n,), shape (n, len(knots) - degree - 1)."""
    span = _span_of(x, knots, degree)
    matrix = np.zeros((len(x), len(knots) - degree - 1))
    columns = span - degree + np.arange(degree + 1)[:, None]
    matrix[np.arange(len(x)), columns] = _basis(x, knots, degree, span)
    return matrix


def _entries(basis: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Nonzeros of the matrix (n, n) with basis[j, i] in row i and column first[i] + j, of `Sparsity.banded`."""
    count, band = basis.shape[1], len(basis) - 1
    places = first + np.arange(band + 1)[:, None]
    columns = np.zeros((count, 2 * band + 1))
    columns[places, np.arange(count) - places + band] = basis
    row = np.arange(count)[:, None] + np.arange(-band, band + 1)
    return columns[(row >= 0) & (row < count)]


@lru_cache(maxsize=8)
def _band_solver(count: int, columns: int, band: int) -> Any:
    """CasADi function: nonzeros of a band matrix, right-hand sides (count, columns) -> solutions (count, columns)."""
    import casadi as ca

    sparsity = ca.Sparsity.banded(count, band)
    entries, given = ca.MX.sym("entries", sparsity.nnz()), ca.MX.sym("given", count, columns)
    return ca.Function("spline", [entries, given], [ca.solve(ca.MX(sparsity, entries), given, "csparse", {})])


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
