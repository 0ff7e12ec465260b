"""The judge: a verdict from the exported trajectory and the scene alone."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from nospill.core.batches import evaluate
from nospill.core.frames import SX, FrameMotion, body_motion
from nospill.judge.record_checks import record_rows, require_motion, require_same_joints_and_liquids
from nospill.judge.replay import MINIMUM_RATE, Replay, replay, slosh_accelerations
from nospill.judge.verdict import Certificate, Row, Trace, condensed, worst_row
from nospill.laws import codegen
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.constraints.base import EVERYWHERE, OF_OBJECTS, EvaluationPoint, worst_figures
from nospill.laws.constraints.joint_torque import JointTorque
from nospill.laws.parameters import Shapes, Structure, symbolic
from nospill.laws.sample import Sample, coordinate_count, sample_objects, split_states
from nospill.laws.scene_parameters import flat_numbers, numbers_of, structure_of
from nospill.motion.holds import held_trajectory
from nospill.motion.interpolation import JointMotion
from nospill.motion.trajectory import Trajectory
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene
from nospill.scene.tolerances import corner_scenes, heaviest, lightest


@dataclass(frozen=True, slots=True)
class Judgement:
    """A certificate with what it was read from.

    Attributes:
        traces: of every constraint, for the objects as stated. replay: dense, likewise.
        corners: where their numbers may be off, the rows of every variant; the certificate has the worst of them.
    """

    certificate: Certificate
    traces: tuple[Trace, ...]
    replay: Replay
    corners: tuple[Row, ...] = ()


def certify(
    trajectory: Trajectory, scene: Scene, *, motion: JointMotion | None = None, rate: float = MINIMUM_RATE
) -> Certificate:
    """Judge an exported trajectory.

    The joints are played again on a dense grid, the tray's pose and motion recomputed from them, the liquids
    re-integrated from rest; every constraint of the scene is evaluated at every instant. Where numbers of the objects
    may be off, each constraint of theirs is evaluated at every corner too, and the worst row is the one that counts.

    Args:
        trajectory: the record.
        scene: what it must keep to.
        motion: what the receiver's joints do; the quintic spline through the recorded positions when left out.
        rate: Hz, the least rate of the grid; a second, finer certificate is one at a higher rate (8 kHz, say).

    Raises:
        ModelError: the liquids cannot be integrated.
        PlanFolderError: the trajectory does not fit the scene (other joints or liquids), or is no motion (a value that
            is not finite, time that does not run forward).
    """
    return judge(trajectory, scene, motion=motion, rate=rate).certificate


def judge(
    trajectory: Trajectory,
    scene: Scene,
    *,
    motion: JointMotion | None = None,
    rate: float = MINIMUM_RATE,
) -> Judgement:
    """`certify` with its evidence; the same arguments and errors."""
    require_same_joints_and_liquids(trajectory, scene)
    require_motion(trajectory)
    held = held_trajectory(trajectory, scene.motion)
    played = replay(held, scene, motion=motion, rate=rate)
    traces = constraint_traces(held, scene, played)
    corners = corner_rows(held, scene, motion=motion, rate=rate, played=played)
    rows = [*condensed([*map(worst_row, traces), *corners]), *record_rows(trajectory, held, scene, played)]
    return Judgement(Certificate(all(row.ok for row in rows), played.rate, tuple(rows)), traces, played, corners)


def constraint_traces(
    trajectory: Trajectory,
    scene: Scene,
    played: Replay,
    *,
    points: Collection[EvaluationPoint] = EVERYWHERE,
    payload: Sequence[Cargo] | None = None,
) -> tuple[Trace, ...]:
    """Every constraint and subject over time, each on the grid it is judged on; of some evaluation points only.

    `payload` is what the flange carries, where that is not the cargo of the scene.
    """
    structure, numbers = structure_of(scene), numbers_of(scene)
    parameters = flat_numbers(scene, payload)
    traces = []
    for point, (t, columns) in _inputs(trajectory, played).items():
        constraints = [item for item in CONSTRAINTS if item.evaluated_at is point and item.subjects(scene)]
        if not constraints or point not in points:
            continue
        function = _figures(structure, Shapes(numbers))[f"figures_{point.value}"]
        table = evaluate(function, columns, parameters)
        table = table.reshape(-1, 3, len(t))
        row = 0
        for constraint in constraints:
            for subject in constraint.subjects(scene):
                value, limit, margin = table[row]
                traces.append(Trace(constraint.name, subject, constraint.unit, t, value, limit, margin))
                row += 1
    order = {constraint.name: index for index, constraint in enumerate(CONSTRAINTS)}
    return tuple(sorted(traces, key=lambda trace: order[trace.constraint]))


def corner_rows(
    trajectory: Trajectory,
    scene: Scene,
    *,
    motion: JointMotion | None = None,
    rate: float = MINIMUM_RATE,
    played: Replay | None = None,
) -> tuple[Row, ...]:
    """Rows of every constraint on every variant of the objects; none where all numbers are certain.

    Args:
        trajectory: the record, with its holds.
        scene: what it must keep to.
        motion: what the receiver's joints do; the spline through the recorded positions when left out.
        rate: Hz, the least rate of the grid.
        played: the replay of the scene as stated; with it, joint torques under the heaviest and the lightest load too.
    """
    rows = []
    for corner in corner_scenes(scene):
        own = replay(trajectory, corner.scene, motion=motion, rate=rate)
        for trace in constraint_traces(trajectory, corner.scene, own, points=OF_OBJECTS):
            if trace.subject in corner.texts:
                rows.append(replace(worst_row(trace), variant=corner.texts[trace.subject]))
    if rows and played is not None:
        for text, load in (("the heaviest load", heaviest(scene)), ("the lightest load", lightest(scene))):
            loaded = constraint_traces(trajectory, scene, played, points=(EvaluationPoint.JOINT,), payload=load)
            rows += [
                replace(worst_row(trace), variant=text) for trace in loaded if trace.constraint == JointTorque.name
            ]
    return tuple(rows)


def _inputs(trajectory: Trajectory, played: Replay) -> dict[EvaluationPoint, tuple[np.ndarray, list[np.ndarray]]]:
    """Per evaluation point: times and the arrays (rows, m) that its figures are evaluated on."""
    slosh = [played.slosh_displacement.T, played.slosh_velocity.T]
    end = trajectory.end_time
    t, jerks, tilt = _jerks(trajectory)
    joints = (played.joint_position.T, played.joint_speed.T, played.joint_acceleration.T)
    return {
        EvaluationPoint.OBJECT: (played.t, [played.body, *slosh]),
        EvaluationPoint.JOINT: (played.t, list(joints)),
        EvaluationPoint.CONTROL: (t, [tilt.T, jerks[:, :3].T, jerks[:, 3:].T]),
        EvaluationPoint.END: (np.array([end]), list(_state_at(played, end))),
    }


def _jerks(trajectory: Trajectory) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Third divided differences of s, tilt and joints, at rest outside: means of the jerk over three periods."""
    values = np.column_stack([trajectory.s, trajectory.tilt, trajectory.joint_position])
    padded = np.concatenate([values[:1], values[:1], values, values[-1:], values[-1:]])
    jerks = np.diff(padded, n=3, axis=0) * trajectory.rate**3
    extended = np.concatenate([trajectory.tilt, trajectory.tilt[-1:]])
    t = np.append(trajectory.t, trajectory.t[-1] + 1.0 / trajectory.rate)
    return t, jerks, extended


def _state_at(played: Replay, t: float) -> tuple[np.ndarray, np.ndarray]:
    """Slosh displacement and velocity (k, 1) at a time between grid points, by the cubic through both ends."""
    left = int(np.clip(np.searchsorted(played.t, t, side="right") - 1, 0, len(played.t) - 2))
    width = played.t[left + 1] - played.t[left]
    u = (t - played.t[left]) / width
    q, qd = played.slosh_displacement, played.slosh_velocity
    position = (
        (1 + 2 * u) * (1 - u) ** 2 * q[left]
        + u * (1 - u) ** 2 * width * qd[left]
        + u**2 * (3 - 2 * u) * q[left + 1]
        - u**2 * (1 - u) * width * qd[left + 1]
    )
    speed = (1 - u) * qd[left] + u * qd[left + 1]
    return position[:, None], speed[:, None]


@lru_cache(maxsize=16)
def _figures(structure: Structure, shapes: Shapes) -> codegen.Functions:
    def build() -> tuple[codegen.Functions, None]:
        points = [_figures_function(structure, shapes, point) for point in EvaluationPoint]
        return {function.name(): function for function in points if function is not None}, None

    return codegen.functions("figures", structure, build)[0]


def _figures_function(structure: Structure, shapes: Shapes, point: EvaluationPoint) -> Any | None:
    """(columns of `_inputs`, parameters) -> value, limit, margin of all constraints and subjects of one point.

    None where no constraint has a subject there.
    """
    parameters = SX.sym("p", shapes.size)
    numbers = symbolic(shapes.record, parameters)
    count = coordinate_count(structure)
    q, qd = SX.sym("q", count), SX.sym("qd", count)
    if point is EvaluationPoint.OBJECT:
        body = SX.sym("body", 9)
        tray = body_motion(body)
        slosh = split_states(structure, q, qd, slosh_accelerations(structure, numbers, tray, q, qd))
        sample = Sample(structure, numbers, objects=sample_objects(structure, numbers, tray, slosh))
        inputs = [body, q, qd]
    elif point is EvaluationPoint.END:
        rest = FrameMotion(SX.zeros(3), SX.zeros(3), ca.vertcat(0, 0, numbers.gravity))
        slosh = split_states(structure, q, qd, SX.zeros(count))
        sample = Sample(structure, numbers, objects=sample_objects(structure, numbers, rest, slosh))
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
