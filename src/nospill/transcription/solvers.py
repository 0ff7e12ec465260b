"""Problem -> Solution, through a visible table of solvers."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import Any

import casadi as ca
import numpy as np

from nospill.errors import ScenarioError
from nospill.laws.constraints.base import RowId
from nospill.transcription.problem import DERIVING_SOLVERS, Problem
from nospill.transcription.stages import Stages

Progress = Callable[[int, float, float], None]
"""Called with iteration, duration in s and largest constraint violation (scaled)."""


@dataclass(frozen=True, slots=True)
class SolveOptions:
    """Limits and start mode.

    Attributes:
        max_iterations, max_time: of the solver; time in s.
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
    progress: Progress | None = None


@dataclass(frozen=True, slots=True)
class Solution:
    """What a solver returned; `converged` is its own word and decides nothing by itself.

    Attributes:
        stages: the candidate motion.
        variables: scaled. multipliers: of the constraints. bound_multipliers: of the variables' bounds.
        objective: t_e + sum k mean(u^2). violation: largest scaled constraint violation.
        slack: per (constraint, subject), least distance of its rows from their bounds, relative to the budget.
        status: a sentence. iterations, solve_time_s: effort.
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


def _ipopt_options(options: SolveOptions) -> dict[str, Any]:
    settings: dict[str, Any] = {
        "ipopt.print_level": 0,
        "ipopt.sb": "yes",
        "ipopt.max_iter": options.max_iterations,
        "ipopt.max_wall_time": options.max_time,
        "ipopt.tol": 1e-6,
        "ipopt.constr_viol_tol": 1e-7,
        "ipopt.acceptable_tol": 1e-4,
        "ipopt.acceptable_iter": 8,
        "ipopt.acceptable_constr_viol_tol": 1e-6,
        # The free barrier strategy needs a third of the iterations of the monotone one on these problems.
        "ipopt.mu_strategy": "adaptive",
        "ipopt.adaptive_mu_globalization": "kkt-error" if options.kkt_error_globalization else "obj-constr-filter",
        # Quasi-dense minimum degree: of the orderings in MUMPS the quickest on these chains, most so with many cups.
        "ipopt.mumps_pivot_order": 6,
        # The problem is scaled; doing it again takes a tenth of each factorisation and changes no iteration.
        "ipopt.mumps_permuting_scaling": 0,
        "ipopt.mumps_scaling": 0,
    }
    if options.loose_tolerances:
        # the bound on complementarity keeps the barrier as low as otherwise
        settings |= {"ipopt.tol": 1e-3, "ipopt.constr_viol_tol": 1e-6, "ipopt.compl_inf_tol": 2e-6}
        settings |= {"ipopt.min_refinement_steps": 0, "ipopt.residual_ratio_max": 1e-6}
    if options.barrier_start is not None:
        settings |= {"ipopt.mu_strategy": "monotone", "ipopt.mu_init": options.barrier_start}
    if options.bound_push is not None:
        settings["ipopt.warm_start_init_point"] = "yes"
        settings |= {
            f"ipopt.warm_start_{what}_push": options.bound_push for what in ("bound", "slack_bound", "mult_bound")
        }
        # between two bounds, as part of their distance; IPOPT's own is a thousandth
        settings |= {
            f"ipopt.warm_start_{what}_frac": max(options.bound_push, 1e-3) for what in ("bound", "slack_bound")
        }
    return settings


def _fatrop_options(options: SolveOptions) -> dict[str, Any]:
    return {
        "fatrop.print_level": 0,
        "fatrop.max_iter": options.max_iterations,
        "fatrop.tol": 1e-6,
        "structure_detection": "manual",
    }


SOLVERS: dict[str, Callable[[SolveOptions], dict[str, Any]]] = {
    "ipopt": _ipopt_options,
    "fatrop": _fatrop_options,
}
"""Name -> options. A further NLP solver of casadi is one line here."""

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
        options: limits.
        warm: an earlier answer of a problem of the same shape, whose multipliers are used.

    Raises:
        ScenarioError: unknown solver. KeyboardInterrupt: stopped by the user.
    """
    if solver not in SOLVERS:
        raise ScenarioError(f'planning.solver "{solver}" is not known; allowed: {", ".join(SOLVERS)}')
    transcription = problem.transcription
    settings = SOLVERS[solver](options) | {"print_time": False, "error_on_fail": False, "calc_lam_p": False}
    if solver in DERIVING_SOLVERS:
        settings |= _fatrop_structure(problem)
    else:
        settings |= {
            "jac_g": transcription.jac_g,
            "grad_f": transcription.grad_f,
            "hess_lag": transcription.hess_lag,
            "no_nlp_grad": True,
        }
    watcher = None
    if options.progress is not None and solver == "ipopt":
        watcher = _Watcher(problem, options.progress)
        settings["iteration_callback"] = watcher
    began = time.perf_counter()
    nlpsol = ca.nlpsol("plan", solver, transcription.nlp, settings)
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
    with _interruptible():
        result = nlpsol(**arguments)
    if watcher is not None and watcher.raised is not None:
        raise watcher.raised
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
        slack=_slack(problem, values),
        converged=bool(stats["success"]),
        status=_sentence(solver, stats, options),
        iterations=int(stats["iter_count"]),
        solve_time_s=elapsed,
    )


FEASIBLE = 1e-5
"""Largest scaled violation of a motion that is worth going on with."""


def usable(solution: Solution) -> bool:
    """Whether an answer keeps its constraints well enough to go on with."""
    return solution.violation <= FEASIBLE


@contextmanager
def _interruptible() -> Iterator[None]:
    """Raise KeyboardInterrupt after a call into CasADi during which one came: CasADi would swallow it and go on.

    Outside the main thread, where no signal arrives, this does nothing.
    """
    came = False

    def note(number: int, frame: FrameType | None) -> None:
        nonlocal came
        came = True
        raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, note)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if came:
        raise KeyboardInterrupt


def violation(problem: Problem, values: np.ndarray) -> float:
    """Largest violation of the constraint bounds, scaled units; infinite where a value is not a number."""
    short = np.maximum(problem.transcription.lower - values, values - problem.transcription.upper)
    return float("inf") if not np.all(np.isfinite(values)) else float(max(np.max(short), 0.0))


def row_slack(problem: Problem, stages: Stages) -> dict[RowId, float]:
    """`Solution.slack` of any motion on the problem's grid, solved or not."""
    values = problem.transcription.constraint_function(problem.encode(stages), problem.parameters)
    return _slack(problem, np.asarray(values).ravel())


def _slack(problem: Problem, values: np.ndarray) -> dict[RowId, float]:
    transcription = problem.transcription
    distance = np.minimum(values - transcription.lower, transcription.upper - values)
    stages, end = np.split(distance, [transcription.intervals * transcription.height])
    least = np.min(stages.reshape(-1, transcription.height), axis=0)
    slack: dict[RowId, float] = {}
    for blocks, distances in ((transcription.blocks, least), (transcription.end_blocks, end)):
        for block in blocks:
            own = float(np.min(distances[block.first : block.first + block.count]))
            slack[block.row_id] = min(own, slack.get(block.row_id, np.inf))
    return slack


def _sentence(solver: str, stats: dict[str, Any], options: SolveOptions) -> str:
    status = str(stats["return_status"])
    if not stats["success"] and status.isdigit() and int(stats["iter_count"]) >= options.max_iterations:
        status = "Maximum_Iterations_Exceeded"  # FATROP tells a number only
    default = "converged to an optimum" if stats["success"] else f"ended with {status.replace('_', ' ').lower()}"
    return f"{solver} {_SENTENCES.get(status, default)}"


def _fatrop_structure(problem: Problem) -> dict[str, Any]:
    transcription = problem.transcription
    layout, count = transcription.layout, transcription.intervals
    rows = transcription.height - layout.states
    end_rows = len(transcription.lower) - count * transcription.height
    equality = (transcription.lower == transcription.upper).tolist()
    return {
        "N": count,
        "nx": [layout.states] * (count + 1),
        "nu": [layout.size - layout.states] * count + [0],
        "ng": [rows] * count + [end_rows],
        "equality": equality,
    }


class _Watcher(ca.Callback):
    """Turns the solver's iterations into progress calls."""

    def __init__(self, problem: Problem, progress: Progress) -> None:
        ca.Callback.__init__(self)
        self._problem, self._progress, self._iteration = problem, progress, 0
        self.raised: BaseException | None = None
        transcription = problem.transcription
        self._sizes = {
            "x": transcription.variables,
            "f": 1,
            "g": len(transcription.lower),
            "lam_x": transcription.variables,
            "lam_g": len(transcription.lower),
            "lam_p": len(problem.parameters),
        }
        self.construct("watcher", {})

    def get_n_in(self) -> int:
        return ca.nlpsol_n_out()

    def get_n_out(self) -> int:
        return 1

    def get_name_in(self, i: int) -> str:
        return ca.nlpsol_out(i)

    def get_name_out(self, i: int) -> str:
        return "ret"

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        return ca.Sparsity.dense(self._sizes[ca.nlpsol_out(i)], 1)

    def has_eval_buffer(self) -> bool:
        return True

    def eval_buffer(self, arg: Sequence[memoryview], res: Sequence[memoryview]) -> int:
        # The numbers as they lie in memory: CasADi's matrices would copy all of them first, at every iteration.
        try:
            x, _, g = (np.frombuffer(part, dtype=float) for part in arg[:3])
            self._progress(self._iteration, self._problem.duration(x), violation(self._problem, g))
            self._iteration += 1
        except BaseException as error:
            # CasADi would print all its numbers; asked to stop, it returns, and `solve` raises the error again.
            self.raised = error
        np.frombuffer(res[0], dtype=float)[:] = self.raised is not None
        return 0
