"""Options of a solve: limits, tolerances, and how it goes on from a good start."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

IterationCallback = Callable[[int, float, float], None]
"""Called with iteration, duration in s and largest constraint violation (scaled)."""

Options = Mapping[str, Any]
"""Fields of `SolveOptions` that differ from those of the scene."""

BARRIERS = (1e-5, 1e-4, 0.1)
"""First barrier parameters from a start that is nearly optimal, in the order in which they are tried."""

LAST_BARRIER = 1e-6
"""Barrier parameter of a problem that is solved warm, with other back-off."""

_BARRIER_ERROR = 10.0
_NO_PUSH, _LITTLE_PUSH = 1e-6, 1e-5

FROM_AFAR: Options = MappingProxyType({"barrier_start": 1e-3, "barrier_error": 100.0})
"""From a start that is far from the optimum: barrier problems are left as soon as they are met roughly."""


@dataclass(frozen=True, slots=True)
class Tolerances:
    """When a solve ends: what may be left of the conditions of an optimum, all of them scaled.

    Attributes:
        stationarity: of the gradient of the Lagrangian.
        violation: of a constraint.
        complementarity: of bound and multiplier; with loose ones it keeps the barrier nearly as low as otherwise.
        linear_system: residual of the linear system of a step, above which its solution is refined again.
        refinements: how often it is refined at least.
    """

    stationarity: float
    violation: float
    complementarity: float
    linear_system: float
    refinements: int


TIGHT = Tolerances(stationarity=1e-6, violation=1e-7, complementarity=1e-4, linear_system=1e-10, refinements=1)
LOOSE = Tolerances(stationarity=1e-3, violation=1e-6, complementarity=2e-6, linear_system=1e-6, refinements=0)
"""From a start near the optimum they save every seventh step and cost at most 3 parts in 10,000 of the duration."""
LOOSEST = Tolerances(stationarity=2e-3, violation=4e-5, complementarity=4e-6, linear_system=1e-6, refinements=0)
"""Of warm starts: one step in twelve more saved, for at most two more parts in 10,000.

The exported motion is certified, and the first back-off of a row is at least 25 times the violation.
"""


@dataclass(frozen=True, slots=True)
class SolveOptions:
    """Limits and start of a solve.

    Attributes:
        max_iterations: after which the solver stops.
        max_time: after which it stops, s.
        kkt_error_globalization: steps of the free barrier strategy are accepted by the error of the optimality
            conditions, not by a filter of cost and violation.
        tolerances: at which the solve ends.
        barrier_start: first barrier parameter, small where the start is nearly optimal; it then goes down step by step.
            None: adapted from iteration to iteration.
        barrier_error: error of a barrier problem, over its parameter, at which the parameter goes down.
        least_barrier: the barrier parameter is not adapted to less; None: left to the solver.
        complementarity: in the place of that of the tolerances, where it is given.
        bound_push: scaled distance that the start is moved off its bounds, small where the start is nearly optimal; a
            start that breaks some of them needs more, or each step ends at the next bound. None: left to the solver.
        progress: called at every iteration.
    """

    max_iterations: int
    max_time: float
    kkt_error_globalization: bool = False
    tolerances: Tolerances = TIGHT
    barrier_start: float | None = None
    barrier_error: float = _BARRIER_ERROR
    least_barrier: float | None = None
    complementarity: float | None = None
    bound_push: float | None = None
    progress: IterationCallback | None = None


def near_optimum(barrier: float, iterations: int | None = None, push: float = _NO_PUSH) -> Options:
    """Options of a solve whose start is nearly optimal: a small first barrier, and no push off the bounds.

    Args:
        barrier: first barrier parameter.
        iterations: most of them; left as they are when left out.
        push: off the bounds, scaled.
    """
    most = {} if iterations is None else {"max_iterations": iterations}
    return {"barrier_start": barrier, "barrier_error": _BARRIER_ERROR, "bound_push": push, **most}


NEAR_OPTIMUM = tuple(near_optimum(barrier) for barrier in BARRIERS)
"""What is tried, one after the other, from a start that is nearly optimal."""
_OTHER_ROWS: Options = {**near_optimum(BARRIERS[1], push=_LITTLE_PUSH), "complementarity": 5e-7}
OF_OTHER_ROWS = (MappingProxyType(_OTHER_ROWS), NEAR_OPTIMUM[0], NEAR_OPTIMUM[2])
"""The same from the optimum of a problem that had other rows: it breaks some, and with the least barrier each step ends
at the next bound. The barrier falls as low as from there."""


def near_adapted(iterations: int) -> Options:
    """Options of a solve whose start is near the optimum, with a barrier that is adapted and no push off the bounds.

    It ends with the barrier that others begin with, so that its multipliers suit them. From some starts it leads
    nowhere: those are left after the most iterations.
    """
    return {
        "kkt_error_globalization": True,
        "least_barrier": LAST_BARRIER,
        "bound_push": _NO_PUSH,
        "max_iterations": iterations,
    }
