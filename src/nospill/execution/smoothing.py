"""Recorded joint positions as a smooth motion with the band that their noise leaves.

A quintic spline on even knots is fitted to the positions of each joint; the integral of the square of its jerk is
penalised. The weight of the penalty and the variance of the noise are those that make the record most likely
(restricted maximum likelihood), with the penalty read as what is known of the motion beforehand [G. Wahba, A comparison
of GCV and GML for choosing the smoothing parameter in the generalized spline smoothing problem, Ann. Stat. 13 (1985)
1378]. The same reading gives the covariance of the spline, hence the band of positions, speeds and accelerations. At
both ends the arm is at rest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

BANDWIDTH = 50.0
"""Hz; motion that is followed, as in `simulation.container_motion`: knots stand half a period of it apart, and what is
faster counts as noise."""

_DEGREE, _ORDER = 5, 3
_WEIGHTS = (-24.0, 4.0)
"""Decimal exponents of the weight of the penalty between which it is looked for."""
_ENDS = 2
"""Coefficients at either end that equal their neighbour, so that the motion begins and ends at rest."""
_WINDOW, _LEAST_LOCAL = 0.1, 0.2
"""s; over which the noise of a place is taken, and the least part of the whole record's that it counts as."""
_LEAST_NOISE = 1e-12
"""rad; a record without noise still has rounded digits."""


@dataclass(frozen=True, slots=True, eq=False)
class SmoothJoints:
    """Joint positions as splines, with their noise; a `JointMotion` between its first and last sample.

    Attributes:
        knots: of all splines, s.
        coefficients: (N, n), rad.
        noise: (n,) standard deviation of a sample, rad.
        factors: (n, 6, N) banded Cholesky factors (lower) of the inverse covariance of the coefficients over noise^2.
        residual: (n,) rms distance of the samples from the splines, rad.
        local: (N, n) by how much the noise about each coefficient differs from that of the whole record.
    """

    knots: np.ndarray
    coefficients: np.ndarray
    noise: np.ndarray
    factors: np.ndarray
    residual: np.ndarray
    local: np.ndarray

    def __call__(self, t: np.ndarray, order: int = 0, /) -> np.ndarray:
        """The derivative of this order at times t (m,): (m, n)."""
        from scipy.interpolate import BSpline

        return BSpline(self.knots, self.coefficients, _DEGREE)(t, order)

    def deviation(self, t: np.ndarray, order: int = 0) -> np.ndarray:
        """Standard deviation of the derivative of this order at times t (m,), as the noise leaves it: (m, n)."""
        from scipy.linalg import cho_solve_banded

        rows = (_design(t, self.knots, order) @ _at_rest(len(self.coefficients))).toarray().T
        deviations = [
            noise * np.sqrt(np.sum(rows * cho_solve_banded((factor, True), rows), axis=0))
            for noise, factor in zip(self.noise, self.factors, strict=True)
        ]
        places = _greville(self.knots)
        local = np.column_stack([np.interp(t, places, factors) for factors in self.local.T])
        return np.column_stack(deviations) * local

    def drawn(self, generator: np.random.Generator) -> SmoothJoints:
        """A motion that the record could as well be of: drawn from the distribution of the coefficients."""
        from scipy.linalg import solve_banded

        columns = []
        for noise, factor in zip(self.noise, self.factors, strict=True):
            # A = L L^T: the solution of L^T x = z has the covariance A^-1.
            upper = np.zeros_like(factor)
            for below, diagonal in enumerate(factor):
                upper[_DEGREE - below, below:] = diagonal[: len(diagonal) - below]
            columns.append(noise * solve_banded((0, _DEGREE), upper, generator.standard_normal(factor.shape[1])))
        off = _at_rest(len(self.coefficients)) @ np.column_stack(columns)
        return replace(self, coefficients=self.coefficients + self.local * off)


def smooth_joints(
    t: np.ndarray, position: np.ndarray, period: float, *, bandwidth: float = BANDWIDTH, rest: float = 0.0
) -> SmoothJoints:
    """Fit the splines.

    Args:
        t: (m,) increasing, s.
        position: (m, n), rad.
        period: usual distance of samples, s.
        bandwidth: of the motion that is followed, Hz.
        rest: how long before the first sample and after the last one the splines begin and end, s.
    """
    begin, length = float(t[0]) - rest, float(t[-1] - t[0]) + 2.0 * rest
    every = max(1, round(0.5 / bandwidth / period))
    spans = max(1, round(length / (every * period)))
    inner = begin + length / spans * np.arange(1, spans)
    ends = np.repeat([[begin], [begin + length]], _DEGREE + 1, axis=1)
    knots = np.concatenate([ends[0], inner, ends[1]])
    free = _at_rest(spans + _DEGREE)
    basis = _design(t, knots, 0) @ free
    gram, rough = _bands(basis.T @ basis), _roughness(knots, spans, length)
    fits = [_fit(column, basis, gram, rough) for column in position.T]
    coefficients, noise, factors, residual = (np.array(part) for part in zip(*fits, strict=True))
    left = position - basis @ coefficients.T
    return SmoothJoints(knots, free @ coefficients.T, noise, factors, residual, _local(t, left, knots, period))


def _greville(knots: np.ndarray) -> np.ndarray:
    """Where each coefficient acts (N,), s."""
    count = len(knots) - _DEGREE - 1
    return np.mean([knots[place : place + count] for place in range(1, _DEGREE + 1)], axis=0)


def _local(t: np.ndarray, left: np.ndarray, knots: np.ndarray, period: float) -> np.ndarray:
    """Noise about each coefficient over that of the whole record, (N, n): rms of what is left over `_WINDOW`.

    Moving joints are noisier than standing ones, and where the jerk of the motion jumps more is left.
    """
    width = max(3, round(_WINDOW / period))
    window = np.ones(width) / width
    square = np.column_stack([np.convolve(column**2, window, mode="same") for column in left.T])
    whole = np.mean(left**2, axis=0)
    ratio = np.sqrt(np.where(whole > 0.0, square / np.where(whole > 0.0, whole, 1.0), 1.0))
    places = _greville(knots)
    local = np.column_stack([np.interp(places, t, np.maximum(column, _LEAST_LOCAL)) for column in ratio.T])
    # coefficients that are one stay one, or drawn motions would not rest at their ends
    local[:_ENDS], local[len(local) - _ENDS :] = local[_ENDS], local[len(local) - _ENDS - 1]
    return local


def _fit(
    values: np.ndarray, basis: Any, gram: np.ndarray, rough: np.ndarray
) -> tuple[np.ndarray, float, np.ndarray, float]:
    """Coefficients, noise, Cholesky factor and rms residual of one joint."""
    from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded
    from scipy.optimize import minimize_scalar

    mean = float(np.mean(values))
    values = values - mean
    wanted, freedom, count = basis.T @ values, len(values) - _ORDER, gram.shape[1]

    def solved(exponent: float) -> tuple[float, np.ndarray, float, np.ndarray, np.ndarray]:
        weight = 10.0**exponent
        factor = cholesky_banded(gram + weight * rough, lower=True)
        coefficients = cho_solve_banded((factor, True), wanted)
        left = values - basis @ coefficients
        # wanted @ found is the rest of the sum of squares, but not exactly where little is left of it
        # rounding makes the square of the jerk negative where the penalty outweighs the samples by far
        variance = (float(left @ left) + max(weight * float(coefficients @ _times(rough, coefficients)), 0.0)) / freedom
        variance = max(variance, _LEAST_NOISE**2)
        unlikely = freedom * np.log(variance) + 2.0 * float(np.sum(np.log(factor[0])))
        return unlikely - (count - _ORDER) * np.log(weight), coefficients, variance, factor, left

    def unlikely_or_none(exponent: float) -> float:
        try:
            return solved(exponent)[0]
        except LinAlgError:  # knots without a sample, or a penalty against which the samples are rounding
            return np.inf

    best: Any = minimize_scalar(unlikely_or_none, bounds=_WEIGHTS, method="bounded", options={"xatol": 0.05})
    _, coefficients, variance, factor, left = solved(float(best.x))
    return coefficients + mean, float(np.sqrt(variance)), factor, float(np.sqrt(np.mean(left**2)))


def _design(t: np.ndarray, knots: np.ndarray, order: int) -> Any:
    """Matrix (m, N) that gives the derivative of this order at t from the coefficients, sparse."""
    from scipy import sparse
    from scipy.interpolate import BSpline

    degree, count = _DEGREE, len(knots) - _DEGREE - 1
    change: Any = sparse.identity(count, format="csr")
    for _ in range(order):
        width = knots[degree + 1 : degree + count] - knots[1:count]
        change = sparse.diags_array(degree / width) @ (change[1:] - change[:-1])
        knots, degree, count = knots[1:-1], degree - 1, count - 1
    inside = np.clip(t, knots[degree], knots[-degree - 1])
    return BSpline.design_matrix(inside, knots, degree) @ change


def _at_rest(count: int) -> Any:
    """Matrix (N, N - 4) from free coefficients to all: speed and acceleration are zero at both ends of the splines."""
    from scipy import sparse

    free = np.clip(np.arange(count) - _ENDS, 0, count - 1 - 2 * _ENDS)
    return sparse.csr_array((np.ones(count), (np.arange(count), free)), shape=(count, count - 2 * _ENDS))


def _roughness(knots: np.ndarray, spans: int, length: float) -> np.ndarray:
    """Bands of the matrix whose quadratic form is the integral of the square of the third derivative."""
    places, weights = np.polynomial.legendre.leggauss(_DEGREE - _ORDER + 1)
    width = length / spans
    points = knots[0] + (width * (np.arange(spans)[:, None] + 0.5 * (places + 1.0))).ravel()
    third = _design(points, knots, _ORDER) @ _at_rest(spans + _DEGREE)
    return _bands(third.T @ third.multiply(np.tile(0.5 * width * weights, spans)[:, None]))


def _bands(matrix: Any) -> np.ndarray:
    """Lower bands (6, N) of a symmetric matrix, as LAPACK takes them."""
    count = matrix.shape[0]
    found = np.zeros((_DEGREE + 1, count))
    for below in range(_DEGREE + 1):
        found[below, : count - below] = matrix.diagonal(-below)
    return found


def _times(bands: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Product of a symmetric matrix, given by its lower bands, and a vector."""
    result = bands[0] * vector
    for below in range(1, len(bands)):
        diagonal = bands[below, : len(vector) - below]
        result[below:] += diagonal * vector[:-below]
        result[:-below] += diagonal * vector[below:]
    return result
