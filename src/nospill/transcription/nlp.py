"""The whole problem from the functions of one stage, mapped over the stages and placed by a fixed permutation.

Variables, scaled: x_0, u_0, x_1, u_1, ..., x_N. Constraints: per stage the gap x_{k+1} - F(x_k, u_k), the equalities
and the active rows; then the active rows on x_N. Nothing of the size of the whole problem is ever differentiated.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from nospill.core.batches import over_columns, thread_count
from nospill.laws.parameters import SceneNumbers, Structure, flatten
from nospill.transcription.layout import Layout
from nospill.transcription.stage import Block, RowIndex
from nospill.transcription.stage_functions import StageFunctions, Triplets, stage_functions

MX = ca.MX

IndexedBackoff = Mapping[RowIndex, float]
"""Row -> fraction of the budget that is kept from the optimiser, 0 where it is not named."""

IndexedRows = frozenset[RowIndex]
"""Rows that take part, those on the final state as well."""

_MOST_THREADS = 4
"""Beyond this, starting threads takes what they save: all stages take one to three milliseconds."""


@dataclass(frozen=True, eq=False)
class Transcription:
    """A problem built for a structure, a number of intervals and a choice of rows, ready for any numbers.

    Attributes:
        stage: the functions it is built from.
        intervals: N.
        lower: bounds of all constraints, shape (m,).
        upper: likewise.
        blocks: of the active rows of a stage, first row counted from the stage's start.
        end_blocks: of the active rows on the final state, first row counted from the first of them.
        rows_per_stage: gaps, equalities and active rows of a stage.
        nlp: variables, parameters, cost and constraints as casadi.nlpsol takes them.
        jac_g: exact Jacobian of the constraints, in the solver's signature.
        grad_f: exact gradient of the cost, likewise.
        hess_lag: exact Hessian of the Lagrangian, likewise.
        constraint_function: (variables, parameters) -> constraints.
    """

    stage: StageFunctions
    intervals: int
    lower: np.ndarray
    upper: np.ndarray
    blocks: tuple[Block, ...]
    end_blocks: tuple[Block, ...]
    rows_per_stage: int
    nlp: dict[str, MX]
    jac_g: Any
    grad_f: Any
    hess_lag: Any
    constraint_function: Any

    @property
    def layout(self) -> Layout:
        """Of a stage vector."""
        return self.stage.layout

    @property
    def variables(self) -> int:
        """Number of variables."""
        return self.intervals * self.layout.size + self.layout.states

    def parameters(self, numbers: SceneNumbers, scales: np.ndarray, backoff: IndexedBackoff) -> np.ndarray:
        """The parameter vector: numbers, scales of a stage, back-off of every row, number of intervals."""
        fractions = [backoff.get(key, 0.0) for key in self.stage.backoff_keys]
        return np.concatenate([flatten(numbers), scales, fractions, [self.intervals]])


def transcribe(
    structure: Structure,
    intervals: int,
    *,
    active: IndexedRows | None = None,
) -> Transcription:
    """The transcription of a structure.

    Args:
        structure: what there is.
        intervals: N.
        active: which rows take part; None for all. The judge looks at all of them in any case.
    """
    return _transcribe(stage_functions(structure), intervals, active)


@lru_cache(maxsize=32)
def _transcribe(stage: StageFunctions, intervals: int, active: IndexedRows | None) -> Transcription:
    whole, layout = stage.sizes, stage.layout
    rows, blocks = _active_rows(whole.blocks, active, whole.fixed)
    end_rows, end_blocks = _active_rows(whole.end_blocks, active, 0)
    zeros = np.zeros(whole.fixed)
    chosen = rows[whole.fixed :] - whole.fixed
    lower = np.concatenate([zeros, whole.lower[chosen]])
    upper = np.concatenate([zeros, whole.upper[chosen]])

    constraints, constraint_jacobian, cost_gradient, lagrangian_hessian = _over_stages(stage, intervals)
    size, states, rows_per_stage = layout.size, layout.states, len(rows)
    total = intervals * size + states
    w = MX.sym("w", total)
    p = MX.sym("p", stage.constraints.size1_in(1))
    stages, final = ca.reshape(w[: intervals * size], size, intervals), w[intervals * size :]
    following = ca.horzcat(stages[:states, 1:], final)

    def gather(mapped: MX) -> MX:
        picked = mapped[rows.tolist(), :]
        gaps = ca.vertcat(following + picked[:states, :], picked[states:, :])
        return ca.vertcat(ca.vec(gaps), stage.end_constraints(final, p)[end_rows.tolist(), :])

    costs, values = constraints(stages, p)
    nlp = {"x": w, "p": p, "f": ca.sum2(costs), "g": gather(values)}

    values, jacobian = constraint_jacobian(stages, p)
    entries, end_entries, sparsity, order = _jacobian_places(stage, rows, end_rows, intervals)
    nonzeros = ca.vertcat(
        ca.vec(jacobian[entries.tolist(), :]),
        MX.ones(intervals * states),
        stage.end_constraint_jacobian(final, p)[end_entries.tolist()],
    )
    jac_g = ca.Function(
        "nlp_jac_g", [w, p], [gather(values), MX(sparsity, nonzeros[order])], ["x", "p"], ["g", "jac_g_x"]
    )

    costs, gradients = cost_gradient(stages, p)
    gradient = ca.vertcat(ca.vec(gradients), MX.zeros(states))
    grad_f = ca.Function("nlp_grad_f", [w, p], [ca.sum2(costs), gradient], ["x", "p"], ["f", "grad_f_x"])

    multipliers, weight = MX.sym("lam_g", intervals * rows_per_stage + len(end_rows)), MX.sym("lam_f")
    own, of_end = ca.vertsplit(multipliers, [0, intervals * rows_per_stage, multipliers.numel()])
    own = ca.reshape(own, rows_per_stage, intervals)
    sparsity, order = _hessian_places(stage, intervals)
    nonzeros = ca.vertcat(
        ca.vec(lagrangian_hessian(stages, p, weight, _for_all_rows(own, rows, whole.rows_per_stage))),
        stage.end_lagrangian_hessian(final, p, _for_all_rows(of_end, end_rows, len(whole.end_lower))),
    )
    hess_lag = ca.Function(
        "nlp_hess_l",
        [w, p, weight, multipliers],
        [MX(sparsity, nonzeros[order])],
        ["x", "p", "lam_f", "lam_g"],
        ["triu_hess_gamma_x_x"],
    )
    return Transcription(
        stage=stage,
        intervals=intervals,
        lower=np.concatenate([np.tile(lower, intervals), whole.end_lower[end_rows]]),
        upper=np.concatenate([np.tile(upper, intervals), whole.end_upper[end_rows]]),
        blocks=blocks,
        end_blocks=end_blocks,
        rows_per_stage=rows_per_stage,
        nlp=nlp,
        jac_g=jac_g,
        grad_f=grad_f,
        hess_lag=hess_lag,
        constraint_function=ca.Function("constraints", [w, p], [nlp["g"]]),
    )


@lru_cache(maxsize=32)
def _over_stages(stage: StageFunctions, intervals: int) -> tuple[Any, Any, Any, Any]:
    """Constraints, their Jacobian, cost gradient and Hessian of all stages: the same for every choice of rows."""
    threads = 1 if stage.compiled else min(_MOST_THREADS, thread_count())
    constraints, constraint_jacobian, cost_gradient = (
        over_columns(function, intervals, [1], threads=threads)
        for function in (stage.constraints, stage.constraint_jacobian, stage.cost_gradient)
    )
    lagrangian_hessian = over_columns(stage.lagrangian_hessian, intervals, [1, 2], threads=threads)
    return constraints, constraint_jacobian, cost_gradient, lagrangian_hessian


def _active_rows(
    all_blocks: tuple[Block, ...], active: IndexedRows | None, fixed: int
) -> tuple[np.ndarray, tuple[Block, ...]]:
    """Indices of the rows that take part, the first `fixed` always, and the active blocks at their new places."""
    rows, blocks = list(range(fixed)), []
    for block in all_blocks:
        if active is None or block.row in active:
            blocks.append(Block(block.constraint, block.subject, len(rows), block.count, block.repetition))
            rows += range(block.first, block.first + block.count)
    return np.array(rows, dtype=int), tuple(blocks)


def _for_all_rows(multipliers: MX, rows: np.ndarray, count: int) -> MX:
    """Multipliers of `count` rows, one column a stage; those of rows that are left out read an appended zero."""
    source = np.full(count, len(rows))
    source[rows] = np.arange(len(rows))
    return ca.vertcat(multipliers, MX.zeros(1, multipliers.size2()))[source.tolist(), :]


def _place(rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int]) -> tuple[ca.Sparsity, list[int]]:
    """Sparsity of the given entries and, per stored nonzero, which entry it is."""
    order = np.lexsort((rows, columns))
    sparsity = ca.Sparsity.triplet(*shape, rows[order].tolist(), columns[order].tolist())
    return sparsity, order.tolist()


def _jacobian_places(
    stage: StageFunctions, active: np.ndarray, end_active: np.ndarray, intervals: int
) -> tuple[np.ndarray, np.ndarray, ca.Sparsity, list[int]]:
    """Entries of a stage's and of the end's Jacobian that take part, sparsity of the whole, order of its nonzeros."""
    layout, sizes, count = stage.layout, stage.sizes, len(active)
    entries, rows, columns = _active_entries(sizes.jacobian, active, sizes.rows_per_stage)
    end_entries, end_rows, end_columns = _active_entries(sizes.end_jacobian, end_active, len(sizes.end_lower))
    index, state = np.arange(intervals)[:, None], np.arange(layout.states)
    all_rows = [(index * count + rows).ravel(), (index * count + state).ravel(), intervals * count + end_rows]
    all_columns = [
        (index * layout.size + columns).ravel(),
        ((index + 1) * layout.size + state).ravel(),
        intervals * layout.size + end_columns,
    ]
    whole = (intervals * count + len(end_active), intervals * layout.size + layout.states)
    return entries, end_entries, *_place(np.concatenate(all_rows), np.concatenate(all_columns), whole)


def _active_entries(triplets: Triplets, active: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which nonzeros of a matrix of `count` rows stand in active ones, with their new rows and their columns."""
    place = np.full(count, -1)
    place[active] = np.arange(len(active))
    rows, columns = triplets
    entries = np.flatnonzero(place[rows] >= 0)
    return entries, place[rows[entries]], columns[entries]


@lru_cache(maxsize=32)
def _hessian_places(stage: StageFunctions, intervals: int) -> tuple[ca.Sparsity, list[int]]:
    size, index = stage.layout.size, np.arange(intervals)[:, None]

    def spread(triplets: Triplets, end: Triplets) -> Callable[[int], np.ndarray]:
        return lambda axis: np.concatenate([(index * size + triplets[axis]).ravel(), intervals * size + end[axis]])

    entries = spread(stage.sizes.hessian, stage.sizes.end_hessian)
    total = intervals * size + stage.layout.states
    return _place(entries(0), entries(1), (total, total))
