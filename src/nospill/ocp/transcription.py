"""The whole problem from one stage: derivatives of a stage, mapped over the stages and placed by a fixed permutation.

Variables, scaled: x_0, u_0, x_1, u_1, ..., x_N. Constraints: per stage the gap x_{k+1} - F(x_k, u_k), the equalities and the rows; then the rows
on x_N. Nothing of the size of the whole problem is ever differentiated.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from nospill.constraints import CONSTRAINTS
from nospill.frames import SX
from nospill.numbers import SceneNumbers, Shapes, Structure, flatten, symbolic
from nospill.ocp.layout import Layout, layout_of
from nospill.ocp.stage import Block, stage_expressions, terminal_rows

MX = ca.MX

Placement = tuple[ca.Sparsity, list[int]]


@dataclass(frozen=True)
class Transcription:
    """A problem built for a structure and a number of intervals, ready for any numbers.

    Attributes:
        layout, intervals: sizes.
        stage_rows: (first row of the equalities' end, number of rows) bounds of one stage's rows, see `lower`.
        lower, upper: bounds of all constraints, shape (m,).
        blocks: of one stage's rows, first row counted from the start of the stage.
        terminal_blocks: of the rows on the final state.
        stage_height: constraints per stage.
        reserve_keys: (constraint, subject) of every entry of the reserve vector.
        functions: the NLP's `nlp`, `jac_g`, `grad_f`, `hess_lag` in the signatures of casadi.nlpsol.
    """

    layout: Layout
    intervals: int
    lower: np.ndarray
    upper: np.ndarray
    blocks: tuple[Block, ...]
    terminal_blocks: tuple[Block, ...]
    stage_height: int
    reserve_keys: tuple[tuple[str, int], ...]
    nlp: dict[str, MX]
    jac_g: Any
    grad_f: Any
    hess_lag: Any
    constraint_function: Any

    @property
    def variables(self) -> int:
        """Number of variables."""
        return self.intervals * self.layout.size + self.layout.states

    def parameters(
        self, numbers: SceneNumbers, scales: np.ndarray, reserves: dict[tuple[str, int], float]
    ) -> np.ndarray:
        """The parameter vector: numbers, scales of a stage, reserves."""
        return np.concatenate([flatten(numbers), scales, [reserves.get(key, 0.0) for key in self.reserve_keys]])


def reserve_keys(structure: Structure) -> tuple[tuple[str, int], ...]:
    """Every (constraint, subject) the structure can have, in a fixed order."""
    counts = max(len(structure.objects), len(structure.joints), 3)
    return tuple((constraint.name, subject) for constraint in CONSTRAINTS for subject in range(counts))


def transcribe(structure: Structure, numbers: SceneNumbers, intervals: int) -> Transcription:
    """The transcription of a structure; `numbers` only shows the shapes. Built once per structure and number of intervals."""
    return _transcribe(structure, Shapes(numbers), intervals)


@lru_cache(maxsize=16)
def _transcribe(structure: Structure, shapes: Shapes, intervals: int) -> Transcription:
    layout = layout_of(structure)
    keys = reserve_keys(structure)
    count = shapes.size
    parameters = SX.sym("p", count + layout.size + len(keys))
    numbers = symbolic(shapes.record, parameters[:count])
    scales = parameters[count : count + layout.size]
    reserves = {key: parameters[count + layout.size + index] for index, key in enumerate(keys)}

    scaled = SX.sym("z", layout.size)
    expressions = stage_expressions(
        structure, layout, numbers, scaled * scales, scales=scales, reserves=reserves, intervals=intervals
    )
    gap = -expressions.following / scales[: layout.states]
    constraints = ca.vertcat(gap, expressions.equalities, expressions.rows)
    shift = gap.numel() + expressions.equalities.numel()
    last = SX.sym("x", layout.states)
    terminal = terminal_rows(structure, layout, numbers, last * scales[: layout.states], reserves)
    end_rows, end_lower, end_upper = terminal.stacked()

    pieces = _StagePieces(scaled, last, parameters, expressions.cost, constraints, end_rows)
    zeros = np.zeros(shift)
    return Transcription(
        layout=layout,
        intervals=intervals,
        lower=np.concatenate([np.tile(np.concatenate([zeros, expressions.lower]), intervals), end_lower]),
        upper=np.concatenate([np.tile(np.concatenate([zeros, expressions.upper]), intervals), end_upper]),
        blocks=tuple(
            Block(block.constraint, block.subject, block.first + shift, block.count, block.repetition)
            for block in expressions.blocks
        ),
        terminal_blocks=tuple(terminal.blocks),
        stage_height=constraints.numel(),
        reserve_keys=keys,
        **_assemble(pieces, layout, intervals),
    )


@dataclass(frozen=True)
class _StagePieces:
    stage: SX
    last: SX
    parameters: SX
    cost: SX
    constraints: SX
    end_rows: SX


def _assemble(pieces: _StagePieces, layout: Layout, intervals: int) -> dict[str, Any]:
    """The functions nlpsol takes, from the derivatives of one stage and of the end."""
    z, x, p = pieces.stage, pieces.last, pieces.parameters
    height, end_height = pieces.constraints.numel(), pieces.end_rows.numel()
    stage_multipliers, end_multipliers = SX.sym("l", height), SX.sym("m", end_height)
    cost_multiplier = SX.sym("f")

    jacobian = ca.jacobian(pieces.constraints, z)
    gradient = ca.densify(ca.gradient(pieces.cost, z))
    lagrangian = cost_multiplier * pieces.cost + ca.dot(stage_multipliers, pieces.constraints)
    hessian = ca.triu(ca.hessian(lagrangian, z)[0])
    end_jacobian = ca.jacobian(pieces.end_rows, x)
    end_hessian = ca.triu(ca.hessian(ca.dot(end_multipliers, pieces.end_rows), x)[0])

    values = _mapped("values", [z, p], [pieces.cost, pieces.constraints], intervals, shared=[1])
    slopes = _mapped("slopes", [z, p], [pieces.constraints, _nonzeros(jacobian)], intervals, shared=[1])
    costs = _mapped("costs", [z, p], [pieces.cost, gradient], intervals, shared=[1])
    curvatures = _mapped(
        "curvatures", [z, p, cost_multiplier, stage_multipliers], [_nonzeros(hessian)], intervals, shared=[1, 2]
    )
    end_values = _function("end_values", [x, p], [pieces.end_rows])
    end_slopes = _function("end_slopes", [x, p], [_nonzeros(end_jacobian)])
    end_curvatures = _function("end_curvatures", [x, p, end_multipliers], [_nonzeros(end_hessian)])

    size, states = layout.size, layout.states
    total = intervals * size + states
    rows = intervals * height + end_height
    w, parameter = MX.sym("w", total), MX.sym("p", p.numel())
    stages, final = ca.reshape(w[: intervals * size], size, intervals), w[intervals * size :]
    following = ca.horzcat(stages[:states, 1:], final)

    def gather(mapped: MX) -> MX:
        gaps = ca.vertcat(following + mapped[:states, :], mapped[states:, :])
        return ca.vertcat(ca.vec(gaps), end_values(final, parameter))

    stage_costs, stage_values = values(stages, parameter)
    nlp = {"x": w, "p": parameter, "f": ca.sum2(stage_costs), "g": gather(stage_values)}
    constraint_function = ca.Function("constraints", [w, parameter], [nlp["g"]])

    slope_values, slope_nonzeros = slopes(stages, parameter)
    sparsity, order = _jacobian_places(jacobian, end_jacobian, layout, intervals, height)
    nonzeros = ca.vertcat(ca.vec(slope_nonzeros), MX.ones(intervals * states), end_slopes(final, parameter))
    jac_g = ca.Function(
        "nlp_jac_g", [w, parameter], [gather(slope_values), MX(sparsity, nonzeros[order])], ["x", "p"], ["g", "jac_g_x"]
    )

    costs_value, cost_slopes = costs(stages, parameter)
    grad_f = ca.Function(
        "nlp_grad_f",
        [w, parameter],
        [ca.sum2(costs_value), ca.vertcat(ca.vec(cost_slopes), MX.zeros(states))],
        ["x", "p"],
        ["f", "grad_f_x"],
    )

    multipliers, weight = MX.sym("lam_g", rows), MX.sym("lam_f")
    split = ca.reshape(multipliers[: intervals * height], height, intervals)
    curvature_nonzeros = ca.vertcat(
        ca.vec(curvatures(stages, parameter, weight, split)),
        end_curvatures(final, parameter, multipliers[intervals * height :]),
    )
    sparsity, order = _hessian_places(hessian, end_hessian, layout, intervals)
    hess_lag = ca.Function(
        "nlp_hess_l",
        [w, parameter, weight, multipliers],
        [MX(sparsity, curvature_nonzeros[order])],
        ["x", "p", "lam_f", "lam_g"],
        ["triu_hess_gamma_x_x"],
    )
    return {
        "nlp": nlp,
        "jac_g": jac_g,
        "grad_f": grad_f,
        "hess_lag": hess_lag,
        "constraint_function": constraint_function,
    }


def _function(name: str, inputs: list[SX], outputs: list[SX]) -> Any:
    return ca.Function(name, inputs, [ca.densify(output) for output in outputs], {"cse": True})


def _mapped(name: str, inputs: list[SX], outputs: list[SX], count: int, *, shared: list[int]) -> Callable[..., Any]:
    # `shared` inputs are the same for every stage and are not copied.
    return _function(name, inputs, outputs).map(f"{name}_map", "serial", count, shared, [])


def _nonzeros(matrix: SX) -> SX:
    entries = matrix.nonzeros()
    return ca.vertcat(*entries) if entries else SX(0, 1)


def _triplets(matrix: SX) -> tuple[np.ndarray, np.ndarray]:
    rows, columns = matrix.sparsity().get_triplet()
    return np.array(rows, dtype=int), np.array(columns, dtype=int)


def _place(rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int]) -> Placement:
    """Sparsity of the given entries and, per stored nonzero, which entry it is."""
    order = np.lexsort((rows, columns))
    sparsity = ca.Sparsity.triplet(*shape, rows[order].tolist(), columns[order].tolist())
    return sparsity, order.tolist()


def _jacobian_places(jacobian: SX, end_jacobian: SX, layout: Layout, intervals: int, height: int) -> Placement:
    stage = np.arange(intervals)[:, None]
    rows, columns = _triplets(jacobian)
    end_rows, end_columns = _triplets(end_jacobian)
    state = np.arange(layout.states)
    all_rows = [(stage * height + rows).ravel(), (stage * height + state).ravel(), intervals * height + end_rows]
    all_columns = [
        (stage * layout.size + columns).ravel(),
        ((stage + 1) * layout.size + state).ravel(),
        intervals * layout.size + end_columns,
    ]
    shape = (intervals * height + end_jacobian.shape[0], intervals * layout.size + layout.states)
    return _place(np.concatenate(all_rows), np.concatenate(all_columns), shape)


def _hessian_places(hessian: SX, end_hessian: SX, layout: Layout, intervals: int) -> Placement:
    stage = np.arange(intervals)[:, None]
    rows, columns = _triplets(hessian)
    end_rows, end_columns = _triplets(end_hessian)
    start = intervals * layout.size
    total = start + layout.states
    return _place(
        np.concatenate([(stage * layout.size + rows).ravel(), start + end_rows]),
        np.concatenate([(stage * layout.size + columns).ravel(), start + end_columns]),
        (total, total),
    )
