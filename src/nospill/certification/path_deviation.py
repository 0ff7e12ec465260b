"""Place of the tray on its path, by the record or as the nearest one, and its deviation by the replayed joints."""

from __future__ import annotations

import numpy as np

from nospill.certification.replay import Replay
from nospill.certification.verdict import Trace
from nospill.laws.constraints.via import PassedPlace
from nospill.motion.interpolation import QUINTIC_SPLINE, JointSamples
from nospill.motion.trajectory import Trajectory
from nospill.paths.path import Path
from nospill.scene.scene import Scene

_PIECES = 4000
"""Straight pieces that stand for a path: of an arc of 0.1 m radius and 1 m length they are off by 1e-7 m."""


def between_samples(trajectory: Trajectory, played: Replay) -> np.ndarray:
    """Recorded s, theta_x and theta_y (3, m) on the grid of the replay, by the spline that the joints are played by."""
    columns, rates, changes = (
        np.column_stack([along, tilt])
        for along, tilt in (
            (trajectory.s, trajectory.tilt),
            (trajectory.s_rate, trajectory.tilt_rate),
            (trajectory.s_acceleration, trajectory.tilt_acceleration),
        )
    )
    samples = JointSamples(trajectory.t, columns, rates, changes, in_motion=trajectory.in_motion)
    return QUINTIC_SPLINE.motion(samples)(played.t).T


def played_offset(trajectory: Trajectory, scene: Scene, played: Replay) -> tuple[np.ndarray, np.ndarray]:
    """From the path to the tray's centre as the joints carry it, on the replay's grid.

    Returns:
        The offset (m, 3) from the path at the recorded s, m, and that s (m,); of a record that is of joints alone,
        from the nearest place on it.
    """
    if np.any(trajectory.s):
        s = np.clip(between_samples(trajectory, played)[0], 0.0, 1.0)
    else:
        s = nearest_on(scene.path, played.tray.position)[0]
    return played.tray.position - scene.path.at(s)[:, :3], s


def nearest_on(path: Path, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The place on a path that is nearest to each position (m, 3), m.

    Returns:
        Its path parameter (m,) and the distance to it (m,), m.
    """
    from scipy.spatial import KDTree  # slow to load, and a plan's record has its path parameter

    s = np.linspace(0.0, 1.0, _PIECES + 1)
    corners = path.at(s)[:, :3]
    at = KDTree(corners).query(position)[1]
    nearest, least = s[at], np.linalg.norm(position - corners[at], axis=1)
    for first in (np.maximum(at - 1, 0), np.minimum(at, _PIECES - 1)):  # the pieces on both sides of the corner
        along = corners[first + 1] - corners[first]
        square = np.maximum(np.sum(along**2, axis=1), np.finfo(float).tiny)
        part = np.clip(np.sum((position - corners[first]) * along, axis=1) / square, 0.0, 1.0)
        distance = np.linalg.norm(position - corners[first] - part[:, None] * along, axis=1)
        nearest = np.where(distance < least, (first + part) / _PIECES, nearest)
        least = np.minimum(distance, least)
    return nearest, least


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
