"""One stage as functions: values and exact derivatives with their sparsity, for any numbers of one structure."""

from __future__ import annotations

from dataclasses import astuple, dataclass, replace
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from nospill.core.frames import SX
from nospill.laws import codegen
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.parameters import Structure, parameter_count, symbolic_numbers
from nospill.transcription.layout import Layout, layout_of
from nospill.transcription.stage import Block, RowIndex, stage_expressions, terminal_rows

Triplets = tuple[np.ndarray, np.ndarray]
"""Row and column of every structural nonzero, column by column."""


@dataclass(frozen=True, eq=False)
class StageSizes:
    """Everything about a stage that is not a function; made from plain data that is kept beside compiled code.

    Attributes:
        numbers: entries of a flattened numbers record.
        rows_per_stage: gaps, equalities and rows of constraints of a stage.
        fixed: how many of them are gaps and equalities.
        lower: (rows_per_stage - fixed,) bounds of the rows of constraints.
        upper: likewise.
        blocks: of the rows of constraints, first row counted from the stage's start.
        end_lower: (m,) bounds of the rows on the final state.
        end_upper: likewise.
        end_blocks: of the rows on the final state.
        jacobian: structural nonzeros of the constraints' Jacobian.
        hessian: of the upper triangle of the Lagrangian's Hessian.
        end_jacobian: the same of the rows on the final state.
        end_hessian: likewise.
    """

    numbers: int
    rows_per_stage: int
    fixed: int
    lower: np.ndarray
    upper: np.ndarray
    blocks: tuple[Block, ...]
    end_lower: np.ndarray
    end_upper: np.ndarray
    end_blocks: tuple[Block, ...]
    jacobian: Triplets
    hessian: Triplets
    end_jacobian: Triplets
    end_hessian: Triplets


@dataclass(frozen=True, eq=False)
class StageFunctions:
    """A stage's functions of its scaled vector z, the final state's x, and the parameters p.

    Attributes:
        layout: which entry of z means what.
        sizes: bounds of the constraints and structure of the derivatives.
        backoff_keys: (constraint, subject) of every entry of the back-off vector.
        constraints: (z, p) -> cost, constraints.
        constraint_jacobian: (z, p) -> constraints, nonzeros of their Jacobian.
        cost_gradient: (z, p) -> cost, gradient.
        lagrangian_hessian: (z, p, multiplier of the cost, of the constraints) -> nonzeros of the upper triangle.
        end_constraints: (x, p) -> rows.
        end_constraint_jacobian: (x, p) -> nonzeros.
        end_lagrangian_hessian: (x, p, multipliers) -> nonzeros of the upper triangle.
        compiled: whether they are machine code rather than CasADi's virtual machine.
    """

    layout: Layout
    sizes: StageSizes
    backoff_keys: tuple[RowIndex, ...]
    constraints: Any
    constraint_jacobian: Any
    cost_gradient: Any
    lagrangian_hessian: Any
    end_constraints: Any
    end_constraint_jacobian: Any
    end_lagrangian_hessian: Any
    compiled: bool


def backoff_keys(structure: Structure) -> tuple[RowIndex, ...]:
    """Every (constraint, subject) the structure can have, in a fixed order."""
    counts = max(len(structure.objects), len(structure.joints), 3)
    return tuple(RowIndex(constraint.name, subject) for constraint in CONSTRAINTS for subject in range(counts))


def parameter_sizes(structure: Structure, numbers: int) -> tuple[int, int, int, int]:
    """Lengths of the parts of the parameter vector: numbers, scales of a stage, back-off, number of intervals."""
    return numbers, layout_of(structure).size, len(backoff_keys(structure)), 1


@lru_cache(maxsize=16)
def stage_functions(structure: Structure) -> StageFunctions:
    """The functions of a structure.

    Compiled ones are taken from the disk where an earlier run has left them; otherwise they are built for CasADi's
    virtual machine, and a compiler, where there is one, is started in the background for the next time.
    """
    made, data, is_compiled = codegen.functions("stage", structure, lambda: _build(structure))
    return StageFunctions(layout_of(structure), _sizes(data), backoff_keys(structure), **made, compiled=is_compiled)


def _sizes(data: dict[str, Any]) -> StageSizes:
    table = dict(data)
    for name in ("lower", "upper", "end_lower", "end_upper"):
        table[name] = np.array(table[name], dtype=float)
    for name in ("blocks", "end_blocks"):
        table[name] = tuple(Block(*block) for block in table[name])
    for name in ("jacobian", "hessian", "end_jacobian", "end_hessian"):
        table[name] = tuple(np.array(part, dtype=int) for part in table[name])
    return StageSizes(**table)


def _build(structure: Structure) -> tuple[dict[str, Any], dict[str, Any]]:
    layout, keys = layout_of(structure), backoff_keys(structure)
    sizes = parameter_sizes(structure, parameter_count(structure))
    parameters = SX.sym("p", sum(sizes))
    flat, scales, fractions, count = ca.vertsplit(parameters, np.cumsum([0, *sizes]).tolist())
    numbers = symbolic_numbers(structure, flat)
    backoff = {key: fractions[index] for index, key in enumerate(keys)}

    z, x = SX.sym("z", layout.size), SX.sym("x", layout.states)
    stage = stage_expressions(structure, layout, numbers, z * scales, scales=scales, backoff=backoff, intervals=count)
    gap = -stage.following / scales[: layout.states]
    constraints = ca.vertcat(gap, stage.equalities, stage.rows)
    fixed = gap.numel() + stage.equalities.numel()
    end = terminal_rows(structure, layout, numbers, x * scales[: layout.states], backoff)
    end_rows, end_lower, end_upper = end.stacked()

    multipliers, end_multipliers, weight = SX.sym("l", constraints.numel()), SX.sym("m", end_rows.numel()), SX.sym("f")
    lagrangian = stage.lifted.derivatives(z, ca.vertcat(stage.cost, constraints), ca.vertcat(weight, multipliers))
    constraints, jacobian, hessian = lagrangian.outputs[1:], lagrangian.jacobian[1:, :], lagrangian.hessian
    end_jacobian = ca.jacobian(end_rows, x)
    end_hessian = ca.triu(ca.hessian(ca.dot(end_multipliers, end_rows), x)[0])
    outputs: dict[str, tuple[list[SX], list[SX]]] = {
        "constraints": ([z, parameters], [stage.cost, constraints]),
        "constraint_jacobian": ([z, parameters], [constraints, _nonzeros(jacobian)]),
        "cost_gradient": ([z, parameters], [stage.cost, ca.gradient(stage.cost, z)]),
        "lagrangian_hessian": ([z, parameters, weight, multipliers], [_nonzeros(hessian)]),
        "end_constraints": ([x, parameters], [end_rows]),
        "end_constraint_jacobian": ([x, parameters], [_nonzeros(end_jacobian)]),
        "end_lagrangian_hessian": ([x, parameters, end_multipliers], [_nonzeros(end_hessian)]),
    }
    functions = {
        name: ca.Function(name, inputs, [ca.densify(output) for output in results], {"cse": True})
        for name, (inputs, results) in outputs.items()
    }
    data = {
        "numbers": parameter_count(structure),
        "rows_per_stage": constraints.numel(),
        "fixed": fixed,
        "lower": stage.lower.tolist(),
        "upper": stage.upper.tolist(),
        "blocks": [astuple(replace(block, first=block.first + fixed)) for block in stage.blocks],
        "end_lower": end_lower.tolist(),
        "end_upper": end_upper.tolist(),
        "end_blocks": [astuple(block) for block in end.blocks],
        "jacobian": jacobian.sparsity().get_triplet(),
        "hessian": hessian.sparsity().get_triplet(),
        "end_jacobian": end_jacobian.sparsity().get_triplet(),
        "end_hessian": end_hessian.sparsity().get_triplet(),
    }
    return functions, data


def _nonzeros(matrix: SX) -> SX:
    entries = matrix.nonzeros()
    stacked: SX = ca.vertcat(*entries) if entries else SX.zeros(0, 1)  # type: ignore[call-overload]
    return stacked
