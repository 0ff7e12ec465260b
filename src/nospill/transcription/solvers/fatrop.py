"""FATROP: an interior point method that eliminates stage by stage.

CasADi's interface to it accepts no derivatives: it derives the problem's functions itself.
"""

from __future__ import annotations

from typing import Any

from nospill.transcription.problem import Problem
from nospill.transcription.solvers.options import SolveOptions


def fatrop_settings(problem: Problem, options: SolveOptions) -> dict[str, Any]:
    """Settings of `casadi.nlpsol`, with the sizes of the stages.

    Of the options only `max_iterations` has an effect: FATROP has no limit of time (`planning.max_solve_time` does not
    hold), starts cold and reports nothing on the way.
    """
    transcription = problem.transcription
    layout, count = transcription.layout, transcription.intervals
    rows = transcription.rows_per_stage - layout.states
    end_rows = len(transcription.lower) - count * transcription.rows_per_stage
    return {
        "fatrop.print_level": 0,
        "fatrop.max_iter": options.max_iterations,
        "fatrop.tol": 1e-6,
        "structure_detection": "manual",
        "N": count,
        "nx": [layout.states] * (count + 1),
        "nu": [layout.size - layout.states] * count + [0],
        "ng": [rows] * count + [end_rows],
        "equality": (transcription.lower == transcription.upper).tolist(),
    }
