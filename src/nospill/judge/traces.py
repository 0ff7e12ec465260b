"""Traces: every constraint and subject over time, evaluated by the constraints' own expressions."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from nospill.core.batches import evaluate
from nospill.core.frames import SX, body_motion, frame_at_rest
from nospill.core.hermite import cubic_hermite
from nospill.judge.after_end import residual_height
from nospill.judge.replay import Replay, slosh_accelerations
from nospill.judge.verdict import Trace
from nospill.laws import codegen
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.constraints.base import EVERYWHERE, OF_OBJECTS, Constraint, EvaluationPoint, worst_figures
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.parameters import SceneNumbers, Structure, flatten, parameter_count, symbolic_numbers
from nospill.laws.sample import Sample, coordinate_count, sample_objects, split_states
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.motion.trajectory import Trajectory
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene

Inputs = tuple[np.ndarray, list[np.ndarray]]
"""Times (m,), s, and the arrays (rows, m) on which the constraints of one evaluation point are evaluated there."""


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
    end = trajectory.end_time
    inputs: dict[EvaluationPoint, Inputs] = {
        EvaluationPoint.OBJECT: (played.t, [played.body, played.slosh_displacement.T, played.slosh_velocity.T]),
        EvaluationPoint.JOINT: (
            played.t,
            [played.joint_position.T, played.joint_speed.T, played.joint_acceleration.T],
        ),
        EvaluationPoint.CONTROL: control_inputs(trajectory),
        EvaluationPoint.END: (np.array([end]), list(_state_at(played, end))),
    }
    traces = evaluated_traces(scene, {point: inputs[point] for point in inputs if point in points}, payload=payload)
    return tuple(_played_on(traces, scene, inputs[EvaluationPoint.END][1]))


def _played_on(traces: Iterable[Trace], scene: Scene, state: list[np.ndarray]) -> Iterator[Trace]:
    """The traces, those of residual heights whose bound is above the limit from the free motion.

    Of a single mode the bound is hardly above its highest surface.
    """
    structure, numbers = structure_of(scene), numbers_of(scene)
    owners = {cargo.name: index for index, cargo in enumerate(scene.cargo)}
    for trace in traces:
        if trace.constraint != ResidualHeight.name or trace.margin[0] >= 0.0:
            yield trace
            continue
        index = owners[trace.subject]
        item, own = structure.objects[index], structure.slosh_slices[index]
        if item.modes == 1:
            yield trace
            continue
        limit = float(trace.limit[0])
        q, qd = (part[own, 0] for part in state)
        value = np.array([residual_height(item, numbers.objects[index], q, qd, abs(limit))])
        yield replace(trace, value=value, margin=abs(trace.limit) - value)


def evaluated_traces(
    scene: Scene,
    inputs: Mapping[EvaluationPoint, Inputs],
    *,
    constraints: Collection[Constraint] = CONSTRAINTS,
    payload: Sequence[Cargo] | None = None,
) -> tuple[Trace, ...]:
    """Traces of some constraints on given inputs.

    Args:
        scene: what has to be kept.
        inputs: by evaluation point; constraints of others are left out.
        constraints: which, of `CONSTRAINTS`.
        payload: what the flange carries; the cargo of the scene when left out.

    Returns:
        One trace per constraint and subject, in the order of the certificate.
    """
    traces: dict[str, list[Trace]] = {constraint.name: [] for constraint in CONSTRAINTS}
    for part, structure, numbers, own in _parts(scene, numbers_of(scene, payload), inputs):
        for point, (t, columns) in own.items():
            present = [item for item in CONSTRAINTS if item.evaluated_at is point and item.subjects(part)]
            if not any(item in constraints for item in present):
                continue
            function = _figures(structure)[f"figures_{point.value}"]
            rows = iter(evaluate(function, columns, flatten(numbers)).reshape(-1, 3, len(t)))
            for constraint in present:
                for subject in constraint.subjects(part):
                    figures = next(rows)  # value, limit, margin
                    if constraint in constraints:
                        traces[constraint.name].append(Trace(constraint.name, subject, constraint.unit, t, *figures))
    return tuple(trace for own in traces.values() for trace in own)


Part = tuple[Scene, Structure, SceneNumbers, dict[EvaluationPoint, Inputs]]
"""A part of a scene: what names its subjects, its structure and numbers, and the inputs that concern it."""


def _parts(scene: Scene, numbers: SceneNumbers, inputs: Mapping[EvaluationPoint, Inputs]) -> Iterator[Part]:
    """The scene without its objects, then each of them alone.

    Expressions of one object serve all like it, so a full tray needs no more of them than a single cup.
    """
    whole = structure_of(scene)
    of_arm = {point: given for point, given in inputs.items() if point not in OF_OBJECTS}
    yield replace(scene, cargo=()), replace(whole, objects=()), replace(numbers, objects=()), of_arm
    items = zip(scene.cargo, whole.objects, numbers.objects, whole.slosh_slices, strict=True)
    for cargo, structure, own, coordinates in items:
        of_object = {
            point: (t, [*columns[:-2], *(rows[coordinates] for rows in columns[-2:])])  # displacements and velocities
            for point, (t, columns) in inputs.items()
            if point in OF_OBJECTS
        }
        part = replace(scene, cargo=(cargo,))
        yield part, replace(whole, objects=(structure,)), replace(numbers, objects=(own,)), of_object


def control_inputs(trajectory: Trajectory) -> Inputs:
    """Inputs at `EvaluationPoint.CONTROL`: tilt (2, m), jerks of s and tilt (3, m), and of the joints (n, m)."""
    jerks = third_differences(np.column_stack([trajectory.s, trajectory.tilt, trajectory.joint_position]))
    jerks *= trajectory.rate**3
    tilt = np.concatenate([trajectory.tilt, trajectory.tilt[-1:]])
    t = np.append(trajectory.t, trajectory.t[-1] + 1.0 / trajectory.rate)
    return t, [tilt.T, jerks[:, :3].T, jerks[:, 3:].T]


def third_differences(values: np.ndarray) -> np.ndarray:
    """Third differences (m + 1, n) of samples (m, n) that stand still before and after.

    Over the cube of the period each is the mean of the jerk over three periods.
    """
    padded = np.concatenate([values[:1], values[:1], values, values[-1:], values[-1:]])
    return np.diff(padded, n=3, axis=0)


def _state_at(played: Replay, t: float) -> tuple[np.ndarray, np.ndarray]:
    """Slosh displacement and velocity (k, 1) at a time between grid points, by the cubic through both ends."""
    left = int(np.clip(np.searchsorted(played.t, t, side="right") - 1, 0, len(played.t) - 2))
    width = float(played.t[left + 1] - played.t[left])
    u = (t - played.t[left]) / width
    q, qd = (values[left : left + 2] for values in (played.slosh_displacement, played.slosh_velocity))
    return cubic_hermite(u, width, q, qd)[:, None], ((1 - u) * qd[0] + u * qd[1])[:, None]


@lru_cache(maxsize=16)
def _figures(structure: Structure) -> codegen.Functions:
    def build() -> tuple[codegen.Functions, None]:
        points = [point for point in EvaluationPoint if (point in OF_OBJECTS) == bool(structure.objects)]
        made = [_figures_function(structure, point) for point in points]
        return {function.name(): function for function in made if function is not None}, None

    return codegen.functions("figures", structure, build)[0]


def _figures_function(structure: Structure, point: EvaluationPoint) -> Any | None:
    """(columns of `Inputs`, parameters) -> value, limit, margin of all constraints and subjects of one point.

    None where no constraint has a subject there.
    """
    parameters = SX.sym("p", parameter_count(structure))
    numbers = symbolic_numbers(structure, parameters)
    count = coordinate_count(structure)
    q, qd = SX.sym("q", count), SX.sym("qd", count)
    if point is EvaluationPoint.OBJECT:
        body = SX.sym("body", 9)
        tray = body_motion(body)
        slosh = split_states(structure, q, qd, slosh_accelerations(structure, numbers, tray, q, qd))
        sample = Sample(structure, numbers, objects=sample_objects(structure, numbers, tray, slosh))
        inputs = [body, q, qd]
    elif point is EvaluationPoint.END:
        slosh = split_states(structure, q, qd, SX.zeros(count))
        sample = Sample(
            structure, numbers, objects=sample_objects(structure, numbers, frame_at_rest(numbers.gravity), slosh)
        )
        inputs = [q, qd]
    elif point is EvaluationPoint.JOINT:
        inputs = [SX.sym(name, len(structure.joints)) for name in ("q", "qd", "qdd")]
        sample = Sample(
            structure, numbers, joint_position=inputs[0], joint_speed=inputs[1], joint_acceleration=inputs[2]
        )
    else:
        inputs = [SX.sym("tilt", 2), SX.sym("jerks", 3), SX.sym("joint_jerk", len(structure.joints))]
        sample = Sample(structure, numbers, tilt=inputs[0], jerks=inputs[1], joint_jerk=inputs[2])
    stacked = []
    for constraint in CONSTRAINTS:
        if constraint.evaluated_at is point:
            stacked += [worst_figures(constraint, budgets) for budgets in constraint.budgets(sample)]
    if not stacked:
        return None
    return ca.Function(
        f"figures_{point.value}", [*inputs, parameters], [ca.densify(ca.vertcat(*stacked))], {"cse": True}
    )
