"""IPOPT: an interior point method for problems of any structure; its linear solvers are in `linear_solvers`."""

from __future__ import annotations

from typing import Any

from nospill.transcription.problem import Problem
from nospill.transcription.solvers.options import SolveOptions


def ipopt_settings(problem: Problem, options: SolveOptions) -> dict[str, Any]:
    """Settings of `casadi.nlpsol`: every option holds, derivatives are those of the transcription."""
    derivatives = problem.transcription.derivatives
    settings: dict[str, Any] = {
        "jac_g": derivatives.jac_g,
        "grad_f": derivatives.grad_f,
        "hess_lag": derivatives.hess_lag,
        "no_nlp_grad": True,
        "ipopt.print_level": 0,
        "ipopt.sb": "yes",
        "ipopt.max_iter": options.max_iterations,
        "ipopt.max_wall_time": options.max_time,
        "ipopt.tol": options.tolerances.stationarity,
        "ipopt.constr_viol_tol": options.tolerances.violation,
        "ipopt.compl_inf_tol": options.complementarity or options.tolerances.complementarity,
        "ipopt.residual_ratio_max": options.tolerances.linear_system,
        "ipopt.min_refinement_steps": options.tolerances.refinements,
        "ipopt.acceptable_tol": 1e-4,
        "ipopt.acceptable_iter": 8,
        "ipopt.acceptable_constr_viol_tol": 1e-6,
        "ipopt.mu_strategy": "adaptive",
        "ipopt.adaptive_mu_globalization": "kkt-error" if options.kkt_error_globalization else "obj-constr-filter",
    }
    if options.barrier_start is not None:
        settings |= {"ipopt.mu_strategy": "monotone", "ipopt.mu_init": options.barrier_start}
        settings["ipopt.barrier_tol_factor"] = options.barrier_error
    if options.least_barrier is not None:
        settings["ipopt.mu_min"] = options.least_barrier
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
