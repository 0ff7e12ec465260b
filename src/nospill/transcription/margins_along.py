"""Margins that rows keep beside their back-off, each its own along the motion: as bounds of the rows.

A back-off is one number for a row at all nodes, and a parameter of the compiled functions. A margin differs from node
to node, and is put on the bounds instead: a row g(reserve) >= 0 that is to keep a reserve more by m has to be at least
g(reserve) - g(reserve + m) at the motion at hand, which for a limit that is constant is the same, and for one that
depends on the motion, as friction on the pressing force, is it to the first order in how much the motion changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from nospill.laws.constraints.base import RowId
from nospill.transcription.problem import Problem
from nospill.transcription.stages import Stages

_PROBE = 0.2
"""Reserve with which the rows are looked at; they are at most quadratic in it."""
_MOST = 0.98
"""Part of what the back-off leaves that a margin takes at most."""


@dataclass(frozen=True, slots=True)
class Margin:
    """What a row keeps along the motion.

    Attributes:
        share: (m,) increasing parts of the duration.
        kept: (m,) part of the budget there; of a row on the final state (1,), the share is not read.
    """

    share: np.ndarray
    kept: np.ndarray

    def around(self, node: float, intervals: int) -> float:
        """The most that is kept from half an interval before a node to the next one."""
        if len(self.kept) == 1:
            return float(self.kept[0])
        ends = np.array([node - 0.5, node + 1.0]) / intervals
        first, last = np.searchsorted(self.share, ends)
        inside = self.kept[first:last]
        return float(max(np.max(inside, initial=0.0), *np.interp(ends, self.share, self.kept)))


def with_margins(problem: Problem, motion: Stages, margins: Mapping[RowId, Margin]) -> Problem:
    """The problem with margins on the bounds of its rows.

    Args:
        problem: the problem.
        motion: on its grid, at which they are converted.
        margins: by row; others keep their back-off alone.
    """
    transcription, variables = problem.transcription, problem.encode(motion)
    backoff = dict.fromkeys(problem.rows.values(), 0.0) | dict(problem.backoff)

    def values(more: float) -> np.ndarray:
        raised = {row: value + more for row, value in backoff.items()}
        return transcription.constraints(variables, problem.parameters_of(problem.numbers, raised))

    none, half, whole = values(0.0), values(_PROBE / 2), values(_PROBE)
    of_half, of_whole = none - half, none - whole
    bend = (2.0 * of_whole - 4.0 * of_half) / _PROBE**2
    slope = (4.0 * of_half - of_whole) / _PROBE
    lower, upper = problem.row_lower.copy(), problem.row_upper.copy()
    for row, places, nodes in problem.places:
        if row not in margins:
            continue
        at_node = {node: margins[row].around(node, transcription.intervals) for node in set(nodes.tolist())}
        kept = np.array([at_node[node] for node in nodes.tolist()])
        raised = np.maximum(slope[places] * kept + bend[places] * kept**2, 0.0)
        # a value between two ends is divided by what the back-off leaves of them
        left = np.minimum(kept / (1.0 - problem.backoff.get(row, 0.0)), _MOST)
        both = np.isfinite(upper[places])
        lower[places] = np.where(both, (1.0 - left) * lower[places], lower[places] + raised)
        upper[places] = np.where(both, (1.0 - left) * upper[places], upper[places])
    return replace(problem, row_lower=lower, row_upper=upper)
