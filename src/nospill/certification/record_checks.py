"""The record itself: whether it fits the scene, is a motion at all, keeps to the path, and agrees with itself."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike

from nospill.certification.joining import PROGRESS_TOLERANCE, ends_apart, joining_traces
from nospill.certification.path_deviation import between_samples
from nospill.certification.plausibility import require_level, unlikely_units
from nospill.certification.replay import Replay
from nospill.certification.verdict import Trace, limit_trace
from nospill.core.attitudes import angles_between, matrices, tilt_of, tray_quaternions, yaw_of
from nospill.errors import PlanFolderError, ScenarioError
from nospill.laws.constraints.tilt import TILT_ANGLES, Tilt
from nospill.laws.scene_parameters import object_structure
from nospill.motion.trajectory import Trajectory
from nospill.paths.joint_curves import JointCurve
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.robot import Robot
from nospill.scene.cargo import Cargo
from nospill.scene.carriers import with_modes
from nospill.scene.scene import Scene

POSITION_TOLERANCE = 1e-4
"""m; the tray may leave the path by this much."""
ATTITUDE_TOLERANCE = 1e-4
"""rad; the same for its attitude."""
SPEED_TOLERANCE = 1e-3
"""rad/s; recorded joint speeds against the derivative of the recorded positions, and the speed left at both ends."""
REST_SHARE = 5e-3
"""Part of the least joint speed limit with which the played motion may begin and end: the spline through the samples
rings a little into the rest before and after, the more the farther apart they are."""
ACCELERATION_TOLERANCE = 0.5
"""rad/s^2; recorded joint accelerations likewise (the jerk jumps, a spline through samples rounds the corner)."""
SPEED_SHARE, ACCELERATION_SHARE = 0.1, 0.25
"""Both may differ by this part of what the recorded acceleration changes by from sample to sample, times the period
for speeds: a corner of that size is rounded by so much."""
TOLERANCE_RATE = 500.0
"""Hz; where samples are farther apart, the spline rounds more: its derivatives are allowed to differ by the square of
the period for speeds, and by the period for accelerations."""

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


def require_record(trajectory: object, scene: object) -> None:
    """Raise ScenarioError if what is to be judged is no record of a motion, or what it is judged by is no scene."""
    if not isinstance(trajectory, Trajectory):
        shape = f" of shape {np.shape(trajectory)}" if isinstance(trajectory, np.ndarray) else ""
        raise ScenarioError(
            f"certify judges a Trajectory, as plan.trajectory or read_trajectory(file) gives it, not a value of type "
            f"{type(trajectory).__name__}{shape}: for times and joint samples there is certify_joints(t, q, scene)"
        )
    if not isinstance(scene, Scene):
        raise ScenarioError(
            f"certify judges by a Scene, as ns.load(file) gives it, not by a value of type {type(scene).__name__}"
        )


def joint_record(t: ArrayLike, q: ArrayLike, scene: object) -> Trajectory:
    """Times and joint positions as a record, for a scene.

    Raises:
        ScenarioError: no scene; or arrays that are no samples of a motion of its joints.
    """
    if not isinstance(scene, Scene):
        raise ScenarioError(f"certify_joints judges by a Scene, not by a value of type {type(scene).__name__}")
    names = scene.robot.joints
    try:
        times, positions = np.asarray(t, dtype=float), np.asarray(q, dtype=float)
    except (TypeError, ValueError):
        raise ScenarioError(f"t and q are arrays of numbers: (m,) s, (m, {len(names)}) rad") from None
    if times.ndim != 1 or len(times) < 2 or positions.shape != (len(times), len(names)):
        raise ScenarioError(
            f"t has the shape {times.shape} and q {positions.shape}: (m,) and (m, {len(names)}) are needed, m of 2 or "
            f"more and a column for each joint: {', '.join(names)}"
        )
    for name, values in (("t", times), ("q", positions)):
        if not np.all(np.isfinite(values)):
            raise ScenarioError(f"{name} is not a finite number at row {int(np.argwhere(~np.isfinite(values))[0][0])}")
    backwards = np.flatnonzero(np.diff(times) <= 0.0)
    if len(backwards):
        row = int(backwards[0])
        raise ScenarioError(f"t does not increase from {times[row]:g} s at row {row}")
    reason = unlikely_units(times, positions, scene.robot)
    if reason is not None:
        raise ScenarioError(f"t and q: {reason}")
    require_level(positions[0], scene, "t and q")
    motion = Trajectory.of_joints(times, names, positions).motion
    return Trajectory.of_joints(times, names, positions, motion(times, 1), motion(times, 2))


def require_same_joints_and_liquids(trajectory: Trajectory, scene: Scene) -> None:
    """Raise PlanFolderError if the record is of other joints or other liquids than the scene."""
    if trajectory.joints != scene.robot.joints:
        raise PlanFolderError(
            f"trajectory: its joints {', '.join(trajectory.joints)} are not those of the robot "
            f"({', '.join(scene.robot.joints)})"
        )
    wanted = {cargo.name: recorded_coordinates(cargo, scene) for cargo in scene.cargo if cargo.filling}
    found = {name: track.displacement.shape[1] for name, track in trajectory.slosh.items()}
    if found != wanted:
        ours, theirs = (
            ", ".join(f"{name} ({count})" for name, count in names.items()) or "none" for names in (found, wanted)
        )
        raise PlanFolderError(f"trajectory: its liquids (slosh coordinates) are {ours}, those of the scene {theirs}")


def recorded_coordinates(cargo: Cargo, scene: Scene) -> int:
    """Number of slosh coordinates of an object that a record has, of the slowest modes."""
    return object_structure(with_modes(cargo, scene.slosh_modes)).coordinates


def require_motion(trajectory: Trajectory, robot: Robot) -> None:
    """Raise PlanFolderError if the record is no motion.

    That is: columns of different lengths, a value that is no number, time that does not run forward, times or positions
    that are hardly in s and rad, a quaternion of another length than 1.
    """
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
    reason = unlikely_units(trajectory.t, trajectory.joint_position, robot)
    if reason is not None:
        raise PlanFolderError(f"trajectory: {reason}")
    lengths = np.linalg.norm(trajectory.tray_quaternion, axis=1)
    wrong = np.flatnonzero(np.abs(lengths - 1.0) > _QUATERNION_TOLERANCE)
    if len(wrong):
        row = int(wrong[0])
        raise PlanFolderError(f"trajectory: the quaternion at row {row} has length {lengths[row]:.6g}, 1 is needed")


def record_traces(bare: Trajectory, trajectory: Trajectory, scene: Scene, played: Replay) -> list[Trace]:
    """Traces about the record itself: on the path, from end to end, at rest there, columns that agree with each other.

    All are judged on the grid of the replay, between the samples too, except those that compare recorded columns.

    `bare` is the motion without its holds. The samples must come at the rate the controller plays them at,
    `scene.output_rate`.
    """
    per_sample = round(played.rate / trajectory.rate)
    planned = between_samples(trajectory, played)
    speed = np.max(np.abs(played.joint_speed[::per_sample] - trajectory.joint_speed), axis=1)
    acceleration = columns_apart(trajectory.joint_acceleration, played.joint_acceleration, per_sample)
    progress, recorded, ends = ends_apart(bare, played, scene)
    jump = max(SPEED_TOLERANCE, REST_SHARE * float(np.min(scene.robot.max_speed)))
    both = bare.t[[0, -1]]
    uneven = np.abs(np.diff(trajectory.t) * scene.output_rate - 1.0)
    coarser = max(1.0, TOLERANCE_RATE / trajectory.rate)
    step = float(np.max(np.abs(np.diff(trajectory.joint_acceleration, axis=0))))
    speeds = max(SPEED_TOLERANCE * coarser**2, SPEED_SHARE * step / trajectory.rate)
    accelerations = max(ACCELERATION_TOLERANCE * coarser, ACCELERATION_SHARE * step)
    at_samples = slice(None, None, per_sample)
    written = _pose_error(played, trajectory.tray_position, matrices(trajectory.tray_quaternion), at_samples)
    return [
        *(_level_traces(planned, played) if scene.stays_level else []),
        *_path_traces(planned, scene, played),
        *_end_traces(scene, played),
        *(joining_traces(bare, scene, scene.initial_state) if scene.initial_state else ()),
        limit_trace("path covered", "path", "1", PROGRESS_TOLERANCE, both, progress),
        limit_trace("rest at the ends", "joints", "rad/s", SPEED_TOLERANCE, both, recorded),
        limit_trace("rest as played", "joints", "rad/s", jump, both, ends),
        limit_trace("recorded speed", "joints", "rad/s", speeds, trajectory.t, speed),
        limit_trace("recorded acceleration", "joints", "rad/s^2", accelerations, trajectory.t, acceleration),
        limit_trace("recorded position", "tray", "m", POSITION_TOLERANCE, trajectory.t, written[0]),
        limit_trace("recorded attitude", "tray", "rad", ATTITUDE_TOLERANCE, trajectory.t, written[1]),
        limit_trace("even sampling", "time", "1", 1e-6, trajectory.t[1:], uneven),
    ]


def columns_apart(recorded: np.ndarray, played: np.ndarray, per_sample: int) -> np.ndarray:
    """How far each of two accelerations is from all that the other does within a period, at the samples (m,), rad/s^2.

    Within a period of a sample no record says when an acceleration changes, and the spline changes it at a time of its
    own: of a motion that starts with a step it has a part before the first sample, where the record has rest.

    Args:
        recorded: (m, n) at the samples, rad/s^2.
        played: (per_sample (m - 1) + 1, n) likewise, on the grid of the replay.
        per_sample: instants of the replay in a period.
    """

    def outside(values: np.ndarray, other: np.ndarray, reach: int) -> np.ndarray:
        around = sliding_window_view(np.pad(other, ((reach, reach), (0, 0))), 2 * reach + 1, axis=0)[::reach]
        return np.maximum(around.min(axis=-1) - values, values - around.max(axis=-1))

    both = np.maximum(outside(recorded, played, per_sample), outside(played[::per_sample], recorded, 1))
    return np.maximum(np.max(both, axis=1), 0.0)


def _path_traces(planned: np.ndarray, scene: Scene, played: Replay) -> list[Trace]:
    """Traces of the tray that the joints carry on its path, and at the ends of it where it may leave it between them.

    The place on the path is the recorded s, and the attitude there the recorded tilt where the tilt is free; where it
    is fixed, the tray is level whatever the record says. Between the samples both are splines, as the joints are. A yaw
    that is free is the tray's own. A tray that may leave its path has a trace of the table about that.
    `planned` is the record there, `between_samples`.
    """
    if scene.path.joint_curve is not None:
        return _joint_curve_traces(planned[0], scene, scene.path.joint_curve, played)
    rules, (s, theta_x, theta_y) = scene.motion, planned
    pose = scene.path.at(np.clip(s, 0.0, 1.0))
    if not rules.tilt_free:
        theta_x, theta_y = np.zeros_like(s), np.zeros_like(s)
    yaw = yaw_of(played.tray.rotation) if rules.yaw_free else pose[:, 3]
    position, attitude = _pose_error(played, pose[:, :3], matrices(tray_quaternions(yaw, theta_y, theta_x)))
    traces = [limit_trace("path attitude", "tray", "rad", ATTITUDE_TOLERANCE, played.t, attitude)]
    if rules.corridor is None:
        traces.insert(0, limit_trace("path position", "tray", "m", POSITION_TOLERANCE, played.t, position))
    if rules.corridor is None and not rules.yaw_free:
        return traces
    # a motion that goes on from another one begins wherever that one is
    both, s = ([0, -1], [0.0, 1.0]) if scene.initial_state is None else ([-1], [1.0])
    ends, none = scene.path.at(s), np.zeros(len(s))
    error = _pose_error(played, ends[:, :3], matrices(tray_quaternions(ends[:, 3], none, none)), both)
    return [
        *traces,
        limit_trace("goal", "tray", "m", POSITION_TOLERANCE, played.t[both], error[0]),
        limit_trace("goal attitude", "tray", "rad", ATTITUDE_TOLERANCE, played.t[both], error[1]),
    ]


def _joint_curve_traces(s: np.ndarray, scene: Scene, curve: JointCurve, played: Replay) -> list[Trace]:
    """Traces of the joints on a path of theirs, at the recorded s, and of the tray where they carry it there."""
    q = curve.joints(np.clip(s, 0.0, 1.0))
    position, rotation = kinematics(scene.robot).poses(q, tool=scene.tray.tool)
    distance, angle = _pose_error(played, position, rotation)
    joints = np.max(np.abs(played.joint_position - q), axis=1)
    return [
        limit_trace("path position", "tray", "m", POSITION_TOLERANCE, played.t, distance),
        limit_trace("path attitude", "tray", "rad", ATTITUDE_TOLERANCE, played.t, angle),
        limit_trace("path joints", "joints", "rad", ATTITUDE_TOLERANCE, played.t, joints),
    ]


def _end_traces(scene: Scene, played: Replay) -> list[Trace]:
    """The trace of joints that the scenario states for the ends of the motion, where it does."""
    left_open = scene.initial_state is not None, scene.motion.stop
    ends = zip((0, -1), scene.path.ends, left_open, strict=True)
    stated = [(at, q) for at, q, is_open in ends if q is not None and not is_open]
    if not stated:
        return []
    gaps = np.array([np.max(np.abs(played.joint_position[at] - q)) for at, q in stated])
    return [limit_trace("end joints", "joints", "rad", ATTITUDE_TOLERANCE, played.t[[at for at, _ in stated]], gaps)]


def _level_traces(planned: np.ndarray, played: Replay) -> list[Trace]:
    """Traces of both tilt angles of a tray that must not tilt: those the joints make and those of the record."""
    made, (_, *recorded) = tilt_of(played.tray.rotation), planned
    return [
        limit_trace(Tilt.name, name, "rad", ATTITUDE_TOLERANCE, played.t, np.maximum(np.abs(own), np.abs(theirs)))
        for name, own, theirs in zip(TILT_ANGLES, made, recorded, strict=True)
    ]


def tilt_traces(scene: Scene, played: Replay) -> list[Trace]:
    """Traces of both tilt angles that the joints make, where the tilt is free: of a tray that follows its command."""
    if not scene.motion.tilt_free:
        return []
    made, limit = tilt_of(played.tray.rotation), scene.motion.max_tilt
    return [
        limit_trace(Tilt.name, name, "rad", limit, played.t, np.abs(own))
        for name, own in zip(TILT_ANGLES, made, strict=True)
    ]


def _pose_error(
    played: Replay, position: np.ndarray, attitude: np.ndarray, at: slice | list[int] = slice(None)
) -> tuple[np.ndarray, np.ndarray]:
    """Distance (m) and angle (rad) of the tray the joints carry from a given pose, at some instants of the replay."""
    distance = np.linalg.norm(played.tray.position[at] - position, axis=1)
    return distance, angles_between(attitude, played.tray.rotation[at])
