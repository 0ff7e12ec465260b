"""A joint that follows its command by a lag of second order, T^2 q'' + 2 D T q' + q = command(t - delay).

Fitted where a lag of first order leaves more than noise. The command is put on an even grid, straight between its
points, and the equation solved from point to point without further error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from nospill.identification.estimates import Estimate, fitted

_STEP = 5e-4
"""s, of the grid; a command of 10 rad/s^2 is 3e-7 rad from its chords."""
_AFTER = 0.6
"""s; of rest after the command, in which the lag dies."""
_CHANGE = np.array([1e-5, 1e-3])
"""s, and part; of the differences that give the derivatives by T and D."""
_LOWER, _UPPER = np.array([5e-4, 0.05]), np.array([0.2, 5.0])
_STARTS = ((0.006, 0.5), (0.006, 1.0), (0.02, 0.5), (0.02, 1.0))
"""T in s, and damping ratio, to fit from; the delay so that the whole is as late as with first order."""
_SLOW = 0.04
"""s; joints that lag by more are fitted from that lag too, all of it by T and D."""
_IDENTIFIABLE = {"delay": 2e-3, "frequency": 0.1, "damping": 0.1}
"""Half widths of 95 % above which a number is not told: s, and parts of the value."""
_NEIGHBOURS = 25


@dataclass(frozen=True, slots=True, eq=False)
class SecondOrder:
    """What a log tells of one joint.

    Attributes:
        delay: s.
        frequency: 1/T, rad/s.
        damping: D.
        left: root mean square of what is left, rad.
    """

    delay: Estimate
    frequency: Estimate
    damping: Estimate
    left: float


def fit_second_order(
    name: str,
    t: np.ndarray,
    position: np.ndarray,
    command: Callable[[np.ndarray], np.ndarray],
    span: tuple[float, float],
    *,
    delay: float,
    lag: float,
) -> SecondOrder:
    """Fit delay, T and D.

    Args:
        name: of the joint.
        t: (m,) s, of the log.
        position: (m,) rad.
        command: times (m,) -> rad, at rest before and after its span.
        span: s.
        delay: of the fit of first order, s.
        lag: likewise.
    """
    grid = np.arange(span[0], span[1] + _AFTER, _STEP)
    asked = command(grid)
    first = float(asked[0])

    def residuals(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        late, fit = values[0], values[1:]
        here = _response(asked - first, fit)
        changed = [_response(asked - first, fit + _CHANGE * unit) for unit in np.eye(2)]
        columns = [
            -np.gradient(here, _STEP),
            *((after - here) / step for after, step in zip(changed, _CHANGE, strict=True)),
        ]
        done, *slopes = (np.interp(t - late, grid, column, left=0.0) for column in (here, *columns))
        return done + first - position, np.column_stack(slopes)

    starts = [*_STARTS, *((lag / (2.0 * ratio), ratio) for ratio in (0.8, 1.2) if lag > _SLOW)]
    best = min(
        (
            fitted(
                residuals,
                np.array([delay + lag - 2.0 * ratio * period, period, ratio]),
                np.array([1e-3, 1e-3, 0.1]),
                np.array([delay - 0.1, *_LOWER]),
                np.array([delay + lag + 0.1, *_UPPER]),
                neighbours=_NEIGHBOURS,
            )
            for period, ratio in starts
        ),
        key=lambda fit: fit.left,
    )
    late, period, ratio = (float(value) for value in best.values)
    deviation = np.sqrt(np.diag(best.covariance))
    frequency = 1.0 / period
    return SecondOrder(
        Estimate("delay", name, "s", late, float(deviation[0]), _IDENTIFIABLE["delay"]),
        Estimate(
            "frequency",
            name,
            "rad/s",
            frequency,
            float(deviation[1]) * frequency**2,
            _IDENTIFIABLE["frequency"] * frequency,
        ),
        Estimate("damping", name, "1", ratio, float(deviation[2]), _IDENTIFIABLE["damping"] * ratio),
        best.left,
    )


def _response(asked: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Positions on the grid, for T and D, from rest at zero."""
    from scipy.signal import cont2discrete, lfilter

    period, ratio = values
    found: Any = cont2discrete(([1.0], [period**2, 2.0 * ratio * period, 1.0]), _STEP, "foh")
    return np.asarray(lfilter(np.ravel(found[0]), found[1], asked))
