"""Problem -> Solution by IPOPT."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial
from typing import Any

import casadi as ca
import numpy as np

from nospill.transcription.problem import Problem
from nospill.transcription.solvers.callbacks import interruptible, watched
from nospill.transcription.solvers.ipopt import ipopt_settings
from nospill.transcription.solvers.linear_solvers import UNSOLVED, Settings, candidates
from nospill.transcription.solvers.options import SolveOptions
from nospill.transcription.solvers.pivot_orders import PivotOrder, with_order
from nospill.transcription.solvers.solution import Solution, least_slack, violation
from nospill.transcription.stages import Stages

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
_RESULTS = ("x", "f", "g", "lam_x", "lam_g")
"""Names of what is read of a solver's answer."""


def solve(problem: Problem, start: Stages, *, options: SolveOptions, warm: Solution | None = None) -> Solution:
    """Solve from a starting motion.

    Args:
        problem: what to solve; its scenario names the linear solver.
        start: on the problem's grid.
        options: limits, tolerances and start.
        warm: an earlier answer, whose multipliers and order of pivots are used where its problem was of the same shape.

    Raises:
        ScenarioError: the linear solver is not known or not available.
        KeyboardInterrupt: stopped by the user.
    """
    transcription = problem.transcription
    settings = ipopt_settings(problem, options)
    settings |= {"print_time": False, "error_on_fail": False, "calc_lam_p": False}
    began = time.perf_counter()
    arguments = {
        "x0": problem.encode(start),
        "p": problem.parameters,
        "lbx": problem.lower,
        "ubx": problem.upper,
        "lbg": problem.row_lower,
        "ubg": problem.row_upper,
    }
    order = None
    multipliers = None if warm is None else warm.multipliers_for(problem)
    if warm is not None and multipliers is not None:
        arguments |= {"lam_g0": multipliers[0], "lam_x0": multipliers[1]}
        order = warm.pivot_order if multipliers[0] is warm.multipliers else None
    (linear_solver, options_of_it), *others = candidates(problem.scene.planning.linear_solver)
    result, stats, order = _attempt(problem, settings | options_of_it, arguments, options, order)
    for other, options_of_it in others:
        if stats["return_status"] not in UNSOLVED:
            break
        result, stats, order = _attempt(
            problem, settings | options_of_it, arguments, options, None
        )  # one that failed is dropped
        linear_solver = f"{other} after {linear_solver}"
    variables, values = result["x"], result["g"]
    return Solution(
        stages=problem.decode(variables),
        variables=variables,
        multipliers=result["lam_g"],
        bound_multipliers=result["lam_x"],
        objective=float(result["f"][0]),
        violation=violation(problem, values),
        slack=least_slack(problem, values),
        converged=bool(stats["success"]),
        status=_sentence(stats),
        iterations=int(stats["iter_count"]),
        solve_time_s=time.perf_counter() - began,
        linear_solver=linear_solver,
        pivot_order=order,
        plane_variables=transcription.plane_variables,
        plane_rows=transcription.clearance_rows,
    )


def _attempt(
    problem: Problem,
    settings: Settings,
    arguments: Mapping[str, np.ndarray],
    options: SolveOptions,
    order: PivotOrder | None,
) -> tuple[dict[str, np.ndarray], dict[str, Any], PivotOrder | None]:
    """Answer, statistics and order of pivots of one run of IPOPT; None where the linear solver keeps none."""
    with watched(problem, options.progress) as watching:
        nlpsol = ca.nlpsol("plan", "ipopt", problem.transcription.nlp, settings | watching)
        run = partial(_call, nlpsol, arguments)
        with interruptible():
            library = settings.get("ipopt.hsllib")
            (results, stats), kept = (run(), None) if library is None else with_order(library, order, run)
            return results, stats, kept


def _call(nlpsol: Any, arguments: Mapping[str, np.ndarray]) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """The outputs by name, and the statistics; what there is no argument for is zero.

    The solver reads and writes the arrays themselves: CasADi's matrices, through which a plain call goes, take as long
    as an iteration.
    """
    buffer, evaluate_now = nlpsol.buffer()
    given = {name: np.ascontiguousarray(value, dtype=float) for name, value in arguments.items()}
    results = {name: np.empty(nlpsol.nnz_out(name)) for name in _RESULTS}
    for name, value in given.items():
        assert value.shape == (nlpsol.nnz_in(name),)
        buffer.set_arg(nlpsol.index_in(name), value.data)
    for name, value in results.items():
        buffer.set_res(nlpsol.index_out(name), value.data)
    evaluate_now()
    if buffer.ret():
        raise RuntimeError(f"ipopt gave no answer (code {buffer.ret()})")
    return results, buffer.stats()


def _sentence(stats: dict[str, Any]) -> str:
    status = str(stats["return_status"])
    default = "converged to an optimum" if stats["success"] else f"ended with {status.replace('_', ' ').lower()}"
    return f"ipopt {_SENTENCES.get(status, default)}"
