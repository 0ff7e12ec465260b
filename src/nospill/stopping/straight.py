"""How soon one cup of liquid can stop on a straight way of its own: linear programs over a grid of time.

The cup moves along one line, on a level tray, and nothing holds it but friction; whatever the arm does, the shadow of
its motion on that line does the same. With u the contact force over the whole mass M, bounded by mu g, and small
swings, each mode is q'' + 2 zeta omega q' + omega^2 q = -v', and M v' + sum m (q'' ) = M u: a linear system with one
bounded input. For a time T it is asked how slow the cup can be at T with its surface below the limit at every instant
of the grid until then, and after it, at rest, below what may be left. Where that is not at rest, no stop takes T.

The equations are those of small swings: the paraboloid of the first mode, whose spring gets softer, is left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm
from scipy.optimize import linprog

_STEP = 0.01
"""s, of the grid; the input is constant within."""
_AFTER = 0.5
"""s, for which the surface is looked at after the end."""
_UNBOUNDED = 1e3
"""m/s^2 in the place of an infinite input."""


@dataclass(frozen=True, slots=True)
class Straight:
    """A cup on a line.

    Attributes:
        speed: m/s, along it.
        most: m/s^2, contact force over mass.
        frequency, damping, gain: (k,) of its modes, rad/s, 1, 1.
        part: (k,) mass of each mode over the whole; zero where liquids are not felt.
        displacement, rate: (k,) of its modes along the line, m, m/s.
        highest: m, of its surface.
        residual: m, the same after the end.
    """

    speed: float
    most: float
    frequency: np.ndarray
    damping: np.ndarray
    gain: np.ndarray
    part: np.ndarray
    displacement: np.ndarray
    rate: np.ndarray
    highest: float
    residual: float


def soonest(case: Straight, longest: float, *, above: float = 0.0) -> float:
    """The longest time of the grid, s, in which no stop is possible; 0 where none is within `longest` either.

    Where the surface cannot be kept below its limit within `longest`, the equations of small swings are too strict a
    picture of a motion that is known to be certified, and say nothing. A time shorter than `above`, s, is of no
    interest, and 0 is the answer likewise.
    """
    system = _Discrete.of(case)
    low, high = int(above / _STEP), int(np.ceil(longest / _STEP)) + 1
    if system.stops_in(low) or not system.stops_in(high):
        return 0.0
    while high - low > 1:
        middle = (low + high) // 2
        if system.stops_in(middle):
            high = middle
        else:
            low = middle
    return low * _STEP


@dataclass(frozen=True, slots=True)
class _Discrete:
    """The system from step to step: states are displacements, their rates and the cup's speed."""

    case: Straight
    step: np.ndarray
    push: np.ndarray
    free: np.ndarray
    height: np.ndarray

    @classmethod
    def of(cls, case: Straight) -> _Discrete:
        """Both systems, moving and at rest, over one step."""
        count = len(case.frequency)
        back = np.hstack([-np.diag(case.frequency**2), -np.diag(2.0 * case.damping * case.frequency)])
        rest = 1.0 - case.part.sum()
        # (1 - sum p) v' = u + sum p (2 zeta omega q' + omega^2 q)
        pulled = np.append(-case.part @ back, 0.0) / rest
        moving = np.zeros((2 * count + 2, 2 * count + 2))
        moving[:count, count : 2 * count] = np.eye(count)
        moving[count : 2 * count, : 2 * count] = back
        standing = moving[:-1, :-1].copy()
        moving[count : 2 * count, :-1] -= pulled
        moving[2 * count, :-1] = pulled
        moving[count : 2 * count, -1], moving[2 * count, -1] = -1.0 / rest, 1.0 / rest
        over = expm(_STEP * moving)
        height = np.concatenate([case.gain, np.zeros(count + 1)])
        return cls(case, over[:-1, :-1], over[:-1, -1], expm(_STEP * standing), height)

    def stops_in(self, steps: int) -> bool:
        """Whether the cup can stand after so many steps."""
        if steps == 0:
            return False
        case, most = self.case, min(self.case.most, _UNBOUNDED)
        state = np.concatenate([case.displacement, case.rate, [case.speed]])
        drift, reach = state, np.zeros((len(state), steps))
        rows, known = [], []
        for number in range(steps):
            drift, reach = self.step @ drift, self.step @ reach
            reach[:, number] = self.push
            rows.append(self.height @ reach)
            known.append(self.height @ drift)
        limits = [case.highest] * (steps - 1) + [case.residual]
        look = self.height
        for _ in range(round(_AFTER / _STEP)):
            look = look @ self.free
            rows.append(look @ reach)
            known.append(look @ drift)
            limits.append(case.residual)
        table, offset, limit = np.array(rows), np.array(known), np.array(limits)
        found = linprog(
            reach[-1],
            A_ub=np.vstack([table, -table]),
            b_ub=np.concatenate([limit - offset, limit + offset]),
            bounds=(-most, most),
            method="highs",
        )
        return found.status == 0 and found.fun + drift[-1] <= 0.0
