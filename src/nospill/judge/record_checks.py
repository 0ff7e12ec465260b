"""The record itself: whether it fits the scene, is a motion at all, keeps to the path, and agrees with itself."""

from __future__ import annotations

import numpy as np

from nospill.core.attitudes import angles_between, matrices, tray_quaternions
from nospill.errors import PlanFolderError
from nospill.judge.replay import Replay
from nospill.judge.verdict import Row, limit_row
from nospill.laws.scene_parameters import structure_of
from nospill.motion.trajectory import Trajectory
from nospill.scene.scene import Scene

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


def require_same_joints_and_liquids(trajectory: Trajectory, scene: Scene) -> None:
    """Raise PlanFolderError if the record is of other joints or other liquids than the scene."""
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


def require_motion(trajectory: Trajectory) -> None:
    """Raise PlanFolderError if the record is no motion.

    That is: columns of different lengths, a value that is no number, time that does not run forward, a quaternion of
    another length than 1.
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
    lengths = np.linalg.norm(trajectory.tray_quaternion, axis=1)
    wrong = np.flatnonzero(np.abs(lengths - 1.0) > _QUATERNION_TOLERANCE)
    if len(wrong):
        row = int(wrong[0])
        raise PlanFolderError(f"trajectory: the quaternion at row {row} has length {lengths[row]:.6g}, 1 is needed")


def record_rows(bare: Trajectory, trajectory: Trajectory, scene: Scene, played: Replay) -> list[Row]:
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
    written = _pose_error(played, per_sample, trajectory.tray_position, matrices(trajectory.tray_quaternion))
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


def _path_error(trajectory: Trajectory, scene: Scene, played: Replay, per_sample: int) -> tuple[np.ndarray, np.ndarray]:
    """Distance (m) and angle (rad) of the tray the joints carry from the path at recorded s and tilt, per sample."""
    planned = scene.path.at(np.clip(trajectory.s, 0.0, 1.0))
    attitude = matrices(tray_quaternions(planned[:, 3], trajectory.tilt[:, 1], trajectory.tilt[:, 0]))
    return _pose_error(played, per_sample, planned[:, :3], attitude)


def _pose_error(
    played: Replay, per_sample: int, position: np.ndarray, attitude: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Distance (m) and angle (rad) of the tray the joints carry from a given pose, per sample."""
    distance = np.linalg.norm(played.tray.position[::per_sample] - position, axis=1)
    return distance, angles_between(attitude, played.tray.rotation[::per_sample])
