"""The whole problem from the blocks of a stage, mapped over the stages and placed by fixed permutations.

Variables, scaled: x_0, u_0, x_1, u_1, ..., x_N. Constraints: per stage the gap x_{k+1} - F(x_k, u_k), the equalities
and the active rows; then the active rows on x_N. Nothing of the size of the whole problem is ever differentiated.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import casadi as ca
import numpy as np

from nospill.core.batches import call
from nospill.core.trees import flatten
from nospill.laws.parameters import SceneNumbers
from nospill.laws.structure import Structure
from nospill.transcription.block_calls import BlockCalls, Multipliers, hessian_parts, jacobian_parts, row_parts
from nospill.transcription.clearance_planes import Groups, number_count, variable_count
from nospill.transcription.clearance_rows import ClearanceRows
from nospill.transcription.jerk_jumps import JerkJumps
from nospill.transcription.layout import Layout
from nospill.transcription.problem_numbers import ProblemNumbers
from nospill.transcription.running_sums import SUMS, RunningSums
from nospill.transcription.stage import Block, RowIndex
from nospill.transcription.stage_functions import StageFunctions, stage_functions
from nospill.transcription.tray_block import Triplets

MX = ca.MX

IndexedBackoff = Mapping[RowIndex, float]
"""Row -> fraction of the budget that is kept from the optimiser, 0 where it is not named."""

IndexedRows = frozenset[RowIndex]
"""Rows that take part, those on the final state as well."""


@dataclass(frozen=True, slots=True)
class Derivatives:
    """Exact derivatives of a problem, in the solver's signatures.

    Attributes:
        jac_g: Jacobian of the constraints.
        grad_f: gradient of the cost.
        hess_lag: Hessian of the Lagrangian.
    """

    jac_g: Any
    grad_f: Any
    hess_lag: Any


@dataclass(frozen=True, eq=False)
class Transcription:
    """A problem built for a structure, a number of intervals and a choice of rows, ready for any numbers.

    Attributes:
        stage: the functions it is built from.
        intervals: N.
        lower: bounds of all constraints, shape (m,).
        upper: likewise.
        active: which rows of a stage with all of its own take part, gaps and equalities among them.
        end_active: likewise, of those on the final state.
        blocks: of the active rows of a stage, first row counted from the stage's start.
        end_blocks: of the active rows on the final state, first row counted from the first of them.
        rows_per_stage: gaps, equalities and active rows of a stage.
        motion_variables: number of variables of the motion; those of running sums and, last, of planes between bodies
            are behind them.
        sum_variables: number of those of running sums.
        clearance_rows: number of rows of clearance, behind all others.
        nlp: variables, parameters, cost and constraints as casadi.nlpsol takes them.
        constraint_function: (variables, parameters) -> constraints.
        make_derivatives: builds `derivatives`.
    """

    stage: StageFunctions
    intervals: int
    lower: np.ndarray
    upper: np.ndarray
    active: np.ndarray
    end_active: np.ndarray
    blocks: tuple[Block, ...]
    end_blocks: tuple[Block, ...]
    rows_per_stage: int
    motion_variables: int
    sum_variables: int
    clearance_rows: int
    nlp: dict[str, MX]
    constraint_function: Any
    make_derivatives: Callable[[], Derivatives]

    @cached_property
    def derivatives(self) -> Derivatives:
        """Made at the first solve: of many problems only the constraints are looked at."""
        return self.make_derivatives()

    @cached_property
    def row_places(self) -> tuple[tuple[RowIndex, np.ndarray, np.ndarray], ...]:
        """Each row that takes part, but for clearance, its places (m,) among the constraints and the node (m,) of each.

        Some rows stand there more than once.
        """
        nodes, end = np.arange(self.intervals), np.array([self.intervals])
        return tuple(
            (
                block.row,
                (stages[:, None] * self.rows_per_stage + block.first + np.arange(block.count)).ravel(),
                np.repeat(stages, block.count),
            )
            for stages, blocks in ((nodes, self.blocks), (end, self.end_blocks))
            for block in blocks
        )

    @property
    def layout(self) -> Layout:
        """Of a stage vector."""
        return self.stage.layout

    @property
    def plane_variables(self) -> int:
        """Number of variables of planes between bodies, behind all others."""
        return self.variables - self.motion_variables - self.sum_variables

    @property
    def variables(self) -> int:
        """Number of variables."""
        return int(self.nlp["x"].numel())

    def constraints(self, variables: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        """Values of all constraints, shape (m,)."""
        return call(self.constraint_function, variables, parameters).ravel()

    def parameters(
        self, numbers: SceneNumbers, own: ProblemNumbers, scales: np.ndarray, backoff: IndexedBackoff
    ) -> np.ndarray:
        """The parameters of the table: numbers, scales of a stage, back-off of every row, number of intervals."""
        fractions = [backoff.get(key, 0.0) for key in self.stage.backoff_keys]
        return np.concatenate([flatten(numbers), flatten(own), scales, fractions, [self.intervals]])


def transcribe(
    structure: Structure,
    intervals: int,
    *,
    active: IndexedRows | None = None,
    clearance: Groups = (),
    jumps: bool = False,
    sums: bool = False,
) -> Transcription:
    """The transcription of a structure.

    Args:
        structure: what there is.
        intervals: N.
        active: which rows of the table take part; None for all. The judge looks at all of them in any case.
        clearance: rows of clearance.
        jumps: whether jumps of the jerk cost something; their weights are behind all other parameters then.
        sums: whether running sums do; their gains are behind those.
    """
    return _transcribe(stage_functions(structure), intervals, active, clearance, jumps, sums)


@lru_cache(maxsize=32)
def _transcribe(
    stage: StageFunctions, intervals: int, active: IndexedRows | None, clearance: Groups, jumps: bool, sums: bool
) -> Transcription:
    whole = stage.sizes
    rows, blocks = _active_rows(whole.blocks, active, whole.fixed)
    end_rows, end_blocks = _active_rows(whole.end_blocks, active, 0)
    zeros = np.zeros(whole.fixed)
    chosen = rows[whole.fixed :] - whole.fixed
    lower = np.concatenate([zeros, whole.lower[chosen]])
    upper = np.concatenate([zeros, whole.upper[chosen]])

    of_motion = intervals * stage.layout.size + stage.layout.states
    of_sums = sums * intervals * SUMS * stage.layout.joints
    w = MX.sym("w", of_motion + of_sums + variable_count(clearance))
    before = stage.sizes.parameters + number_count(clearance)
    behind = before + jumps * stage.layout.chains
    p = MX.sym("p", behind + of_sums)
    given = BlockCalls(stage, intervals, w, p)
    apart = ClearanceRows(clearance, stage.layout, w, p[stage.sizes.parameters : before], of_motion + of_sums)
    of_jumps = JerkJumps(stage.layout, intervals, w, p[before:behind]) if jumps else None
    running = RunningSums(stage.layout, intervals, w, p[behind:]) if sums else None
    gap_rows, row_order = _row_places(stage, rows, end_rows, intervals)
    following = w[_following(stage, intervals)]

    def gathered(stacked: MX) -> MX:
        return ca.vertcat(stacked, stacked[gap_rows] + following)[row_order]

    values, cost = gathered(given.constraints()), given.cost()
    if of_jumps is not None:
        cost += of_jumps.cost
    if running is not None:
        values, cost = running.below(values), cost + running.cost
    values = apart.below(values)

    def derivatives() -> Derivatives:
        of_jacobian, slopes = given.constraint_jacobian()
        sparsity, order = _jacobian_places(stage, rows, end_rows, intervals)
        slopes = ca.vertcat(slopes, MX.ones(intervals * stage.layout.states))
        rows_of_motion, jacobian = gathered(of_jacobian), MX(sparsity, slopes[order])
        if running is not None:
            rows_of_motion, jacobian = running.below(rows_of_motion), running.jacobian_below(jacobian)
        whole_jacobian = list(apart.jacobian_below(rows_of_motion, jacobian))
        jac_g = ca.Function("nlp_jac_g", [w, p], whole_jacobian, ["x", "p"], ["g", "jac_g_x"])
        costs, gradient = given.cost_gradient()
        if of_jumps is not None:
            costs, gradient = costs + of_jumps.cost, gradient + of_jumps.gradient
        if running is not None:
            costs, gradient = costs + running.cost, gradient + running.gradient
        grad_f = ca.Function("nlp_grad_f", [w, p], [costs, gradient], ["x", "p"], ["f", "grad_f_x"])
        multipliers, weight = MX.sym("lam_g", values.numel()), MX.sym("lam_f")
        sparsity, order = _hessian_places(stage, intervals)
        of_table, of_apart = multipliers[: values.numel() - apart.count], multipliers[values.numel() - apart.count :]
        curvature = given.lagrangian_hessian(weight, _for_all_rows(stage, intervals, of_table, rows, end_rows))
        hessian = MX(sparsity, curvature[order])
        if running is not None:
            hessian = running.hessian_beside(hessian, weight)
        hessian = apart.hessian_beside(hessian, of_apart)
        if of_jumps is not None:
            hessian += weight * of_jumps.hessian
        hess_lag = ca.Function(
            "nlp_hess_l",
            [w, p, weight, multipliers],
            [hessian],
            ["x", "p", "lam_f", "lam_g"],
            ["triu_hess_gamma_x_x"],
        )
        return Derivatives(jac_g, grad_f, hess_lag)

    return Transcription(
        stage=stage,
        intervals=intervals,
        lower=np.concatenate([np.tile(lower, intervals), whole.end_lower[end_rows], np.zeros(of_sums + apart.count)]),
        upper=np.concatenate(
            [np.tile(upper, intervals), whole.end_upper[end_rows], np.zeros(of_sums), np.full(apart.count, np.inf)]
        ),
        active=rows,
        end_active=end_rows,
        blocks=blocks,
        end_blocks=end_blocks,
        rows_per_stage=len(rows),
        motion_variables=of_motion,
        sum_variables=of_sums,
        clearance_rows=apart.count,
        nlp={"x": w, "p": p, "f": cost, "g": values},
        constraint_function=ca.Function("constraints", [w, p], [values]),
        make_derivatives=derivatives,
    )


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


def _row_places(
    stage: StageFunctions, active: np.ndarray, end_active: np.ndarray, intervals: int
) -> tuple[list[int], list[int]]:
    """Which of the stacked rows are gaps; and the order of all rows, the finished gaps behind the stacked rows."""
    parts, entries, end_entries = row_parts(stage)
    places, states = parts.places(entries, intervals), stage.layout.states
    gaps = places[:, :states]
    behind = parts.total(intervals) + len(end_entries)
    order = places[:, active].copy()
    order[:, :states] = behind + np.arange(gaps.size).reshape(gaps.shape)
    return gaps.ravel().tolist(), [
        *order.ravel().tolist(),
        *(parts.total(intervals) + end_entries[end_active]).tolist(),
    ]


def _following(stage: StageFunctions, intervals: int) -> list[int]:
    """Variables that are the states at the ends of the intervals."""
    first = (np.arange(intervals)[:, None] + 1) * stage.layout.size
    return (first + np.arange(stage.layout.states)).ravel().tolist()  # type: ignore[no-any-return]


def _for_all_rows(
    stage: StageFunctions, intervals: int, multipliers: MX, rows: np.ndarray, end_rows: np.ndarray
) -> Multipliers:
    """Multipliers of all rows, block by block; those of rows that are left out read an appended zero."""
    none, first = multipliers.numel(), intervals * len(rows)
    source = np.full((intervals, stage.sizes.rows_per_stage), none)
    source[:, rows] = np.arange(first).reshape(intervals, len(rows))
    end_source = np.full(len(stage.sizes.end_lower), none)
    end_source[end_rows] = first + np.arange(len(end_rows))
    padded = ca.vertcat(multipliers, 0)

    def of(own: np.ndarray) -> MX:
        return ca.reshape(padded[source[:, own].ravel().tolist()], len(own), intervals)

    ends = tuple(padded[end_source[item.end_rows].tolist()] for item in stage.objects)
    return Multipliers(of(stage.tray.rows), tuple(of(item.rows) for item in stage.objects), ends)


def _place(rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int]) -> tuple[ca.Sparsity, np.ndarray]:
    """Sparsity of the given entries and, per stored nonzero, which entry it is."""
    order = np.argsort(columns * shape[0] + rows, kind="stable")
    starts = np.searchsorted(columns[order], np.arange(shape[1] + 1))
    return ca.Sparsity(*shape, starts.tolist(), rows[order].tolist()), order


def _jacobian_places(
    stage: StageFunctions, active: np.ndarray, end_active: np.ndarray, intervals: int
) -> tuple[ca.Sparsity, list[int]]:
    """Sparsity of the whole Jacobian; and of each nonzero its place among the stacked ones, behind them the gaps'."""
    layout, sizes, count, parts = stage.layout, stage.sizes, len(active), jacobian_parts(stage)
    entries, rows, columns = _active_entries(sizes.jacobian, active, sizes.rows_per_stage)
    end_entries, end_rows, end_columns = _active_entries(sizes.end_jacobian, end_active, len(sizes.end_lower))
    index, state = np.arange(intervals)[:, None], np.arange(layout.states)
    all_rows = [(index * count + rows).ravel(), (index * count + state).ravel(), intervals * count + end_rows]
    all_columns = [
        (index * layout.size + columns).ravel(),
        ((index + 1) * layout.size + state).ravel(),
        intervals * layout.size + end_columns,
    ]
    ends = parts.total(intervals)
    ones = ends + len(sizes.end_jacobian[0])
    places = [parts.places(entries, intervals).ravel(), ones + np.arange(intervals * layout.states), ends + end_entries]
    whole = (intervals * count + len(end_active), intervals * layout.size + layout.states)
    sparsity, order = _place(np.concatenate(all_rows), np.concatenate(all_columns), whole)
    return sparsity, np.concatenate(places)[order].tolist()


def _active_entries(triplets: Triplets, active: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which nonzeros of a matrix of `count` rows stand in active ones, with their new rows and their columns."""
    place = np.full(count, -1)
    place[active] = np.arange(len(active))
    rows, columns = triplets
    entries = np.flatnonzero(place[rows] >= 0)
    return entries, place[rows[entries]], columns[entries]


@lru_cache(maxsize=32)
def _hessian_places(stage: StageFunctions, intervals: int) -> tuple[ca.Sparsity, list[int]]:
    """Sparsity of the whole Hessian's upper triangle, and of each nonzero its place among the stacked ones."""
    size, index, parts = stage.layout.size, np.arange(intervals)[:, None], hessian_parts(stage)
    per_stage, end = stage.sizes.hessian, stage.sizes.end_hessian
    rows, columns = (
        np.concatenate([(index * size + per_stage[axis]).ravel(), intervals * size + end[axis]]) for axis in range(2)
    )
    places = [
        parts.places(np.arange(len(per_stage[0])), intervals).ravel(),
        parts.total(intervals) + np.arange(len(end[0])),
    ]
    total = intervals * size + stage.layout.states
    sparsity, order = _place(rows, columns, (total, total))
    return sparsity, np.concatenate(places)[order].tolist()
