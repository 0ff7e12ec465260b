"""Traces: every constraint and subject over time, evaluated by the constraints' own expressions."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np

from nospill.certification.after_end import residual_height
from nospill.certification.path_deviation import passing_traces, played_offset
from nospill.certification.replay import Replay, slosh_accelerations, states_at
from nospill.certification.second_order import with_second_order
from nospill.certification.verdict import Trace
from nospill.compiled import codegen
from nospill.compiled.kept import kept
from nospill.core.batches import evaluate
from nospill.core.frames import SX, body_motion, frame_at_rest
from nospill.core.trees import flatten
from nospill.laws.constraints import constraints_of
from nospill.laws.constraints.base import EVERYWHERE, OF_OBJECTS, Constraint, EvaluationPoint, worst_figures
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.kinds import (
    OF_ALL_OBJECTS,
    functions_of_kind,
    limited_object_kind,
    numbers_of_tray,
    symbolic_object,
    symbolic_tray,
    tray_kind,
)
from nospill.laws.parameters import SceneNumbers
from nospill.laws.sample import Sample, coordinate_count, sample_objects, split_states
from nospill.laws.scene_parameters import flat_object_numbers, numbers_of, structure_of
from nospill.laws.structure import Structure
from nospill.motion.interpolation import QUINTIC_SPLINE, JointSamples
from nospill.motion.path_deviation import recorded_freedom
from nospill.motion.trajectory import Trajectory
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene

Inputs = tuple[np.ndarray, list[np.ndarray]]
"""Times (m,), s, and the arrays (rows, m) on which the constraints of one evaluation point are evaluated there."""

_EVALUATED = tuple(point for point in EVERYWHERE if point is not EvaluationPoint.PASSING)
"""Evaluation points whose constraints are functions of `Inputs`."""


def constraint_traces(
    trajectory: Trajectory,
    scene: Scene,
    played: Replay,
    *,
    points: Collection[EvaluationPoint] = EVERYWHERE,
    payload: Sequence[Cargo] | None = None,
) -> tuple[Trace, ...]:
    """Traces of a replayed motion, each on the grid it is judged on.

    Args:
        trajectory: the record.
        scene: what it must keep to.
        played: its replay.
        points: evaluation points; other constraints are left out.
        payload: what the flange carries; the cargo of the scene when left out.

    Returns:
        One trace per constraint and subject, in the order of the certificate.
    """
    wanted = [point for point in _EVALUATED if point in points]
    inputs = {point: inputs_at(point, trajectory, scene, played) for point in wanted}
    traces = evaluated_traces(scene, inputs, payload=payload)
    passing = passing_traces(scene, played) if EvaluationPoint.PASSING in points else ()
    of_modes = _at_end(traces, scene, inputs[EvaluationPoint.END][1]) if EvaluationPoint.END in inputs else traces
    return (*with_second_order(of_modes, scene, played), *passing)


def end_traces(scene: Scene, motions: Sequence[tuple[Trajectory, Replay]]) -> list[tuple[Trace, ...]]:
    """Traces of the rows on the final state of some motions, each a record with its replay, evaluated in one call."""
    ends = [inputs_at(EvaluationPoint.END, trajectory, scene, played) for trajectory, played in motions]
    states = [np.hstack(part) for part in zip(*(own for _, own in ends), strict=True)]
    traces = evaluated_traces(scene, {EvaluationPoint.END: (np.concatenate([t for t, _ in ends]), states)})
    return [
        with_second_order(_at_end(traces, scene, states, first=2 * index), scene, played)
        for index, (_, played) in enumerate(motions)
    ]


def inputs_at(point: EvaluationPoint, trajectory: Trajectory, scene: Scene, played: Replay) -> Inputs:
    """Inputs of the constraints of one of the points in `_EVALUATED`; other arguments as of `constraint_traces`."""
    joints = [played.joint_position.T, played.joint_speed.T, played.joint_acceleration.T]
    match point:
        case EvaluationPoint.OBJECT:
            return played.t, [played.body, played.slosh_displacement.T, played.slosh_velocity.T]
        case EvaluationPoint.JOINT:
            return played.t, [*joints, *_path_deviation(trajectory, scene, played)]
        case EvaluationPoint.TRAY:
            tray = played.tray
            return played.t, [tray.position.T, tray.velocity.T, tray.acceleration.T]
        case EvaluationPoint.CONTROL:
            return control_inputs(trajectory, scene)
        case _:
            ends = np.array([trajectory.end_time, trajectory.rest_time])
            return ends, list(states_at(played, ends))


def _path_deviation(trajectory: Trajectory, scene: Scene, played: Replay) -> list[np.ndarray]:
    """Offset and, where the corridor's width changes along the path, s; nothing where the tray keeps to its path."""
    if scene.motion.corridor is None:
        return []
    offset, s = played_offset(trajectory, scene, played)
    return [offset.T, s[None]] if scene.motion.corridor_shares else [offset.T]


def _at_end(traces: Iterable[Trace], scene: Scene, states: list[np.ndarray], *, first: int = 0) -> Iterator[Trace]:
    """The traces, those on the final state at one instant each, of the end of the motion and the first sample at rest.

    These two lie side by side among the instants of `states`, the end at the index `first`.

    A displacement is that at the end. A residual height holds from where the tray stands, between the last two samples
    it still slows down. Of many modes it is that of the free motion; of one the constraint is a bound, hardly above the
    highest surface.
    """
    structure, objects, numbers = structure_of(scene), numbers_of(scene).objects, flat_object_numbers(scene)
    owners = {cargo.name: index for index, cargo in enumerate(scene.cargo)}
    slices = structure.slosh_slices
    for trace in traces:
        if trace.known is None or trace.known.evaluated_at is not EvaluationPoint.END:
            yield trace
            continue
        is_residual, index = trace.constraint == ResidualHeight.name, owners[trace.subject]
        at = first + int(is_residual)
        instant = slice(at, at + 1)
        final = replace(trace, **{name: getattr(trace, name)[instant] for name in ("t", "value", "limit", "margin")})
        item, modes = structure.objects[index], slices[index]
        if is_residual and item.modes > 1:
            limit = np.abs(final.limit)
            q, qd = (part[modes, at] for part in states)
            own = numbers[index][OF_ALL_OBJECTS:]
            value = np.array([residual_height(item, objects[index], own, q, qd, float(limit[0]))])
            final = replace(final, value=value, margin=limit - value)
        yield final


def evaluated_traces(
    scene: Scene,
    inputs: Mapping[EvaluationPoint, Inputs],
    *,
    constraints: Collection[Constraint] | None = None,
    payload: Sequence[Cargo] | None = None,
) -> tuple[Trace, ...]:
    """Traces of some constraints on given inputs.

    Args:
        scene: what has to be kept.
        inputs: by evaluation point; constraints of others are left out.
        constraints: which; all of the scene when left out.
        payload: what the flange carries; the cargo of the scene when left out.

    Returns:
        One trace per constraint and subject, in the order of the certificate.
    """
    every = constraints_of(scene)
    constraints = every if constraints is None else constraints
    traces: dict[str, list[Trace]] = {constraint.name: [] for constraint in every}
    for point, (t, columns) in inputs.items():
        present = [item for item in constraints if item.evaluated_at is point and item.subjects(scene)]
        if not present:
            continue
        if point in OF_OBJECTS:
            figures = _object_figures(scene, point, columns)
        else:
            figures = _tray_figures(scene, point, columns, numbers_of(scene, payload))
        for constraint in present:
            for subject, figure in zip(constraint.subjects(scene), figures[constraint.name], strict=True):
                traces[constraint.name].append(
                    Trace(constraint.name, subject, constraint.unit, t, *figure, law=constraint)
                )
    return tuple(trace for figure in traces.values() for trace in figure)


Figures = dict[str, list[np.ndarray]]
"""Of every constraint: subject by subject, value, limit and margin (3, m)."""


def _tray_figures(scene: Scene, point: EvaluationPoint, columns: list[np.ndarray], numbers: SceneNumbers) -> Figures:
    function, names = tray_figures_function(tray_kind(structure_of(scene)), point)
    rows = evaluate(function, columns, flatten(numbers_of_tray(numbers)))
    return _by_constraint(names, rows)


def _object_figures(scene: Scene, point: EvaluationPoint, columns: list[np.ndarray]) -> Figures:
    """Object by object; before the slosh coordinates of all, their displacements and velocities, may be the motion."""
    structure, numbers, of_objects = structure_of(scene), flat_object_numbers(scene), {}
    *body, q, qd = columns
    end = structure.end if point is EvaluationPoint.END else "residual"
    for index, (item, modes) in enumerate(zip(structure.objects, structure.slosh_slices, strict=True)):
        function, names = object_figures_function(limited_object_kind(structure, item, end=end), point)
        if names:
            rows = evaluate(function, [*body, q[modes], qd[modes]], numbers[index])
            for name, figures in _by_constraint(names, rows).items():
                of_objects.setdefault(name, []).extend(figures)
    return of_objects


def _by_constraint(names: Sequence[str], rows: np.ndarray) -> Figures:
    found: Figures = {}
    by_rows = np.ascontiguousarray(rows)  # whatever reads a trace reads it several times
    for name, figures in zip(names, by_rows.reshape(len(names), 3, -1), strict=True):
        found.setdefault(name, []).append(figures)
    return found


def control_inputs(trajectory: Trajectory, scene: Scene) -> Inputs:
    """Inputs at `EvaluationPoint.CONTROL`: tilt and its speed (2, m), jerks as in `Sample` (c, m), of joints (n, m)."""
    chains = np.column_stack([trajectory.s[:, None], *recorded_freedom(trajectory, scene)])
    progress, joints, angles = _before(trajectory, scene)
    jerks, of_joints = (
        third_differences(values, before).T * trajectory.rate**3
        for values, before in ((chains, progress), (trajectory.joint_position, joints))
    )
    speed = (
        QUINTIC_SPLINE.motion(angles)(trajectory.t, 1) if np.any(trajectory.tilt) else np.zeros(trajectory.tilt.shape)
    )
    tilt, speed = (np.concatenate([own, own[-1:]]) for own in (trajectory.tilt, speed))
    t = np.append(trajectory.t, trajectory.t[-1] + 1.0 / trajectory.rate)
    return t, [tilt.T, speed.T, jerks, of_joints]


def _before(trajectory: Trajectory, scene: Scene) -> tuple[np.ndarray | None, np.ndarray | None, JointSamples]:
    """What was two periods and one before the first sample (2, n) of the chains and of the joints; tilt as samples.

    None where the motion begins at rest. Before one that begins in motion the first accelerations held already.
    """
    if not trajectory.in_motion:
        return None, None, JointSamples(trajectory.t, trajectory.tilt)
    since = np.array([[-2.0], [-1.0]]) / trajectory.rate
    tilt = (trajectory.tilt, trajectory.tilt_rate, trajectory.tilt_acceleration)
    along = (trajectory.s, trajectory.s_rate, trajectory.s_acceleration)
    joints = (trajectory.joint_position, trajectory.joint_speed, trajectory.joint_acceleration)
    rules, state = scene.motion, scene.initial_state
    if rules.leaves_path:
        assert state is not None  # it says how the tray moves beside its path
        progress = list(state.chains(tilt=rules.tilt_free, offset=rules.corridor is not None, yaw=rules.yaw_free).T)
    else:
        beside = [part[0] for part in tilt] if rules.tilt_free else [np.zeros(0)] * 3
        progress = [np.append(part[0], own) for part, own in zip(along, beside, strict=True)]
    chains, arm = (
        value + since * rate + since**2 / 2 * change for value, rate, change in (progress, [part[0] for part in joints])
    )
    return chains, arm, JointSamples(trajectory.t, *tilt, in_motion=True)


def third_differences(values: np.ndarray, before: np.ndarray | None = None) -> np.ndarray:
    """Third differences (m + 1, n) of samples (m, n) that stand still after, and before but for two given ones (2, n).

    Over the cube of the period each is the mean of the jerk over three periods.
    """
    padded = np.concatenate(
        [np.repeat(values[:1], 2, axis=0) if before is None else before, values, values[-1:], values[-1:]]
    )
    return np.diff(padded, n=3, axis=0)


@kept(maxsize=64)
def object_figures_function(kind: Structure, point: EvaluationPoint) -> tuple[Any, list[str]]:
    """(columns of `Inputs` of one object, `numbers_of_object`) -> value, limit, margin of its constraints; names."""

    def build() -> tuple[codegen.Functions, list[str]]:
        inputs, sample = moving_object(kind) if point is EvaluationPoint.OBJECT else _object_at_rest(kind)
        return _figures(sample, point, inputs)

    made, names, _ = functions_of_kind(f"figures-{point.value}", kind, build, of_columns={"figures": codegen.LAST})
    return made["figures"], names


def moving_object(kind: Structure) -> tuple[list[SX], Sample]:
    """Symbols for the columns of `Inputs` of one object and for `numbers_of_object`, and the sample made of them."""
    (parameters, numbers), count = symbolic_object(kind), coordinate_count(kind)
    body, q, qd = SX.sym("body", 9), SX.sym("q", count), SX.sym("qd", count)
    tray = body_motion(body)
    states = split_states(kind, q, qd, slosh_accelerations(kind, numbers, tray, q, qd))
    sample = Sample(kind, numbers, objects=sample_objects(kind, numbers, tray, states))
    return [body, q, qd, parameters], sample


def _object_at_rest(kind: Structure) -> tuple[list[SX], Sample]:
    """The same at the end of a motion, without the motion of the tray."""
    (parameters, numbers), count = symbolic_object(kind), coordinate_count(kind)
    q, qd = SX.sym("q", count), SX.sym("qd", count)
    states = split_states(kind, q, qd, SX.zeros(count))
    objects = sample_objects(kind, numbers, frame_at_rest(numbers.gravity), states)
    return [q, qd, parameters], Sample(kind, numbers, objects=objects)


@kept(maxsize=16)
def tray_figures_function(kind: Structure, point: EvaluationPoint) -> tuple[Any, list[str]]:
    """(columns of `Inputs`, `numbers_of_tray`) -> value, limit, margin of the constraints; their names, by subject."""

    def build() -> tuple[codegen.Functions, list[str]]:
        (parameters, numbers), joints = symbolic_tray(kind), len(kind.joints)
        if point is EvaluationPoint.JOINT:
            inputs = [SX.sym(name, joints) for name in ("q", "qd", "qdd")]
            inputs += [SX.sym("offset", 3)] if kind.offset_free else []
            inputs += [SX.sym("s")] if kind.corridor_steps else []
            sample = Sample(
                kind,
                numbers,
                joint_position=inputs[0],
                joint_speed=inputs[1],
                joint_acceleration=inputs[2],
                offset=inputs[3] if kind.offset_free else None,
                path_parameter=inputs[4] if kind.corridor_steps else None,
            )
        elif point is EvaluationPoint.TRAY:
            inputs = [SX.sym(name, 3) for name in ("position", "velocity", "acceleration")]
            position, velocity, acceleration = inputs
            sample = Sample(
                kind, numbers, tray_position=position, tray_velocity=velocity, tray_acceleration=acceleration
            )
        else:
            tilt, speed = SX.sym("tilt", 2), SX.sym("tilt_speed", 2)
            jerks, of_joints = SX.sym("jerks", kind.freedom.chains), SX.sym("joint_jerk", joints)
            inputs = [tilt, speed, jerks, of_joints]
            sample = Sample(kind, numbers, tilt=tilt, tilt_speed=speed, jerks=jerks, joint_jerk=of_joints)
        return _figures(sample, point, [*inputs, parameters])

    made, names, _ = functions_of_kind(f"figures-{point.value}", kind, build, of_columns={"figures": codegen.LAST})
    return made["figures"], names


def _figures(sample: Sample, point: EvaluationPoint, inputs: list[SX]) -> tuple[codegen.Functions, list[str]]:
    found = [
        (constraint.name, worst_figures(constraint, budgets))
        for constraint in constraints_of(sample.structure)
        if constraint.evaluated_at is point
        for budgets in constraint.budgets(sample)
    ]
    stacked = ca.densify(ca.vertcat(SX(0, 1), *[figures for _, figures in found]))
    return {"figures": ca.Function("figures", inputs, [stacked], {"cse": True})}, [name for name, _ in found]
