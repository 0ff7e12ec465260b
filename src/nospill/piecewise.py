"""Piecewise polynomials from B-splines and by interpolation, and their refinement onto common breaks."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from nospill.errors import ScenarioError

SAME_KNOT = 1e-9
"""Knots and breaks closer than this in s are one."""


@dataclass(frozen=True, slots=True)
class Pieces:
    """A piecewise polynomial: breaks (m + 1,), coefficients (degree + 1, m, k), in the convention of `paths.Path`."""

    breaks: np.ndarray
    coefficients: np.ndarray


def bspline_pieces(points: np.ndarray, degree: int, knots: np.ndarray) -> Pieces:
    """The B-spline's spans within [0, 1] as Taylor polynomials [de Boor, A Practical Guide to Splines, ch. IX and X].

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
    breaks = np.concatenate(([0.0], np.unique(inner), [1.0]))
    coefficients = np.zeros((degree + 1, breaks.size - 1, points.shape[1]))
    for piece, (left, right) in enumerate(pairwise(breaks)):
        span = int(np.searchsorted(knots, (left + right) / 2)) - 1
        control = points[span - degree : span + 1]
        local = knots[span - degree : span + degree + 2]
        for order in range(degree + 1):
            coefficients[degree - order, piece] = _de_boor(
                control, local[order:], degree - order, left
            ) / math.factorial(order)
            # The derivative's control points and, by dropping the outermost knots, its knots.
            width = local[degree + 1 : 2 * degree + 1 - order] - local[order + 1 : degree + 1]
            control = (degree - order) * np.diff(control, axis=0) / width[:, None]
    return Pieces(breaks, coefficients)


def _de_boor(control: np.ndarray, knots: np.ndarray, degree: int, s: float) -> np.ndarray:
    """Value at s of the one span [knots[degree], knots[degree + 1]] that the degree + 1 control points govern."""
    values = control.copy()
    for level in range(1, degree + 1):
        low = knots[level : degree + 1]
        weight = ((s - low) / (knots[degree + 1 : 2 * degree + 2 - level] - low))[:, None]
        values = (1 - weight) * values[:-1] + weight * values[1:]
    return values[0]


def interpolating_pieces(s: np.ndarray, values: np.ndarray) -> Pieces:
    """Polynomial through up to five values, not-a-knot spline of degree 5 (C4) through more.

    Args:
        s: (n,) increasing from 0 to 1, n >= 2.
        values: (n, k).
    """
    from scipy.interpolate import make_interp_spline  # a third of a second that other paths need not pay

    spline = make_interp_spline(s, values, k=min(5, len(s) - 1))
    return bspline_pieces(spline.c, spline.k, spline.t)


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
