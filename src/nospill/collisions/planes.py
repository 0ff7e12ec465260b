"""Planes that separate two bodies best, fixed to the second of them, from which the optimiser starts.

They touch the second body: so the distance of the first one from its plane is that of the bodies, and at any other
configuration no more than that.
"""

from __future__ import annotations

import numpy as np

from nospill.collisions.bodies import Body
from nospill.collisions.distances import Distances
from nospill.collisions.pairs import Pair
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

    Raises:
        MissingExtraError: the library coal is not installed.
    """
    found, directions = Distances(pair.first, pair.second).at(frames, samples)
    normals = (directions[:, None] @ frames.rotation[pair.second.joint][samples])[:, 0]
    return normals, -_support(pair.second, -normals), found


def _support(body: Body, directions: np.ndarray) -> np.ndarray:
    """Largest coordinate (m,) of a body along unit directions (m, 3) of its joint's frame, m."""
    across = np.linalg.norm(np.cross(directions, body.rotation[:, 2]), axis=1)
    return np.max(directions @ body.points.T + across[:, None] * body.shape.discs, axis=1) + body.shape.ball
