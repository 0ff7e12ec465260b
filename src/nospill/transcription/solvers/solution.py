"""The answer of a solver, and how far a motion is from the bounds of a problem's rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.clearance import Clearance
from nospill.transcription.problem import Problem
from nospill.transcription.solvers.pivot_orders import PivotOrder
from nospill.transcription.stages import Stages

FEASIBLE = 5e-5
"""Largest scaled violation of a motion that is worth going on with; more than any solve leaves that converges."""


@dataclass(frozen=True, slots=True)
class Solution:
    """What a solver returned; `converged` is its own word and decides nothing by itself.

    Attributes:
        stages: the candidate motion.
        variables: (n,) scaled.
        multipliers: (m,) of the constraints.
        bound_multipliers: (n,) of the variables' bounds.
        objective: t_e + sum k mean(u^2), s.
        violation: largest scaled constraint violation.
        slack: per active (constraint, subject), least distance of its rows from their bounds, as part of the budget; of
            clearance none.
        converged: whether the solver met its tolerances.
        status: a sentence.
        iterations: of the solver.
        solve_time_s: wall clock, s.
        linear_solver: its name; of several, the last and those that failed before it.
        pivot_order: for a solve of the same shape; None where the linear solver has none.
        plane_variables, plane_rows: how many of the variables and multipliers, the last ones, are of planes between
            bodies.
    """

    stages: Stages
    variables: np.ndarray
    multipliers: np.ndarray
    bound_multipliers: np.ndarray
    objective: float
    violation: float
    slack: dict[RowId, float]
    converged: bool
    status: str
    iterations: int
    solve_time_s: float
    linear_solver: str
    pivot_order: PivotOrder | None = None
    plane_variables: int = 0
    plane_rows: int = 0

    def multipliers_for(self, problem: Problem) -> tuple[np.ndarray, np.ndarray] | None:
        """The multipliers as a start for another problem: of its constraints (m,) and of its bounds (n,).

        Planes that stand between other bodies, or in other intervals, start with zero. None where the motion's own
        rows or variables are not the same in number.
        """
        rows, variables = len(problem.transcription.lower), len(problem.lower)
        of_planes = problem.transcription.clearance_rows, problem.transcription.plane_variables
        if (rows, variables) == (len(self.multipliers), len(self.bound_multipliers)):
            return self.multipliers, self.bound_multipliers
        own = len(self.multipliers) - self.plane_rows, len(self.bound_multipliers) - self.plane_variables
        if own != (rows - of_planes[0], variables - of_planes[1]):
            return None
        kept = self.multipliers[: own[0]], self.bound_multipliers[: own[1]]
        return np.append(kept[0], np.zeros(of_planes[0])), np.append(kept[1], np.zeros(of_planes[1]))


def usable(solution: Solution) -> bool:
    """Whether an answer keeps its constraints well enough to go on with."""
    return solution.violation <= FEASIBLE


def violation(problem: Problem, values: np.ndarray) -> float:
    """Largest violation of the constraint bounds, scaled units; infinite where a value is not a number."""
    short = np.maximum(problem.row_lower - values, values - problem.row_upper)
    return float("inf") if not np.all(np.isfinite(values)) else float(max(np.max(short), 0.0))


def row_slack(problem: Problem, stages: Stages) -> dict[RowId, float]:
    """`Solution.slack` of any motion on the problem's grid, solved or not."""
    return least_slack(problem, problem.transcription.constraints(problem.encode(stages), problem.parameters))


def least_slack(problem: Problem, values: np.ndarray) -> dict[RowId, float]:
    """`Solution.slack` from the values (m,) of the constraints."""
    distance = np.minimum(values - problem.row_lower, problem.row_upper - values)
    # of clearance none: its planes stand anywhere between the bodies
    rows = [(row, places) for row, places, _ in problem.places if row.constraint != Clearance.name]
    if not rows:
        return {}
    starts = np.cumsum([0, *(len(places) for _, places in rows[:-1])])
    least = np.minimum.reduceat(distance[np.concatenate([places for _, places in rows])], starts).tolist()
    slack: dict[RowId, float] = {}
    for (row, _), value in zip(rows, least, strict=True):
        slack[row] = min(value, slack.get(row, np.inf))
    return slack
