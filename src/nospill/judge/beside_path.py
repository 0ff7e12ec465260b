"""Where on its path the tray is by the record, and how far beside it by the played joints."""

from __future__ import annotations

import numpy as np

from nospill.judge.replay import Replay
from nospill.judge.verdict import Trace
from nospill.laws.constraints.via import PassedPlace
from nospill.motion.interpolation import QUINTIC_SPLINE, JointSamples
from nospill.motion.trajectory import Trajectory
from nospill.scene.scene import Scene


def between_samples(trajectory: Trajectory, played: Replay) -> np.ndarray:
    """Recorded s, theta_x and theta_y (3, m) on the grid of the replay, by the spline that the joints are played by."""
    columns = np.column_stack([trajectory.s, trajectory.tilt])
    return QUINTIC_SPLINE.motion(JointSamples(trajectory.t, columns))(played.t).T


def played_offset(trajectory: Trajectory, scene: Scene, played: Replay) -> tuple[np.ndarray, np.ndarray]:
    """From the path to the tray's centre as the joints carry it, on the replay's grid.

    Returns:
        The offset (m, 3) from the path at the recorded s, m, and that s (m,).
    """
    s = np.clip(between_samples(trajectory, played)[0], 0.0, 1.0)
    return played.tray.position - scene.path.at(s)[:, :3], s


def passing_traces(scene: Scene, played: Replay) -> list[Trace]:
    """Of each place that the tray passes: how near its centre comes, at the one instant when it is nearest."""
    found = []
    for item in scene.motion.via:
        distance = np.linalg.norm(played.tray.position - item.position, axis=1)
        least = int(np.argmin(distance))
        value, limit = distance[least : least + 1], np.array([item.radius])
        at = played.t[least : least + 1]
        found.append(Trace(PassedPlace.name, item.name, PassedPlace.unit, at, value, limit, limit - value))
    return found
