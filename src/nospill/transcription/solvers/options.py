"""Options of a solve: limits, tolerances, and how it goes on from a good start."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

IterationCallback = Callable[[int, float, float], None]
"""Called with iteration, duration in s and largest constraint violation (scaled)."""


@dataclass(frozen=True, slots=True)
class SolveOptions:
    """Limits and start of a solve.

    Attributes:
        max_iterations: after which the solver stops.
        max_time: after which it stops, s.
        kkt_error_globalization: steps of the free barrier strategy are accepted by the error of the optimality
            conditions, not by a filter of cost and violation.
        loose_tolerances: end where the conditions of an optimum are met to three digits instead of six, and solve
            linear systems as loosely. From a start near the optimum it saves every seventh step and costs the motion at
            most 3 parts in 10,000 of its duration.
        barrier_start: first barrier parameter, small where the start is nearly optimal; it then goes down step by step.
            None: adapted from iteration to iteration.
        bound_push: scaled distance that the start is moved off its bounds, small where the start is nearly optimal; a
            start that breaks some of them needs more, or each step ends at the next bound. None: left to the solver.
        progress: called at every iteration.
    """

    max_iterations: int
    max_time: float
    kkt_error_globalization: bool = False
    loose_tolerances: bool = False
    barrier_start: float | None = None
    bound_push: float | None = None
    progress: IterationCallback | None = None
