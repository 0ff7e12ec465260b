"""Solution of a problem by IPOPT: `solve`, its options and its answer."""

from nospill.transcription.solvers.carried_over import carried_over as carried_over
from nospill.transcription.solvers.options import SolveOptions as SolveOptions
from nospill.transcription.solvers.solution import FEASIBLE as FEASIBLE
from nospill.transcription.solvers.solution import Solution as Solution
from nospill.transcription.solvers.solution import row_slack as row_slack
from nospill.transcription.solvers.solution import usable as usable
from nospill.transcription.solvers.solve import solve as solve

__all__ = ["FEASIBLE", "Solution", "SolveOptions", "carried_over", "row_slack", "solve", "usable"]
