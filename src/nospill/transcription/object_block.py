"""The block of one object in a stage: its liquid's collocation, and its constraints at the node and in the middle.

It reads the tray through the motion numbers y alone, and the length h of the interval. So it is the same on any robot
and along any path, and once for all objects of its kind. From V = d(y, h)/dz of the tray it makes the derivatives with
respect to the tray's variables itself: J_(y,h) V, and K_(own,(y,h)) V for its own with the tray's; what second
derivatives it has of (y, h) alone, with gamma = dL/dy, is summed over the objects and transformed by the tray block.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from nospill.compiled import codegen
from nospill.compiled.kept import kept
from nospill.core.frames import SX, FrameMotion, frame_at_rest
from nospill.laws.constraints import constraints_of
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.contact import Wrench
from nospill.laws.kinds import functions_of_kind, limited_object_kind, symbolic_object
from nospill.laws.parameters import SceneNumbers
from nospill.laws.sample import ObjectSample, Sample, driven_state, object_motion, object_states, sample_objects
from nospill.laws.slosh.driven_modes import driven_residual
from nospill.laws.slosh.motion import motion_residual
from nospill.laws.structure import ObjectStructure, Structure
from nospill.transcription.collocation import gauss_step, interior
from nospill.transcription.lifted_variables import LiftedVariables
from nospill.transcription.stage import RowCollector, RowIndex, Rows
from nospill.transcription.tray_block import Triplets, functions_of, nonzeros
from nospill.transcription.tray_motion import INSTANTS, motion_pattern, with_interval

_NODE, _COLLOCATION, _MIDDLE = 0, (1, 2), 3
"""Places among `INSTANTS`."""

SHARED_OF_OBJECT = {"constraints": (3,), "constraint_jacobian": (4,), "lagrangian_hessian": (4,)}
"""By the name of a function of the block the inputs that are the same at all stages."""


@dataclass(frozen=True, eq=False)
class ObjectBlock:
    """Functions of an object's own scaled variables, the tray's motion, the scaled length of the interval, and p.

    Own variables: displacements, velocities, accelerations at both collocation points, `coordinates` of each. Own rows:
    gaps of displacements and of velocities, equations of motion at both points, constraints. Columns of the tray are
    the motion variables.

    Attributes:
        coordinates: number of its slosh coordinates.
        rows: of the constraints.
        tray_jacobian: nonzeros of the Jacobian with respect to the motion variables.
        own_jacobian: with respect to its own variables.
        cross_hessian: of the Lagrangian's Hessian, own variables by motion variables.
        own_hessian: upper triangle for its own variables.
        constraints: (y, own, h, p) -> rows.
        constraint_jacobian: (y, nonzeros of dy/dz, own, h, p) -> rows, nonzeros of both Jacobians.
        lagrangian_hessian: (y, nonzeros of dy/dz, own, h, p, multipliers) -> nonzeros of both Hessians; gamma and
            nonzeros of the pattern's share.
        compiled: whether they are machine code.
    """

    coordinates: int
    rows: Rows
    tray_jacobian: Triplets
    own_jacobian: Triplets
    cross_hessian: Triplets
    own_hessian: Triplets
    constraints: Any
    constraint_jacobian: Any
    lagrangian_hessian: Any
    compiled: bool

    @property
    def fixed(self) -> int:
        """How many of its rows are gaps and equalities."""
        return 4 * self.coordinates


@dataclass(frozen=True, eq=False)
class EndBlock:
    """Functions of an object's scaled displacements and velocities at the end, and of p.

    Attributes:
        rows: of the constraints.
        jacobian: its nonzeros.
        hessian: of the upper triangle of the Lagrangian's.
        end_constraints: (x, p) -> rows.
        end_constraint_jacobian: (x, p) -> nonzeros.
        end_lagrangian_hessian: (x, p, multipliers) -> nonzeros.
        compiled: whether they are machine code.
    """

    rows: Rows
    jacobian: Triplets
    hessian: Triplets
    end_constraints: Any
    end_constraint_jacobian: Any
    end_lagrangian_hessian: Any
    compiled: bool


def constraint_names(point: EvaluationPoint, kind: Structure) -> tuple[str, ...]:
    """Constraints of an object at one of its points, in the order of their back-off among the parameters."""
    return tuple(constraint.name for constraint in constraints_of(kind) if constraint.evaluated_at is point)


def object_block(structure: Structure, item: ObjectStructure) -> ObjectBlock:
    """The block of an object of a structure."""
    tilt, offset, yaw, by_joints = structure.freedom
    alone = limited_object_kind(structure, item)
    kind = replace(
        alone, tilt_free=tilt, offset_free=offset, yaw_free=yaw, by_joints=by_joints, slowed=structure.slowed
    )
    return _object_block(kind)


def end_block(structure: Structure, item: ObjectStructure) -> EndBlock:
    """The rows of an object on the final state, the tray at rest and level."""
    return _end_block(limited_object_kind(structure, item, end=structure.end))


@kept(maxsize=64)
def _object_block(kind: Structure) -> ObjectBlock:
    made, data, compiled = functions_of_kind("object", kind, lambda: _build(kind), of_columns=SHARED_OF_OBJECT)
    names = ("tray_jacobian", "own_jacobian", "cross_hessian", "own_hessian")
    triplets = {name: _triplets(data[name]) for name in names}
    return ObjectBlock(kind.objects[0].coordinates, Rows.of(data["rows"]), **triplets, **made, compiled=compiled)


@kept(maxsize=64)
def _end_block(kind: Structure) -> EndBlock:
    made, data, compiled = functions_of_kind("end", kind, lambda: _build_end(kind))
    triplets = {name: _triplets(data[name]) for name in ("jacobian", "hessian")}
    return EndBlock(Rows.of(data["rows"]), **triplets, **made, compiled=compiled)


def _triplets(table: Any) -> Triplets:
    rows, columns = (np.array(part, dtype=int) for part in table)
    return rows, columns


@dataclass(frozen=True, slots=True)
class _Symbols:
    parameters: SX
    numbers: SceneNumbers
    interval_scale: SX
    scales: SX
    backoff: dict[RowIndex, SX]


def _symbols(kind: Structure, point: EvaluationPoint, variables: int) -> _Symbols:
    flat, numbers = symbolic_object(kind)
    names = constraint_names(point, kind)
    interval_scale, scales, fractions = SX.sym("hs"), SX.sym("scales", variables), SX.sym("backoff", len(names))
    backoff = {RowIndex(name, 0): fractions[index] for index, name in enumerate(names)}
    return _Symbols(ca.vertcat(flat, interval_scale, scales, fractions), numbers, interval_scale, scales, backoff)


def _build(kind: Structure) -> tuple[codegen.Functions, dict[str, Any]]:
    pattern, coordinates = motion_pattern(kind.freedom, slowed=kind.slowed), kind.objects[0].coordinates
    count, lifted = pattern.count, LiftedVariables()
    given = _symbols(kind, EvaluationPoint.OBJECT, 4 * coordinates)
    y, length, z = SX.sym("y", count), SX.sym("h"), SX.sym("z", 4 * coordinates)
    rows = RowCollector(given.backoff)
    fixed = _expressions(kind, given, pattern.frames(y), z * given.scales, length * given.interval_scale, rows, lifted)
    outputs = ca.vertcat(fixed, rows.stacked()[0])

    multipliers = SX.sym("l", outputs.numel())
    found = lifted.derivatives(ca.vertcat(y, length, z), outputs, multipliers)
    slopes = SX.sym("e", pattern.jacobian.nnz())
    through = with_interval(SX(pattern.jacobian, slopes), pattern.interval)
    of_tray = count + 1
    tray_jacobian, own_jacobian = found.jacobian[:, :of_tray] @ through, found.jacobian[:, of_tray:]
    cross = found.hessian[:of_tray, of_tray:].T @ through
    own_hessian, share = found.hessian[of_tray:, of_tray:], found.hessian[:of_tray, :of_tray]
    assert (share.sparsity() + pattern.share) == pattern.share  # no row reads two instants
    sums = ca.vertcat(found.gradient[:count], nonzeros(ca.project(share, pattern.share)))
    made = functions_of(
        {
            "constraints": ([y, z, length, given.parameters], [found.outputs]),
            "constraint_jacobian": (
                [y, slopes, z, length, given.parameters],
                [found.outputs, ca.vertcat(nonzeros(tray_jacobian), nonzeros(own_jacobian))],
            ),
            "lagrangian_hessian": (
                [y, slopes, z, length, given.parameters, multipliers],
                [ca.vertcat(nonzeros(cross), nonzeros(own_hessian)), sums],
            ),
        }
    )
    matrices = {
        "tray_jacobian": tray_jacobian,
        "own_jacobian": own_jacobian,
        "cross_hessian": cross,
        "own_hessian": own_hessian,
    }
    return made, {"rows": rows.plain()} | {name: item.sparsity().get_triplet() for name, item in matrices.items()}


def _expressions(
    kind: Structure,
    given: _Symbols,
    motions: tuple[FrameMotion, ...],
    own: SX,
    interval: SX,
    rows: RowCollector,
    lifted: LiftedVariables,
) -> SX:
    """Gaps and equations of motion (4 coordinates, 1), scaled; the constraints are added to `rows`.

    `own` are its variables in physical units.
    """
    item, numbers = kind.objects[0], given.numbers.objects[0]
    displacement, velocity, *accelerations = _quarters(own, item.coordinates)
    of_displacement, of_velocity, *of_accelerations = _quarters(given.scales, item.coordinates)
    pair = accelerations[0], accelerations[1]
    step = gauss_step(displacement, velocity, pair, interval)
    fixed = [-step.end_displacement / of_displacement, -step.end_velocity / of_velocity]
    for point, instant in enumerate(_COLLOCATION):
        position, rate = lifted.lift(step.point_displacements[point]), lifted.lift(step.point_velocities[point])
        motion = object_motion(numbers, motions[instant])
        residuals = [
            motion_residual(oscillator, directions, motion, state, damp_against_spin=kind.fidelity == "deliverable")
            for oscillator, directions, state in zip(
                numbers.oscillators,
                item.oscillators,
                object_states(item, position, rate, pair[point]),
                strict=True,
            )
        ]
        if item.driven:
            states = object_states(item, position, rate, pair[point])
            waves = driven_state(item, position, rate, pair[point])
            residuals.append(driven_residual(item, numbers, motion, states, waves))
        if residuals:
            fixed.append(ca.vertcat(*residuals) / of_accelerations[point])
    # Constraints are imposed at the node, where jerk-limited accelerations have their corners, and in the middle.
    for repetition, instant in enumerate((_NODE, _MIDDLE)):
        inside = interior(displacement, velocity, pair, INSTANTS[instant], interval)
        states = object_states(item, *(lifted.lift(part) for part in inside))
        samples = sample_objects(kind, given.numbers, motions[instant], (states,))
        sample = Sample(kind, given.numbers, objects=tuple(_lifted(one, lifted) for one in samples))
        rows.add(sample, (EvaluationPoint.OBJECT,), repetition)
    return ca.vertcat(*fixed)


def _lifted(item: ObjectSample, lifted: LiftedVariables) -> ObjectSample:
    wrench = Wrench(lifted.lift(item.wrench.force), lifted.lift(item.wrench.moment))
    surface, added = item.surface, item.yaw_heights
    return replace(
        item, wrench=wrench, surface=lifted.lift(surface), yaw_heights=lifted.lift(added) if added.numel() else added
    )


def _quarters(own: SX, coordinates: int) -> list[SX]:
    return [own[part * coordinates : (part + 1) * coordinates] for part in range(4)]


def _build_end(kind: Structure) -> tuple[codegen.Functions, dict[str, Any]]:
    item = kind.objects[0]
    given, x = _symbols(kind, EvaluationPoint.END, 2 * item.coordinates), SX.sym("x", 2 * item.coordinates)
    displacement, velocity = ca.vertsplit(x * given.scales, [0, item.coordinates, 2 * item.coordinates])
    # slosh accelerations are not read there
    states = object_states(item, displacement, velocity, SX.zeros(item.coordinates))
    objects = sample_objects(kind, given.numbers, frame_at_rest(given.numbers.gravity), (states,))
    if item.driven:
        own = driven_state(item, displacement, velocity, SX.zeros(item.coordinates))
        objects = (replace(objects[0], driven=own),)
    rows = RowCollector(given.backoff)
    rows.add(Sample(kind, given.numbers, objects=objects), (EvaluationPoint.END,))
    values = rows.stacked()[0]
    multipliers = SX.sym("m", values.numel())
    jacobian, hessian = ca.jacobian(values, x), ca.triu(ca.hessian(ca.dot(multipliers, values), x)[0])
    p = given.parameters
    made = functions_of(
        {
            "end_constraints": ([x, p], [values]),
            "end_constraint_jacobian": ([x, p], [nonzeros(jacobian)]),
            "end_lagrangian_hessian": ([x, p, multipliers], [nonzeros(hessian)]),
        }
    )
    data = {"jacobian": jacobian.sparsity().get_triplet(), "hessian": hessian.sparsity().get_triplet()}
    return made, {"rows": rows.plain()} | data
