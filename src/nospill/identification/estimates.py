"""Least squares on our own laws: estimates with intervals, and what a motion does not tell.

Residuals of a law that is not quite right are not independent, and intervals that take them to be are too narrow. So
the covariance is the larger of two: that of independent residuals, and one that counts what neighbours share
[W. K. Newey, K. D. West, A simple, positive semi-definite covariance matrix, Econometrica 55 (1987) 703].
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

WIDE = 1.96
"""Standard deviations to either side of an interval of 95 %."""
_QUADRATIC = 0.25
_DOUBLINGS = 6

Residuals = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Values (p,) -> residuals (m,) and their derivatives (m, p)."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A number learnt from a run.

    Attributes:
        name: what it is.
        subject: of which object or joint.
        unit: SI.
        value: the best one.
        deviation: its standard deviation.
        widest_identifiable: the half width of an interval above which the motion tells too little.
        ends: of the interval of 95 % where it is not symmetric, from the profile of the likelihood.
    """

    name: str
    subject: str
    unit: str
    value: float
    deviation: float
    widest_identifiable: float
    ends: tuple[float, float] | None = None

    @property
    def interval(self) -> tuple[float, float]:
        """Of 95 %."""
        return self.ends or (self.value - WIDE * self.deviation, self.value + WIDE * self.deviation)

    @property
    def half_width(self) -> float:
        """Of the interval of 95 %; of its longer half."""
        low, high = self.interval
        return max(self.value - low, high - self.value)

    @property
    def identifiable(self) -> bool:
        """Whether the motion identifies it: the interval is narrow enough."""
        return bool(self.half_width <= self.widest_identifiable)


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """The best numbers of a law for a record.

    Attributes:
        values: (p,).
        covariance: (p, p).
        left: root mean square of what is left.
        alone: (p,) standard deviations if residuals were independent.
    """

    values: np.ndarray
    covariance: np.ndarray
    left: float
    alone: np.ndarray


def fitted(
    residuals: Residuals,
    start: np.ndarray,
    scale: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    *,
    neighbours: int,
) -> Fit:
    """Least squares within bounds.

    Args:
        residuals: values (p,) -> residuals (m,) and their derivatives (m, p).
        start: (p,) first values.
        scale: (p,) changes of the values that matter alike.
        lower: (p,).
        upper: (p,).
        neighbours: residuals so many places apart may have something in common.
    """
    from scipy.optimize import least_squares

    known: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}

    def both(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        key = np.asarray(values, dtype=float).tobytes()
        if key not in known:
            known.clear()
            known[key] = residuals(np.asarray(values, dtype=float))
        return known[key]

    solution = least_squares(
        lambda values: both(values)[0],
        start,
        jac=lambda values: both(values)[1],  # type: ignore[arg-type] # the stubs know no functions of their own
        bounds=(lower, upper),
        x_scale=scale,
        xtol=1e-7,
        ftol=1e-9,
        gtol=1e-14,
        max_nfev=40,
    )
    left, slopes = both(solution.x)
    covariance, alone = _covariance(left, slopes, neighbours)
    return Fit(solution.x, covariance, float(np.sqrt(np.mean(left**2))), alone)


def profile_ends(
    residuals: Residuals, fit: Fit, place: int, lower: np.ndarray, upper: np.ndarray
) -> tuple[float, float] | None:
    """Ends of the interval of 95 % of a value from the profile of the likelihood; None where it is quadratic.

    The value is held, the others follow it by their covariance and one Gauss-Newton step; the interval ends where the
    sum of squares has grown by the square of `WIDE` times the variance. Quadratic is a profile that has grown by that,
    within a quarter, at the ends of the symmetric interval. A bound of the value ends the interval too.

    Args:
        residuals: as of `fitted`.
        fit: the fit.
        place: of the value.
        lower: as of `fitted`.
        upper: likewise.
    """
    least = np.sum(residuals(fit.values)[0] ** 2)
    count = round(least / fit.left**2)
    deviation = float(np.sqrt(fit.covariance[place, place]))
    variance = least / max(count - len(fit.values), 1) * (deviation / fit.alone[place]) ** 2
    free = np.arange(len(fit.values)) != place

    along = fit.covariance[free, place] / fit.covariance[place, place]

    def growth(value: float) -> float:
        others = fit.values[free] + along * (value - fit.values[place])
        left, slopes = residuals(np.insert(others, place, value))
        step = np.linalg.lstsq(slopes[:, free], -left, rcond=None)[0]
        again = left + slopes[:, free] @ step
        return float(again @ again - least) / variance / WIDE**2

    middle, bounds = float(fit.values[place]), (float(lower[place]), float(upper[place]))
    usual = [float(np.clip(middle + sign * WIDE * deviation, *bounds)) for sign in (-1.0, 1.0)]
    if all(end not in bounds and abs(growth(end) - 1.0) < _QUADRATIC for end in usual):
        return None
    low, high = (_end(growth, middle, end, bound) for end, bound in zip(usual, bounds, strict=True))
    return low, high


def _end(growth: Callable[[float], float], middle: float, usual: float, bound: float) -> float:
    """Where the growth is 1, to a hundredth of the way; the bound where it stays below."""
    far = usual
    for _ in range(_DOUBLINGS):
        if far == bound or growth(far) >= 1.0:
            break
        doubled = middle + 2.0 * (far - middle)
        far = bound if abs(doubled - middle) > abs(bound - middle) else doubled
    if growth(far) < 1.0:
        return bound
    near = middle
    while abs(far - near) > 0.01 * abs(far - middle):
        halfway = 0.5 * (near + far)
        near, far = (halfway, far) if growth(halfway) < 1.0 else (near, halfway)
    return 0.5 * (near + far)


def _covariance(left: np.ndarray, slopes: np.ndarray, neighbours: int) -> tuple[np.ndarray, np.ndarray]:
    """Of the values, infinite where the record says nothing of one of them; deviations of independent residuals."""
    count, size = slopes.shape
    scale = np.linalg.norm(slopes, axis=0)
    if not np.all(scale > 0.0):
        covariance = np.zeros((size, size))
        np.fill_diagonal(covariance, np.inf)
        return covariance, np.full(size, np.inf)
    unit = slopes / scale
    inverse = np.linalg.pinv(unit.T @ unit, rcond=1e-14, hermitian=True)
    alone = float(left @ left) / max(count - size, 1) * inverse
    moments = unit * left[:, None]
    middle = moments.T @ moments
    for apart in range(1, min(neighbours, count - 1) + 1):
        shared = moments[apart:].T @ moments[:-apart]
        middle += (1.0 - apart / (neighbours + 1)) * (shared + shared.T)
    together = inverse @ middle @ inverse
    wider = np.sqrt(np.maximum(np.diag(together) / np.diag(alone), 1.0)) if np.any(left) else np.ones(size)
    return alone * np.outer(wider, wider) / np.outer(scale, scale), np.sqrt(np.diag(alone)) / scale
