"""What a call of the planner tells while it runs, and what it leaves for the next one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from nospill.laws.parameters import Structure
from nospill.transcription.nlp import Backoff
from nospill.transcription.solvers import Solution


@dataclass(frozen=True, slots=True)
class PlanningProgress:
    """Where planning stands.

    The phase and, while solving, iteration, current end time (s) and largest scaled violation.
    """

    phase: str
    iteration: int | None = None
    duration_s: float | None = None
    violation: float | None = None


Progress = Callable[[PlanningProgress], None]


@dataclass(frozen=True, slots=True)
class Memory:
    """What one planning leaves for the next one of the same structure: answer with multipliers, rows, reserves."""

    structure: Structure
    solution: Solution
    kept: frozenset[tuple[str, int]]
    reserves: Backoff


@dataclass(frozen=True, slots=True)
class Second:
    """The search from the second start, made beside the first.

    Attributes:
        solution: the answer.
        joined: rows it began with. kept: rows at its end.
        iterations, solve_time: effort; the time in s.
    """

    solution: Solution
    joined: set[tuple[str, int]]
    kept: set[tuple[str, int]]
    iterations: int
    solve_time: float
