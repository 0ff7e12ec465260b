"""Planes that separate two bodies best, fixed to the second of them, from which the optimiser starts.

They touch the second body: so the distance of the first one from its plane is that of the bodies, and at any other
configuration no more than that.
"""

from __future__ import annotations

import numpy as np

from nospill.collisions.bodies import Body
from nospill.collisions.distances import distances_of
from nospill.collisions.pairs import Pair
from nospill.core.attitudes import matrices, tray_quaternions
from nospill.robots.kinematics.frames import JointFrames


def planes(pair: Pair, frames: JointFrames, samples: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The planes that separate a pair best at some of the samples.

    Args:
        pair: both bodies.
        frames: of the arm.
        samples: (m,) of its configurations.

    Returns:
        Unit normals (m, 3) from the first body to the second, and offsets (m,), m, in the frame of the second's joint:
        along its normal every point of the second body is at least the offset; and the distances (m,) of the two, m.
    """
    distance, directions = distances_of(pair.first, pair.second).at(frames, samples)
    normals = (directions[:, None] @ frames.rotation[pair.second.joint][samples])[:, 0]
    return normals, -_support(pair.second, -normals), distance


_TURNS, _TILTS = 72, 3
"""Attitudes at which points are compared: turns, and tilts about either axis."""
_SAME = 1e-9
"""m; points that reach equally far but for this are one."""


def reaching(body: Body, normal: np.ndarray, max_tilt: float) -> np.ndarray:
    """Which points (k,) of a body that turns, and tilts by at most `max_tilt`, rad, reach farthest along a direction.

    Level, all points of one height reach equally far up: one of them is enough, and more would be the same row again.

    Args:
        body: on the tray, whose z is its own.
        normal: (3,) unit vector in the base frame.
        max_tilt: about either axis; 0 for a level tray.
    """
    turns, tilts = np.linspace(0.0, 2.0 * np.pi, _TURNS, endpoint=False), np.linspace(-max_tilt, max_tilt, _TILTS)
    pitch, roll = np.meshgrid(tilts, tilts) if max_tilt else (np.zeros(1), np.zeros(1))
    yaw, pitch, roll = (part.ravel() for part in np.broadcast_arrays(turns[:, None], pitch.ravel(), roll.ravel()))
    directions = normal @ matrices(tray_quaternions(yaw, pitch, roll))
    shape = body.shape
    reach = directions @ shape.points.T + np.sqrt(np.maximum(1.0 - directions[:, 2:] ** 2, 0.0)) * shape.discs
    best = np.isclose(reach, reach.max(axis=1, keepdims=True), rtol=0.0, atol=_SAME)
    return np.unique(np.argmax(best, axis=1))


def _support(body: Body, directions: np.ndarray) -> np.ndarray:
    """Largest coordinate (m,) of a body along unit directions (m, 3) of its joint's frame, m."""
    across = np.linalg.norm(np.cross(directions, body.rotation[:, 2]), axis=1)
    return np.max(directions @ body.points.T + across[:, None] * body.shape.discs, axis=1) + body.shape.ball
