"""Smoothing: the smoothest spline within a tolerance of recorded points.

Recorded points scatter, if only by the last digit they are written with; a curve through all of them turns at every
one, and the tray with it. Among the splines of degree 5 on equal spans that begin and end where the points do, the one
is taken that has the least integral of its squared third derivative with every point within the tolerance: the
penalised least squares of Eilers and Marx (Flexible smoothing with B-splines and penalties, 1996), with the penalty as
large as the tolerance allows. Parameters of the points are their chord lengths at first, then their projections onto
the curve.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.core.piecewise import Pieces, bspline_pieces, design_matrix

_DEGREE = 5
_SPANS = (4, 8, 16, 32, 64)
_PROJECTIONS = 4
_BISECTIONS = 14
_PENALTIES = (-16.0, 2.0)
"""Range of the penalty: powers of ten."""
_STRIDE = 5.0
"""Points nearer to each other than this many tolerances do not add to the chord length: scatter is no way."""


@dataclass(frozen=True, slots=True, eq=False)
class SmoothCurve:
    """A smoothing spline.

    Attributes:
        pieces: the curve over s in [0, 1].
        s: (n,) parameter of each point.
        deviation: largest distance of a point from the curve at its parameter.
        at: index of that point.
    """

    pieces: Pieces
    s: np.ndarray
    deviation: float
    at: int


def smooth_curve(points: np.ndarray, tolerance: float) -> SmoothCurve | None:
    """The smoothest curve within `tolerance` of all points, on as few spans as it takes; None where 64 are too few.

    Args:
        points: (n, k), neighbours differ; there are at least two points to each control point.
        tolerance: largest distance of a point from the curve, in units of the points.
    """
    for spans in _admissible(len(points)):
        fit = _Fit(points, spans, tolerance)
        loose = fit.curve(_PENALTIES[0])
        if loose.deviation > tolerance:
            continue
        low, high = _PENALTIES
        best = loose
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            trial = fit.curve(middle)
            if trial.deviation <= tolerance:
                low, best = middle, trial
            else:
                high = middle
        return best
    return None


def closest_curve(points: np.ndarray, tolerance: float) -> SmoothCurve | None:
    """The least-squares curve on as many spans as `smooth_curve` tries at most; None for too few points."""
    spans = _admissible(len(points))
    return _Fit(points, spans[-1], tolerance).curve(_PENALTIES[0]) if spans else None


def _admissible(count: int) -> list[int]:
    return [spans for spans in _SPANS if 2 * (spans + _DEGREE) <= count]


class _Fit:
    """Least squares on given spans, for any penalty."""

    def __init__(self, points: np.ndarray, spans: int, tolerance: float) -> None:
        self._points = points
        inner = np.linspace(0.0, 1.0, spans + 1)[1:-1]
        self._knots = np.concatenate([np.zeros(_DEGREE + 1), inner, np.ones(_DEGREE + 1)])
        self._start = _chord_parameters(points, _STRIDE * tolerance)
        count = spans + _DEGREE
        nodes, weights = np.polynomial.legendre.leggauss(_DEGREE)
        places = ((np.arange(spans)[:, None] + 0.5 * (nodes + 1.0)) / spans).ravel()
        thirds = bspline_pieces(np.eye(count), _DEGREE, self._knots)(places, 3)
        root = np.sqrt(np.tile(weights, spans) / (2.0 * spans))[:, None] * thirds
        # times the number of points, so that a penalty has the same effect whatever that is
        self._roughness = len(points) * root.T @ root

    def curve(self, penalty: float) -> SmoothCurve:
        """The curve for a penalty of 10 to this power."""
        rough = 10.0**penalty * self._roughness
        s = self._start
        for _ in range(_PROJECTIONS):
            curve = self._solved(s, rough)
            s = _project(curve, self._points, s)
        curve = self._solved(s, rough)
        distance = np.linalg.norm(curve(s) - self._points, axis=1)
        worst = int(np.argmax(distance))
        return SmoothCurve(curve, s, float(distance[worst]), worst)

    def _solved(self, s: np.ndarray, rough: np.ndarray) -> Pieces:
        basis = design_matrix(s, self._knots, _DEGREE)
        gram, wanted = basis.T @ basis + rough, basis.T @ self._points
        ends = self._points[[0, -1]]
        inner = np.linalg.solve(gram[1:-1, 1:-1], wanted[1:-1] - gram[1:-1][:, [0, -1]] @ ends)
        return bspline_pieces(np.vstack([ends[:1], inner, ends[1:]]), _DEGREE, self._knots)


def _chord_parameters(points: np.ndarray, stride: float) -> np.ndarray:
    """Chord length over its total (n,), along those points that lie `stride` apart; by index between them."""
    chosen = [0]
    for index in range(1, len(points) - 1):
        if np.linalg.norm(points[index] - points[chosen[-1]]) >= stride:
            chosen.append(index)
    chosen.append(len(points) - 1)
    chords = np.linalg.norm(np.diff(points[chosen], axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(chords)])
    return np.interp(np.arange(len(points)), chosen, along / along[-1])


def _project(curve: Pieces, points: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Parameters (n,) of the nearest places of the curve: one Gauss-Newton step, ends and order kept."""
    tangent = curve(s, 1)
    along, speed = np.sum((curve(s) - points) * tangent, axis=1), np.sum(tangent**2, axis=1)
    moved = np.clip(s - along / np.maximum(speed, 1e-18), 0.0, 1.0)
    moved[0], moved[-1] = 0.0, 1.0
    return np.maximum.accumulate(moved)
