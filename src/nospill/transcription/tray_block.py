"""The tray block of a stage: path, tilt, chains and joints, and the motion of the tray that the objects read.

It is the same for any cargo and for a path of any number of spans. Its share of the Lagrangian's Hessian is its own
plus what the objects have of the tray's motion: with y the motion numbers, h the length of the interval, V = d(y, h)/dz
and the objects' gamma = dL/dy and S = d2L/d(y, h)2, each summed over the objects,

    K = K_own + sum gamma_k d2y_k/dz2 + V' S V.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from nospill.compiled import codegen
from nospill.compiled.kept import kept
from nospill.core.frames import SX
from nospill.core.trees import flatten, symbolic
from nospill.laws.constraints import constraints_of
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.kinds import functions_of_kind, symbolic_tray, tray_kind
from nospill.laws.parameters import SceneNumbers
from nospill.laws.sample import Sample
from nospill.laws.structure import Structure
from nospill.transcription.joint_equalities import joint_equalities
from nospill.transcription.layout import Layout, layout_of
from nospill.transcription.lifted_variables import LiftedVariables
from nospill.transcription.path_expression import PathPiece, piece_degree, piece_size
from nospill.transcription.problem_numbers import ProblemNumbers
from nospill.transcription.stage import RowCollector, RowIndex, Rows, subject_count
from nospill.transcription.tray_motion import INSTANTS, advance_chains, motion_columns, motion_pattern, tray_motions
from nospill.transcription.tray_state import TrayState

Triplets = tuple[np.ndarray, np.ndarray]
"""Row and column of every structural nonzero, column by column."""

_POINTS = (EvaluationPoint.JOINT, EvaluationPoint.TRAY, EvaluationPoint.CONTROL, EvaluationPoint.PASSING)

SHARED_OF_TRAY = {
    "instants": (1,),
    "cost": (1,),
    "cost_gradient": (1,),
    "constraints": (2,),
    "constraint_jacobian": (2,),
    "motion": (2,),
    "lagrangian_hessian": (2, 3),
}
"""By the name of a function of the block the inputs that are the same at all stages."""


@dataclass(frozen=True, eq=False)
class TrayBlock:
    """Functions of the tray's scaled variables z, the path's pieces at `INSTANTS`, and the parameters p.

    Attributes:
        layout: of the variables; one without objects.
        gaps: how many of the rows are gaps; the equalities of the joints and the constraints follow.
        fixed: how many are gaps and equalities.
        rows: of the constraints.
        jacobian: nonzeros of the Jacobian of its rows.
        hessian: of the upper triangle of the Lagrangian's Hessian.
        instants: (z, p) -> s at `INSTANTS`.
        cost: (z, p) -> cost.
        cost_gradient: (z, p) -> cost, gradient.
        constraints: (z, pieces, p) -> rows, motion numbers.
        constraint_jacobian: (z, pieces, p) -> rows, nonzeros of their Jacobian, motion numbers, nonzeros of theirs.
        motion: (z, pieces, p) -> motion numbers, nonzeros of their Jacobian.
        lagrangian_hessian: (z, pieces, p, multiplier of the cost, of the rows, gamma and S) -> nonzeros.
        compiled: whether they are machine code.
    """

    layout: Layout
    gaps: int
    fixed: int
    rows: Rows
    jacobian: Triplets
    hessian: Triplets
    instants: Any
    cost: Any
    cost_gradient: Any
    constraints: Any
    constraint_jacobian: Any
    motion: Any
    lagrangian_hessian: Any
    compiled: bool

    @property
    def share(self) -> int:
        """Length of gamma and the nonzeros of S."""
        return int(self.lagrangian_hessian.size1_in(5))


def tray_keys(structure: Structure) -> tuple[RowIndex, ...]:
    """Every (constraint, subject) of the tray and the joints, in the order of their back-off among the parameters."""
    kind = tray_kind(structure)
    names = [constraint.name for constraint in constraints_of(kind) if constraint.evaluated_at in _POINTS]
    return tuple(RowIndex(name, subject) for name in names for subject in range(subject_count(kind)))


def tray_block(structure: Structure) -> TrayBlock:
    """The block of a structure."""
    return _block(replace(tray_kind(structure), degree=piece_degree(structure)))


@kept(maxsize=16)
def _block(kind: Structure) -> TrayBlock:
    made, data, compiled = functions_of_kind("tray", kind, lambda: _build(kind), of_columns=SHARED_OF_TRAY)
    jacobian, hessian = (tuple(np.array(part, dtype=int) for part in data[name]) for name in ("jacobian", "hessian"))
    return TrayBlock(
        layout_of(kind),
        data["gaps"],
        data["fixed"],
        Rows.of(data["rows"]),
        (jacobian[0], jacobian[1]),
        (hessian[0], hessian[1]),
        **made,
        compiled=compiled,
    )


@dataclass(frozen=True, slots=True)
class _Symbols:
    z: SX
    pieces: SX
    parameters: SX
    numbers: SceneNumbers
    own: ProblemNumbers
    scales: SX
    backoff: Mapping[RowIndex, SX]
    intervals: SX


def _symbols(structure: Structure, layout: Layout) -> _Symbols:
    keys = tray_keys(structure)
    flat, numbers = symbolic_tray(structure)
    template = ProblemNumbers.blank(structure)
    of_problem = SX.sym("own", len(flatten(template)))
    scales, fractions, count = SX.sym("scales", layout.size), SX.sym("backoff", len(keys)), SX.sym("count")
    pieces = SX.sym("pieces", piece_size(structure.degree, structure.path_columns) * len(INSTANTS))
    backoff = {key: fractions[index] for index, key in enumerate(keys)}
    parameters = ca.vertcat(flat, of_problem, scales, fractions, count)
    own = symbolic(template, of_problem)
    return _Symbols(SX.sym("z", layout.size), pieces, parameters, numbers, own, scales, backoff, count)


def _build(structure: Structure) -> tuple[codegen.Functions, dict[str, Any]]:
    layout, lifted = layout_of(structure), LiftedVariables()
    given = _symbols(structure, layout)
    z, numbers, stage = given.z, given.numbers, given.z * given.scales
    chains = tuple(layout.chain(stage, index) for index in range(layout.chains))
    jerks, interval = stage[layout.jerks], stage[layout.interval]
    columns = structure.path_columns
    split = ca.vertsplit(given.pieces, piece_size(structure.degree, columns))
    pieces = tuple(PathPiece.of(column, columns) for column in split)
    tray = tray_motions(
        chains,
        jerks,
        interval,
        pieces,
        lifted,
        freedom=structure.freedom,
        gravity=numbers.gravity,
        slowed=structure.slowed,
    )
    ends = advance_chains(chains, jerks, interval)
    gaps = -ca.vertcat(*[ca.vertcat(*end) for end in ends], interval) / given.scales[: layout.states]
    equalities = joint_equalities(structure, numbers, given.own, stage, layout, chains, pieces[0], tray.start)
    rows = _rows(structure, layout, numbers, stage, tray.start, given.backoff)
    own = ca.vertcat(gaps, equalities, rows.stacked()[0])
    cost = _cost(layout, given.own, interval, jerks, given.intervals)

    pattern, columns = motion_pattern(structure.freedom, slowed=structure.slowed), motion_columns(layout)
    weight, multipliers, count = SX.sym("f"), SX.sym("l", own.numel()), pattern.count
    gamma, curvature = SX.sym("gamma", count), SX.sym("curvature", pattern.share.nnz())
    motion = lifted.lift(tray.numbers)
    found = lifted.derivatives(
        z,
        ca.vertcat(cost, own, motion),
        ca.vertcat(weight, multipliers, gamma),
        further=(ca.vertcat(motion, z[layout.interval]), ca.triu2symm(SX(pattern.share, curvature))),
    )
    values, jacobian = found.outputs[1 : 1 + own.numel()], found.jacobian[1 : 1 + own.numel(), :]
    motion, slopes = found.outputs[1 + own.numel() :], found.jacobian[1 + own.numel() :, :]
    assert slopes[:, columns].sparsity() == pattern.jacobian and slopes.nnz() == pattern.jacobian.nnz()
    share = ca.vertcat(gamma, curvature)

    instants = ca.vertcat(*[advance_chains(chains[:1], jerks[:1], fraction * interval)[0][0] for fraction in INSTANTS])
    shared = [z, given.pieces, given.parameters]
    outputs: dict[str, tuple[list[SX], Sequence[SX]]] = {
        "instants": ([z, given.parameters], [instants]),
        "cost": ([z, given.parameters], [cost]),
        "cost_gradient": ([z, given.parameters], [cost, ca.gradient(cost, z)]),
        "constraints": (shared, [values, motion]),
        "constraint_jacobian": (shared, [values, nonzeros(jacobian), motion, nonzeros(slopes)]),
        "motion": (shared, [motion, nonzeros(slopes)]),
        "lagrangian_hessian": ([*shared, weight, multipliers, share], [nonzeros(found.hessian)]),
    }
    data = {
        "gaps": gaps.numel(),
        "fixed": gaps.numel() + equalities.numel(),
        "rows": rows.plain(),
        "jacobian": jacobian.sparsity().get_triplet(),
        "hessian": found.hessian.sparsity().get_triplet(),
    }
    return functions_of(outputs), data


def _rows(
    structure: Structure,
    layout: Layout,
    numbers: SceneNumbers,
    stage: SX,
    tray: TrayState,
    backoff: Mapping[RowIndex, SX],
) -> RowCollector:
    """The constraints of joints, tray and jerks, at the node.

    Of the tray's velocity the control point v + a h/2 of the interval h is bounded: with jerks that are constant over
    intervals the speed along a line is a quadratic spline, nowhere above its control points, while between nodes that
    keep a limit it may break it.
    """
    acceleration = tray.acceleration(numbers.gravity)[0]
    sample = Sample(
        structure,
        numbers,
        joint_position=stage[layout.joint_position],
        joint_speed=stage[layout.joint_speed],
        joint_acceleration=stage[layout.joint_derivative(2)] if layout.orders > 1 else None,
        joint_jerk=stage[layout.joint_derivative(3)] if layout.orders > 2 else None,
        command_acceleration=_command_acceleration(layout, numbers, stage) if structure.lagged else None,
        tilt=_values(stage, layout.freedom.tilt_chains),
        tilt_speed=_values(stage, layout.freedom.tilt_chains, order=1),
        offset=_values(stage, layout.freedom.offset_chains),
        tray_position=tray.position,
        tray_velocity=tray.velocity + stage[layout.interval] / 2 * acceleration,
        tray_acceleration=acceleration,
        jerks=stage[layout.jerks],
        path_parameter=stage[0],
    )
    collector = RowCollector(backoff)
    collector.add(sample, _POINTS)
    return collector


def _command_acceleration(layout: Layout, numbers: SceneNumbers, stage: SX) -> SX:
    """Accelerations qdd + lag qddd of a command at both ends of the interval (n, 2), whose jerk is nearly constant."""
    acceleration, jerk = (stage[layout.joint_derivative(order)] for order in (2, 3))
    start = acceleration + numbers.lag * jerk
    both: SX = ca.horzcat(start, start + stage[layout.interval] * jerk)
    return both


def _values(stage: SX, chains: range, order: int = 0) -> SX | None:
    """Values of some of the chains of a stage, or their rates; None where there are none."""
    return ca.vertcat(*[stage[3 * index + order] for index in chains]) if chains else None


def _cost(layout: Layout, own: ProblemNumbers, interval: SX, jerks: SX, intervals: SX) -> SX:
    """Share of the stage, s."""
    weights = [own.path_jerk_weight, *[own.tilt_jerk_weight] * (layout.chains - 1)]
    for index in layout.freedom.offset_chains:
        weights[index] = own.offset_jerk_weight
    cost: SX = interval + sum(weight / intervals * jerks[index] ** 2 for index, weight in enumerate(weights))
    return cost


def functions_of(outputs: Mapping[str, tuple[list[SX], Sequence[SX]]]) -> codegen.Functions:
    """CasADi functions with dense outputs.

    Equal subexpressions are left to `simd_source`: CasADi's search for them takes as long as building the blocks,
    before a first plan, and saves the interpreter 6 to 27 % of the operations.
    """
    return {
        name: ca.Function(name, inputs, [ca.densify(output) for output in results])
        for name, (inputs, results) in outputs.items()
    }


def nonzeros(matrix: SX) -> SX:
    """The stored entries of a matrix, column by column."""
    entries = matrix.nonzeros()
    stacked: SX = ca.vertcat(*entries) if entries else SX.zeros(0, 1)  # type: ignore[call-overload]
    return stacked
