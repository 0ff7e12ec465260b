"""Bessel functions of the first kind and the roots of their derivatives, without scipy, which plans do without.

J_m(x) is the mean of cos(m tau - x sin tau) over a turn [Abramowitz and Stegun, 9.1.21], and the mean of a periodic
function over even steps is exact as soon as these are finer than its waves.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

_LEAST_STEPS, _STEPS_PER_ARGUMENT = 64, 4
"""Of a turn: m + x waves at most count, and the rest is below 1e-16."""
_SEARCH = 0.05
"""Distance of the arguments between which a change of sign is looked for; roots are more than 2 apart."""
_NEWTON_STEPS = 8


def bessel(order: int, x: np.ndarray | float) -> np.ndarray:
    """J_m(x) of an order m, for arguments of any shape."""
    x = np.asarray(x, dtype=float)
    steps = _LEAST_STEPS + _STEPS_PER_ARGUMENT * math.ceil(abs(order) + float(np.max(np.abs(x), initial=0.0)))
    tau = 2 * np.pi * np.arange(steps) / steps
    return np.mean(np.cos(order * tau - np.multiply.outer(x, np.sin(tau))), axis=-1)


def bessel_slope(order: int, x: np.ndarray | float) -> np.ndarray:
    """Derivative of J_m, by its two neighbours."""
    return (bessel(order - 1, x) - bessel(order + 1, x)) / 2


@cache
def slope_roots(order: int, largest: float) -> tuple[float, ...]:
    """Arguments above 0 and up to `largest` at which J_m has no slope, in their order."""
    x = np.arange(max(order, _SEARCH), largest + 2 * _SEARCH, _SEARCH)  # the first one is above m
    values = bessel_slope(order, x)
    roots = x[:-1][values[:-1] * values[1:] <= 0.0] + _SEARCH / 2
    for _ in range(_NEWTON_STEPS):  # J'' = (m^2/x^2 - 1) J - J'/x
        slope = bessel_slope(order, roots)
        roots = roots - slope / ((order**2 / roots**2 - 1) * bessel(order, roots) - slope / roots)
    return tuple(float(root) for root in roots if root <= largest)


@cache
def slope_root(order: int, number: int) -> float:
    """The root of that number, counted from 1."""
    largest = order + math.pi * (number + 1.0) + 3.0 * order ** (1 / 3)
    return slope_roots(order, largest)[number - 1]
