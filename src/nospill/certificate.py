"""The judge: a verdict from the exported trajectory and the scene alone."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from nospill.constraints import CONSTRAINTS
from nospill.constraints.base import Constraint, Place, figures
from nospill.errors import PlanFolderError
from nospill.frames import SX, FrameMotion
from nospill.numbers import Shapes, Structure, flatten, symbolic
from nospill.replay import Replay, body_motion, replay, slosh_accelerations
from nospill.sample import Sample, coordinate_count, sample_objects, split_states
from nospill.scene import Scene
from nospill.scene_numbers import numbers_of, structure_of
from nospill.trajectory import Trajectory

POSITION_TOLERANCE = 1e-4
"""m; the tray may leave the path by this much."""
ATTITUDE_TOLERANCE = 1e-4
"""rad; the same for its attitude."""
SPEED_TOLERANCE = 1e-3
"""rad/s; recorded joint speeds against the derivative of the recorded positions, and the speed left at both ends."""
ACCELERATION_TOLERANCE = 0.5
"""rad/s^2; recorded joint accelerations likewise (the jerk jumps, a spline through samples rounds the corner)."""
PROGRESS_TOLERANCE = 1e-9
"""The path parameter runs from 0 to 1 within this."""


@dataclass(frozen=True, slots=True)
class Row:
    """One constraint and one subject: the instant with the least margin. `ok` is worst_margin >= 0."""

    constraint: str
    subject: str
    unit: str
    limit: float
    worst_value: float
    worst_margin: float
    at_s: float
    ok: bool


@dataclass(frozen=True, slots=True)
class Certificate:
    """All rows; ok when every one is. `grid_hz`: rate of the grid the trajectory was judged on."""

    ok: bool
    grid_hz: float
    rows: tuple[Row, ...]

    @property
    def worst(self) -> Row:
        """The row nearest to its limit, relative to the limit; a broken one before any other."""
        return min(self.rows, key=lambda row: row.worst_margin / max(abs(row.limit), 1e-9))

    def to_dict(self) -> dict[str, Any]:
        """For certificate.json: ok, grid_hz, rows."""
        return {"ok": self.ok, "grid_hz": self.grid_hz, "rows": [asdict(row) for row in self.rows]}


@dataclass(frozen=True, slots=True)
class Trace:
    """One constraint and subject over time: t (m,) s, value, limit and margin (m,) in the constraint's unit."""

    constraint: str
    subject: str
    unit: str
    t: np.ndarray
    value: np.ndarray
    limit: np.ndarray
    margin: np.ndarray


@dataclass(frozen=True, slots=True)
class Judgement:
    """A certificate with what it was read from: traces of every constraint and the dense replay."""

    certificate: Certificate
    traces: tuple[Trace, ...]
    replay: Replay


def certify(trajectory: Trajectory, scene: Scene) -> Certificate:
    """Judge an exported trajectory.

    The joints are played again on a dense grid, the tray's pose and motion recomputed from them, the liquids
    re-integrated from rest; every constraint of the scene is evaluated at every instant.

    Raises:
        ModelError: the liquids cannot be integrated.
        PlanFolderError: the trajectory does not fit the scene (other joints or objects).
    """
    return judge(trajectory, scene).certificate


def judge(trajectory: Trajectory, scene: Scene) -> Judgement:
    """`certify` with its evidence; raises the same."""
    _require_fit(trajectory, scene)
    played = replay(trajectory, scene)
    traces = constraint_traces(trajectory, scene, played)
    rows = [_row(trace) for trace in traces] + _record_rows(trajectory, scene, played)
    return Judgement(Certificate(all(row.ok for row in rows), played.rate, tuple(rows)), traces, played)


def _require_fit(trajectory: Trajectory, scene: Scene) -> None:
    if trajectory.joints != scene.robot.joints:
        raise PlanFolderError(
            f"trajectory: its joints {', '.join(trajectory.joints)} are not those of the robot "
            f"({', '.join(scene.robot.joints)})"
        )


def constraint_traces(trajectory: Trajectory, scene: Scene, played: Replay) -> tuple[Trace, ...]:
    """Every constraint and subject over time, each on the grid it is judged on."""
    structure, numbers = structure_of(scene), numbers_of(scene)
    parameters = ca.DM(flatten(numbers))
    traces = []
    for place, (t, columns) in _inputs(trajectory, played).items():
        constraints = [item for item in CONSTRAINTS if item.place is place and item.subjects(scene)]
        if not constraints:
            continue
        function = _figures_function(structure, Shapes(numbers), place)
        table = np.array(function(*[ca.DM(c) for c in columns], ca.repmat(parameters, 1, len(t))).full())
        table = table.reshape(-1, 3, len(t))
        row = 0
        for constraint in constraints:
            for subject in constraint.subjects(scene):
                value, limit, margin = table[row]
                traces.append(Trace(constraint.name, subject, constraint.unit, t, value, limit, margin))
                row += 1
    order = {constraint.name: index for index, constraint in enumerate(CONSTRAINTS)}
    return tuple(sorted(traces, key=lambda trace: order[trace.constraint]))


def _inputs(trajectory: Trajectory, played: Replay) -> dict[Place, tuple[np.ndarray, list[np.ndarray]]]:
    """Per place: times and the arrays (rows, m) that its figures are evaluated on."""
    slosh = [played.slosh_displacement.T, played.slosh_velocity.T]
    end = trajectory.end_time
    t, jerks, tilt = _jerks(trajectory)
    return {
        Place.OBJECT: (played.t, [played.body, *slosh]),
        Place.JOINT: (played.t, [played.joint_position.T, played.joint_speed.T]),
        Place.CONTROL: (t, [tilt.T, jerks.T]),
        Place.END: (np.array([end]), list(_state_at(played, end))),
    }


def _jerks(trajectory: Trajectory) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Third divided differences of s and tilt, the arm at rest outside: means of the jerk over three periods."""
    values = np.column_stack([trajectory.s, trajectory.tilt])
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


@lru_cache(maxsize=64)
def _figures_function(structure: Structure, shapes: Shapes, place: Place) -> Any:
    """(columns of `_inputs`, parameters) -> value, limit, margin of every constraint and subject of one place."""
    parameters = SX.sym("p", shapes.size)
    numbers = symbolic(shapes.record, parameters)
    count = coordinate_count(structure)
    q, qd = SX.sym("q", count), SX.sym("qd", count)
    if place is Place.OBJECT:
        body = SX.sym("body", 9)
        tray = body_motion(body)
        slosh = split_states(structure, q, qd, slosh_accelerations(structure, numbers, tray, q, qd))
        sample = Sample(structure, numbers, objects=sample_objects(structure, numbers, tray, slosh))
        inputs = [body, q, qd]
    elif place is Place.END:
        rest = FrameMotion(SX.zeros(3), SX.zeros(3), ca.vertcat(0, 0, numbers.gravity))
        slosh = split_states(structure, q, qd, SX.zeros(count))
        sample = Sample(structure, numbers, objects=sample_objects(structure, numbers, rest, slosh))
        inputs = [q, qd]
    elif place is Place.JOINT:
        position, speed = SX.sym("q", len(structure.joints)), SX.sym("qd", len(structure.joints))
        sample = Sample(structure, numbers, joint_position=position, joint_speed=speed)
        inputs = [position, speed]
    else:
        tilt, jerks = SX.sym("tilt", 2), SX.sym("jerks", 3)
        sample = Sample(structure, numbers, tilt=tilt, jerks=jerks)
        inputs = [tilt, jerks]
    stacked = []
    for constraint in CONSTRAINTS:
        if constraint.place is place:
            stacked += [_worst(constraint, budgets) for budgets in constraint.budgets(sample)]
    return ca.Function("figures", [*inputs, parameters], [ca.densify(ca.vertcat(*stacked))], {"cse": True})


def _worst(constraint: Constraint, budgets: tuple[Any, ...]) -> SX:
    """Figures (3, 1) of the budget with the least margin."""
    worst: SX | None = None
    for budget in budgets:
        current = ca.vertcat(*figures(budget, constraint.relative))
        worst = current if worst is None else ca.if_else(current[2] < worst[2], current, worst)
    assert worst is not None
    return worst


def _row(trace: Trace) -> Row:
    # A margin that is not a number is no margin at all.
    margins = np.where(np.isnan(trace.margin), -np.inf, trace.margin)
    index = int(np.argmin(margins))
    margin = float(margins[index])
    return Row(
        constraint=trace.constraint,
        subject=trace.subject,
        unit=trace.unit,
        limit=float(trace.limit[index]),
        worst_value=float(trace.value[index]),
        worst_margin=margin,
        at_s=float(trace.t[index]),
        ok=bool(margin >= 0.0),
    )


def _record_rows(trajectory: Trajectory, scene: Scene, played: Replay) -> list[Row]:
    """Rows about the record itself: on the path, from end to end, at rest there, columns that agree with each other."""
    position, attitude = _path_error(trajectory, scene, played)
    per_sample = round(played.rate / trajectory.rate)
    speed = np.max(np.abs(played.joint_speed[::per_sample] - trajectory.joint_speed), axis=1)
    acceleration = np.max(np.abs(played.joint_acceleration[::per_sample] - trajectory.joint_acceleration), axis=1)
    ends = np.max(np.abs(trajectory.joint_speed[[0, -1]]), axis=1)
    progress = np.abs([trajectory.s[0], trajectory.s[-1] - 1.0])
    both = trajectory.t[[0, -1]]
    uneven = np.abs(np.diff(trajectory.t) * trajectory.rate - 1.0)
    return [
        _limit_row("path position", "tray", "m", POSITION_TOLERANCE, trajectory.t, position),
        _limit_row("path attitude", "tray", "rad", ATTITUDE_TOLERANCE, trajectory.t, attitude),
        _limit_row("path covered", "path", "1", PROGRESS_TOLERANCE, both, progress),
        _limit_row("rest at the ends", "joints", "rad/s", SPEED_TOLERANCE, both, ends),
        _limit_row("recorded speed", "joints", "rad/s", SPEED_TOLERANCE, trajectory.t, speed),
        _limit_row("recorded acceleration", "joints", "rad/s^2", ACCELERATION_TOLERANCE, trajectory.t, acceleration),
        _limit_row("even sampling", "time", "1", 1e-6, trajectory.t[1:], uneven),
    ]


def _limit_row(name: str, subject: str, unit: str, limit: float, t: np.ndarray, values: np.ndarray) -> Row:
    return _row(Trace(name, subject, unit, t, values, np.full(len(values), limit), limit - values))


def _path_error(trajectory: Trajectory, scene: Scene, played: Replay) -> tuple[np.ndarray, np.ndarray]:
    """Distance (m) and angle (rad) of the tray the joints carry from the path at recorded s and tilt, per sample."""
    from scipy.spatial.transform import Rotation

    per_sample = round(played.rate / trajectory.rate)
    planned = scene.path.at(np.clip(trajectory.s, 0.0, 1.0))
    distance = np.linalg.norm(played.tray.position[::per_sample] - planned[:, :3], axis=1)
    # Intrinsic z, y, x: R = Rz(yaw) Ry(theta_y) Rx(theta_x).
    angles = np.column_stack([planned[:, 3], trajectory.tilt[:, 1], trajectory.tilt[:, 0]])
    wanted = Rotation.from_euler("ZYX", angles)
    turn = wanted.inv() * Rotation.from_matrix(played.tray.rotation[::per_sample])
    return distance, turn.magnitude()
