"""The way of a plan as a path of its own: for stops of plans whose tray leaves its path, or turns on it as it likes.

Position and yaw of the tray are quintics between instants 20 ms apart or less, at which value, speed and acceleration
are those that forward kinematics makes of the recorded joints. The path parameter is the plan's time over its duration,
so that the plan itself runs along it evenly, and a stop from an instant begins exactly as the plan moves there. How the
tray tilts is a stop's own matter, as on any path.

What lies beside the way is not used: the tray passes where the plan has passed it, within its corridor and clear of
obstacles but for what it tilts otherwise, which is judged.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nospill.certification.replay import tray_from_joints
from nospill.core.arrays import read_only
from nospill.core.hermite import quintic_hermite
from nospill.core.piecewise import Pieces
from nospill.motion.trajectory import Trajectory
from nospill.paths.path import Path
from nospill.plans.plan import Plan
from nospill.robots.kinematics.yaw_motion import yaw_motion
from nospill.scene.scene import Scene

_SPAN = 0.02
"""s; longest of the pieces."""


def along_own_way(plan: Plan, every: float = _SPAN, at: float | None = None) -> Plan:
    """A plan as one along a path that is its own way; the plan itself where its tray keeps to the path already.

    To compute with, as any scene whose parts are replaced.

    Args:
        plan: certified.
        every: s, between the instants at which its motion has to be that of its record to rounding.
        at: s, one more such instant.
    """
    if not plan.scene.motion.leaves_path:
        return plan
    record = plan.trajectory
    rows = _knots(record, every)
    if at is not None:
        rows = np.union1d(rows, [round((at - record.t[0]) * record.rate)])
    path = _way(plan.scene, record, rows)
    rules = plan.scene.motion.on_path()
    speed = float(np.max(np.linalg.norm(path.derivative(path.breaks)[:, :3], axis=1)))
    # the same jerk in m/s^3 where the way is fastest: its parameter runs evenly in time, not in metres
    rules = replace(rules, path_jerk_limit=rules.path_jerk_limit * plan.scene.path_length / max(speed, 1e-3))
    took = float(record.t[-1] - record.t[0])
    timed = replace(
        record,
        s=(record.t - record.t[0]) / took,
        s_rate=np.full(len(record.t), 1.0 / took),
        s_acceleration=np.zeros(len(record.t)),
    )
    return replace(plan, scene=replace(plan.scene, path=path, motion=rules), trajectory=timed)


def _knots(record: Trajectory, every: float) -> np.ndarray:
    """Rows of the record (k,) at which its motion is kept to rounding: all instants of a stop, and the ends."""
    step = max(1, round(min(every, _SPAN) * record.rate))
    while round(every * record.rate) % step:
        step -= 1
    rows = np.arange(0, len(record.t), step)
    return rows if rows[-1] == len(record.t) - 1 else np.append(rows, len(record.t) - 1)


def _way(scene: Scene, record: Trajectory, rows: np.ndarray) -> Path:
    """The path through the poses of some rows of a record, with the plan's time over its duration as parameter."""
    columns = (record.joint_position, record.joint_speed, record.joint_acceleration)
    motion = tray_from_joints(scene, [column[rows] for column in columns])[0]
    tilt, rate, change = (part[rows] for part in (record.tilt, record.tilt_rate, record.tilt_acceleration))
    yaw, turning, turns = yaw_motion(motion, tilt, rate, change)
    took = float(record.t[-1] - record.t[0])
    breaks = (record.t[rows] - record.t[0]) / took
    breaks[-1] = 1.0
    poses = [
        np.column_stack([motion.position, yaw]),
        took * np.column_stack([motion.velocity, turning]),
        took**2 * np.column_stack([motion.acceleration, turns]),
    ]
    coefficients = _quintics(breaks, poses)
    joints = _quintics(breaks, [took**order * column[rows] for order, column in enumerate(columns)])
    return Path(read_only(breaks), read_only(coefficients), joints=Pieces(read_only(breaks), read_only(joints)))


def _quintics(breaks: np.ndarray, derivatives: list[np.ndarray]) -> np.ndarray:
    """Coefficients of the quintics between breaks (m + 1,) with value and two derivatives (m + 1, k) there."""
    return quintic_hermite(np.diff(breaks)[:, None], *(np.stack([part[:-1], part[1:]]) for part in derivatives))
