"""The judge: a verdict from the exported trajectory and the scene alone."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
from scipy.spatial.transform import Rotation

from nospill import compiled
from nospill.batches import evaluate
from nospill.constraints import CONSTRAINTS
from nospill.constraints.base import Constraint, Place, figures
from nospill.constraints.joint_torque import JointTorque
from nospill.errors import PlanFolderError
from nospill.frames import SX, FrameMotion
from nospill.holds import held_trajectory
from nospill.interpolation import JointMotion
from nospill.numbers import Shapes, Structure, flatten, symbolic
from nospill.replay import MINIMUM_RATE, Replay, body_motion, replay, slosh_accelerations
from nospill.sample import Sample, coordinate_count, sample_objects, split_states
from nospill.scene import Scene
from nospill.scene_numbers import numbers_of, structure_of
from nospill.tolerances import corner_scenes, heaviest, lightest, spread_name
from nospill.trajectory import Trajectory

POSITION_TOLERANCE = 1e-4
"""m; the tray may leave the path by this much."""
ATTITUDE_TOLERANCE = 1e-4
"""rad; the same for its attitude."""
SPEED_TOLERANCE = 1e-3
"""rad/s; recorded joint speeds against the derivative of the recorded positions, and the speed left at both ends."""
ACCELERATION_TOLERANCE = 0.5
"""rad/s^2; recorded joint accelerations likewise (the jerk jumps, a spline through samples rounds the corner)."""
SPEED_SHARE, ACCELERATION_SHARE = 0.1, 0.25
"""Both may differ by this part of what the recorded acceleration changes by from sample to sample, times the period
for speeds: a corner of that size is rounded by so much."""
TOLERANCE_RATE = 500.0
"""Hz; where samples are farther apart, the spline rounds more: its derivatives are allowed to differ by the square of
the period for speeds, and by the period for accelerations."""
PROGRESS_TOLERANCE = 1e-9
"""The path parameter runs from 0 to 1 within this."""

_QUATERNION_TOLERANCE = 1e-6
_COLUMNS = (
    "t",
    "s",
    "s_rate",
    "tilt",
    "joint_position",
    "joint_speed",
    "joint_acceleration",
    "tray_position",
    "tray_quaternion",
)
"""What the judge reads of a trajectory."""


APPROACH = "approach "
"""What the constraints of the rows about the approach begin with."""

_LEAST_SIZE = {"joint position": np.pi, "lift": 1.0, "apparent gravity": 1.0}
"""By constraint, what a margin is measured by at least where the limit's distance from zero says nothing: half a turn
of a joint, one weight, one gravity."""


def limit_use(constraint: str, limit: np.ndarray | float, margin: np.ndarray | float) -> np.ndarray:
    """Use of a limit, 1 - margin/size: 1 at the limit, more where it is broken.

    The size is that of the limit itself. A joint's zero may lie anywhere in its range, so the size is half a turn at
    least; a limit of zero counts as one of its unit (lift: one weight). A margin that is no number is infinite use.

    Args:
        constraint: its name.
        limit: (m,) or one number, in the constraint's unit.
        margin: likewise.
    """
    size = np.maximum(np.abs(limit), _LEAST_SIZE.get(constraint.removeprefix(APPROACH), 0.0))
    use = 1.0 - np.asarray(margin) / np.where(size > 0.0, size, 1.0)
    return np.where(np.isnan(use), np.inf, use)


@dataclass(frozen=True, slots=True)
class Row:
    """One constraint and one subject: the instant with the least margin. `ok` is worst_margin >= 0.

    `variant` says with which numbers, where those of the subject may be off and others than the stated ones are worst.
    """

    constraint: str
    subject: str
    unit: str
    limit: float
    worst_value: float
    worst_margin: float
    at_s: float
    ok: bool
    variant: str = ""

    @property
    def who(self) -> str:
        """The subject, with its variant."""
        return spread_name(self.subject, self.variant)

    @property
    def use(self) -> float:
        """`limit_use` at that instant."""
        return float(limit_use(self.constraint, self.limit, self.worst_margin))


def _urgency(row: Row) -> tuple[bool, float]:
    return not row.ok, row.use


@dataclass(frozen=True, slots=True)
class Certificate:
    """All rows; ok when every one is. `grid_hz`: rate of the grid the trajectory was judged on."""

    ok: bool
    grid_hz: float
    rows: tuple[Row, ...]

    @property
    def worst(self) -> Row:
        """The row that uses most of its limit (`limit_use`); a broken one before any other."""
        return max(self.rows, key=_urgency)

    def worst_rows(self) -> tuple[Row, ...]:
        """The same within each constraint, in the order of the rows."""
        families: dict[str, list[Row]] = {}
        for row in self.rows:
            families.setdefault(row.constraint, []).append(row)
        return tuple(max(family, key=_urgency) for family in families.values())

    def joined(self, other: Certificate) -> Certificate:
        """This verdict with the rows of another one, about another segment, behind its own."""
        return Certificate(self.ok and other.ok, min(self.grid_hz, other.grid_hz), self.rows + other.rows)

    def to_dict(self) -> dict[str, Any]:
        """For certificate.json: ok, grid_hz, rows."""
        return {"ok": self.ok, "grid_hz": self.grid_hz, "rows": [_plain(row) for row in self.rows]}


def _plain(row: Row) -> dict[str, Any]:
    """A row as it is written; a variant only where there is one."""
    table = asdict(row)
    return table if row.variant else {key: value for key, value in table.items() if key != "variant"}


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

    @property
    def use(self) -> np.ndarray:
        """`limit_use` over time, shape (m,)."""
        return limit_use(self.constraint, self.limit, self.margin)


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
    trajectory: Trajectory, scene: Scene, *, motion: JointMotion | None = None, rate: float = MINIMUM_RATE
) -> Judgement:
    """`certify` with its evidence; the same arguments and errors."""
    _require_fit(trajectory, scene)
    _require_motion(trajectory)
    held = held_trajectory(trajectory, scene.motion)
    played = replay(held, scene, motion=motion, rate=rate)
    traces = constraint_traces(held, scene, played)
    corners = corner_rows(held, scene, motion=motion, rate=rate, played=played)
    rows = [*condensed([*map(worst_row, traces), *corners]), *_record_rows(trajectory, held, scene, played)]
    return Judgement(Certificate(all(row.ok for row in rows), played.rate, tuple(rows)), traces, played, corners)


def _require_fit(trajectory: Trajectory, scene: Scene) -> None:
    if trajectory.joints != scene.robot.joints:
        raise PlanFolderError(
            f"trajectory: its joints {', '.join(trajectory.joints)} are not those of the robot "
            f"({', '.join(scene.robot.joints)})"
        )
    items = zip(scene.cargo, structure_of(scene).objects, strict=True)
    wanted = {cargo.name: item.coordinates for cargo, item in items if item.coordinates}
    found = {name: track.displacement.shape[1] for name, track in trajectory.slosh.items()}
    if found != wanted:
        ours, theirs = (
            ", ".join(f"{name} ({count})" for name, count in names.items()) or "none" for names in (found, wanted)
        )
        raise PlanFolderError(f"trajectory: its liquids (slosh coordinates) are {ours}, those of the scene {theirs}")


def _require_motion(trajectory: Trajectory) -> None:
    for name in _COLUMNS:
        values = getattr(trajectory, name)
        if len(values) != len(trajectory.t):
            raise PlanFolderError(f"trajectory: {len(values)} rows of {name}, {len(trajectory.t)} of t")
        if not np.all(np.isfinite(values)):
            row = int(np.argwhere(~np.isfinite(values))[0][0])
            raise PlanFolderError(f"trajectory: {name} is not a finite number at row {row}")
    if len(trajectory.t) < 2:
        raise PlanFolderError(f"trajectory: {len(trajectory.t)} instants, at least 2 are needed")
    backwards = np.flatnonzero(np.diff(trajectory.t) <= 0.0)
    if len(backwards):
        row = int(backwards[0])
        raise PlanFolderError(f"trajectory: t does not increase from {trajectory.t[row]:g} s at row {row}")
    lengths = np.linalg.norm(trajectory.tray_quaternion, axis=1)
    wrong = np.flatnonzero(np.abs(lengths - 1.0) > _QUATERNION_TOLERANCE)
    if len(wrong):
        row = int(wrong[0])
        raise PlanFolderError(f"trajectory: the quaternion at row {row} has length {lengths[row]:.6g}, 1 is needed")


def constraint_traces(
    trajectory: Trajectory, scene: Scene, played: Replay, *, places: Collection[Place] = tuple(Place)
) -> tuple[Trace, ...]:
    """Every constraint of some places and its subjects over time, each on the grid it is judged on."""
    structure, numbers = structure_of(scene), numbers_of(scene)
    parameters = flatten(numbers)
    traces = []
    for place, (t, columns) in _inputs(trajectory, played).items():
        constraints = [item for item in CONSTRAINTS if item.place is place and item.subjects(scene)]
        if not constraints or place not in places:
            continue
        function = _figures(structure, Shapes(numbers))[f"figures_{place.value}"]
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
        for trace in constraint_traces(trajectory, corner.scene, own, places=(Place.OBJECT, Place.END)):
            if trace.subject in corner.texts:
                rows.append(replace(worst_row(trace), variant=corner.texts[trace.subject]))
    if rows and played is not None:
        for text, load in (("the heaviest load", heaviest(scene)), ("the lightest load", lightest(scene))):
            loaded = constraint_traces(trajectory, replace(scene, cargo=load), played, places=(Place.JOINT,))
            rows += [
                replace(worst_row(trace), variant=text) for trace in loaded if trace.constraint == JointTorque.name
            ]
    return tuple(rows)


def condensed(rows: Iterable[Row]) -> tuple[Row, ...]:
    """Of every constraint and subject the row that uses most of its limit, in the order of their first rows."""
    families: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        families.setdefault((row.constraint, row.subject), []).append(row)
    return tuple(max(family, key=_urgency) for family in families.values())


def _inputs(trajectory: Trajectory, played: Replay) -> dict[Place, tuple[np.ndarray, list[np.ndarray]]]:
    """Per place: times and the arrays (rows, m) that its figures are evaluated on."""
    slosh = [played.slosh_displacement.T, played.slosh_velocity.T]
    end = trajectory.end_time
    t, jerks, tilt = _jerks(trajectory)
    joints = (played.joint_position.T, played.joint_speed.T, played.joint_acceleration.T)
    return {
        Place.OBJECT: (played.t, [played.body, *slosh]),
        Place.JOINT: (played.t, list(joints)),
        Place.CONTROL: (t, [tilt.T, jerks[:, :3].T, jerks[:, 3:].T]),
        Place.END: (np.array([end]), list(_state_at(played, end))),
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
def _figures(structure: Structure, shapes: Shapes) -> compiled.Functions:
    def build() -> tuple[compiled.Functions, None]:
        places = [_figures_function(structure, shapes, place) for place in Place]
        return {function.name(): function for function in places if function is not None}, None

    return compiled.functions("figures", structure, build)[0]


def _figures_function(structure: Structure, shapes: Shapes, place: Place) -> Any | None:
    """(columns of `_inputs`, parameters) -> value, limit, margin of every constraint and subject of one place.

    None where no constraint has a subject there.
    """
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
        inputs = [SX.sym(name, len(structure.joints)) for name in ("q", "qd", "qdd")]
        sample = Sample(
            structure, numbers, joint_position=inputs[0], joint_speed=inputs[1], joint_acceleration=inputs[2]
        )
    else:
        inputs = [SX.sym("tilt", 2), SX.sym("jerks", 3), SX.sym("joint_jerk", len(structure.joints))]
        sample = Sample(structure, numbers, tilt=inputs[0], jerks=inputs[1], joint_jerk=inputs[2])
    stacked = []
    for constraint in CONSTRAINTS:
        if constraint.place is place:
            stacked += [_worst(constraint, budgets) for budgets in constraint.budgets(sample)]
    if not stacked:
        return None
    return ca.Function(
        f"figures_{place.value}", [*inputs, parameters], [ca.densify(ca.vertcat(*stacked))], {"cse": True}
    )


def _worst(constraint: Constraint, budgets: tuple[Any, ...]) -> SX:
    """Figures (3, 1) of the budget with the least margin."""
    worst: SX | None = None
    for budget in budgets:
        current = ca.vertcat(*figures(budget, constraint.relative))
        worst = current if worst is None else ca.if_else(current[2] < worst[2], current, worst)
    assert worst is not None
    return worst


def worst_row(trace: Trace) -> Row:
    """The instant of a trace with the least margin."""
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


def _record_rows(bare: Trajectory, trajectory: Trajectory, scene: Scene, played: Replay) -> list[Row]:
    """Rows about the record itself: on the path, from end to end, at rest there, columns that agree with each other.

    `bare` is the motion without its holds. The samples must come at the rate the controller plays them at,
    `scene.output_rate`.
    """
    per_sample = round(played.rate / trajectory.rate)
    position, attitude = _path_error(trajectory, scene, played, per_sample)
    speed = np.max(np.abs(played.joint_speed[::per_sample] - trajectory.joint_speed), axis=1)
    acceleration = np.max(np.abs(played.joint_acceleration[::per_sample] - trajectory.joint_acceleration), axis=1)
    ends = np.max(np.abs(bare.joint_speed[[0, -1]]), axis=1)
    progress = np.abs([bare.s[0], bare.s[-1] - 1.0])
    both = bare.t[[0, -1]]
    uneven = np.abs(np.diff(trajectory.t) * scene.output_rate - 1.0)
    coarser = max(1.0, TOLERANCE_RATE / trajectory.rate)
    step = float(np.max(np.abs(np.diff(trajectory.joint_acceleration, axis=0))))
    speeds = max(SPEED_TOLERANCE * coarser**2, SPEED_SHARE * step / trajectory.rate)
    accelerations = max(ACCELERATION_TOLERANCE * coarser, ACCELERATION_SHARE * step)
    written = _pose_error(played, per_sample, trajectory.tray_position, Rotation.from_quat(trajectory.tray_quaternion))
    return [
        limit_row("path position", "tray", "m", POSITION_TOLERANCE, trajectory.t, position),
        limit_row("path attitude", "tray", "rad", ATTITUDE_TOLERANCE, trajectory.t, attitude),
        limit_row("path covered", "path", "1", PROGRESS_TOLERANCE, both, progress),
        limit_row("rest at the ends", "joints", "rad/s", SPEED_TOLERANCE, both, ends),
        limit_row("recorded speed", "joints", "rad/s", speeds, trajectory.t, speed),
        limit_row("recorded acceleration", "joints", "rad/s^2", accelerations, trajectory.t, acceleration),
        limit_row("recorded position", "tray", "m", POSITION_TOLERANCE, trajectory.t, written[0]),
        limit_row("recorded attitude", "tray", "rad", ATTITUDE_TOLERANCE, trajectory.t, written[1]),
        limit_row("even sampling", "time", "1", 1e-6, trajectory.t[1:], uneven),
    ]


def limit_row(name: str, subject: str, unit: str, limit: float, t: np.ndarray, values: np.ndarray) -> Row:
    """The row of values (m,), none below zero, against one limit."""
    return worst_row(Trace(name, subject, unit, t, values, np.full(len(values), limit), limit - values))


def _path_error(trajectory: Trajectory, scene: Scene, played: Replay, per_sample: int) -> tuple[np.ndarray, np.ndarray]:
    """Distance (m) and angle (rad) of the tray the joints carry from the path at recorded s and tilt, per sample."""
    planned = scene.path.at(np.clip(trajectory.s, 0.0, 1.0))
    # Intrinsic z, y, x: R = Rz(yaw) Ry(theta_y) Rx(theta_x).
    angles = np.column_stack([planned[:, 3], trajectory.tilt[:, 1], trajectory.tilt[:, 0]])
    return _pose_error(played, per_sample, planned[:, :3], Rotation.from_euler("ZYX", angles))


def _pose_error(
    played: Replay, per_sample: int, position: np.ndarray, attitude: Rotation
) -> tuple[np.ndarray, np.ndarray]:
    """Distance (m) and angle (rad) of the tray the joints carry from a given pose, per sample."""
    distance = np.linalg.norm(played.tray.position[::per_sample] - position, axis=1)
    turn = attitude.inv() * Rotation.from_matrix(played.tray.rotation[::per_sample])
    return distance, turn.magnitude()
