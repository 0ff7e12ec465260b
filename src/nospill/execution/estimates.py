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


@dataclass(frozen=True, slots=True)
class Estimate:
    """A number learnt from a run.

    Attributes:
        name: what it is.
        subject: of which object or joint.
        unit: SI.
        value: the best one.
        deviation: its standard deviation.
        least_told: the half width of an interval above which the motion tells too little.
    """

    name: str
    subject: str
    unit: str
    value: float
    deviation: float
    least_told: float

    @property
    def half_width(self) -> float:
        """Of the interval of 95 %."""
        return WIDE * self.deviation

    @property
    def told(self) -> bool:
        """Whether the motion tells it."""
        return bool(self.half_width <= self.least_told)


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """The best numbers of a law for a record: values (p,), covariance (p, p), rms of what is left."""

    values: np.ndarray
    covariance: np.ndarray
    left: float


def fitted(
    residuals: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
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

    found = least_squares(
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
    left, slopes = both(found.x)
    return Fit(found.x, _covariance(left, slopes, neighbours), float(np.sqrt(np.mean(left**2))))


def _covariance(left: np.ndarray, slopes: np.ndarray, neighbours: int) -> np.ndarray:
    """Of the values; infinite where the record says nothing of one of them."""
    count, size = slopes.shape
    scale = np.linalg.norm(slopes, axis=0)
    if not np.all(scale > 0.0):
        covariance = np.zeros((size, size))
        np.fill_diagonal(covariance, np.inf)
        return covariance
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
    return alone * np.outer(wider, wider) / np.outer(scale, scale)
