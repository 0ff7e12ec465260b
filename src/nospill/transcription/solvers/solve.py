"""Problem -> Solution by one of a table of solvers."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from nospill.errors import ScenarioError
from nospill.transcription.problem import Problem
from nospill.transcription.solvers.callbacks import interruptible, watched
from nospill.transcription.solvers.fatrop import fatrop_settings
from nospill.transcription.solvers.ipopt import ipopt_settings
from nospill.transcription.solvers.options import SolveOptions
from nospill.transcription.solvers.solution import Solution, least_slack, violation
from nospill.transcription.stages import Stages


@dataclass(frozen=True, slots=True)
class Interface:
    """A solver as `casadi.nlpsol` has it.

    Attributes:
        settings: its settings for a problem and options.
        reports_iterations: whether it calls back at every iteration.
    """

    settings: Callable[[Problem, SolveOptions], dict[str, Any]]
    reports_iterations: bool


SOLVERS: dict[str, Interface] = {
    "ipopt": Interface(ipopt_settings, reports_iterations=True),
    "fatrop": Interface(fatrop_settings, reports_iterations=False),
}
"""Solvers by name. A further one of CasADi is a function of its settings and one line here."""

_SENTENCES = {
    "Solved_To_Acceptable_Level": "converged to a slightly relaxed tolerance",
    "Infeasible_Problem_Detected": "ended at a point that cannot be made feasible locally",
    "Maximum_Iterations_Exceeded": "stopped at the limit of iterations",
    "Maximum_WallTime_Exceeded": "stopped at the time limit planning.max_solve_time",
    "Restoration_Failed": "could not restore feasibility",
    "Search_Direction_Becomes_Too_Small": "made no further progress",
    "Diverging_Iterates": "diverged",
    "Invalid_Number_Detected": "met a number that is not finite",
    "User_Requested_Stop": "was stopped by the user",
}


def solve(
    problem: Problem, start: Stages, *, solver: str, options: SolveOptions, warm: Solution | None = None
) -> Solution:
    """Solve from a starting motion.

    Args:
        problem: what to solve.
        start: on the problem's grid.
        solver: key of `SOLVERS`.
        options: limits, tolerances and start.
        warm: an earlier answer of a problem of the same shape, whose multipliers are used.

    Raises:
        ScenarioError: unknown solver. KeyboardInterrupt: stopped by the user.
    """
    if solver not in SOLVERS:
        raise ScenarioError(f'planning.solver "{solver}" is not known; allowed: {", ".join(SOLVERS)}')
    transcription = problem.transcription
    interface = SOLVERS[solver]
    settings = interface.settings(problem, options)
    settings |= {"print_time": False, "error_on_fail": False, "calc_lam_p": False}
    began = time.perf_counter()
    arguments: dict[str, Any] = {
        "x0": problem.encode(start),
        "p": problem.parameters,
        "lbx": problem.lower,
        "ubx": problem.upper,
        "lbg": transcription.lower,
        "ubg": transcription.upper,
    }
    if warm is not None:
        arguments |= {"lam_g0": warm.multipliers, "lam_x0": warm.bound_multipliers}
    with watched(problem, options.progress if interface.reports_iterations else None) as watching:
        nlpsol = ca.nlpsol("plan", solver, transcription.nlp, settings | watching)
        with interruptible():
            result = nlpsol(**arguments)
    elapsed = time.perf_counter() - began
    stats = nlpsol.stats()
    variables = np.asarray(result["x"]).ravel()
    values = np.asarray(result["g"]).ravel()
    return Solution(
        stages=problem.decode(variables),
        variables=variables,
        multipliers=np.asarray(result["lam_g"]).ravel(),
        bound_multipliers=np.asarray(result["lam_x"]).ravel(),
        objective=float(result["f"]),
        violation=violation(problem, values),
        slack=least_slack(problem, values),
        converged=bool(stats["success"]),
        status=_sentence(solver, stats, options),
        iterations=int(stats["iter_count"]),
        solve_time_s=elapsed,
    )


def _sentence(solver: str, stats: dict[str, Any], options: SolveOptions) -> str:
    status = str(stats["return_status"])
    if not stats["success"] and status.isdigit() and int(stats["iter_count"]) >= options.max_iterations:
        status = "Maximum_Iterations_Exceeded"  # FATROP returns a number only
    default = "converged to an optimum" if stats["success"] else f"ended with {status.replace('_', ' ').lower()}"
    return f"{solver} {_SENTENCES.get(status, default)}"
