"""How far directions separate bodies, for many bodies, samples and directions at once.

The signed distance of two convex bodies is the largest over all directions n of how far n separates them, so any
direction gives a lower bound. It follows from the bodies' support functions, with points that move on at their speeds.
"""

from __future__ import annotations

import numpy as np

from nospill.collisions.body_arrays import BodyArrays
from nospill.core.arrays import cross
from nospill.robots.kinematics.frames import JointFrames


def separations(
    bodies: BodyArrays,
    sides: np.ndarray,
    frames: JointFrames,
    samples: np.ndarray,
    directions: np.ndarray,
    ahead: np.ndarray,
) -> np.ndarray:
    """How far directions separate two bodies (m,), m, some time later at steady speeds.

    Args:
        bodies: some.
        sides: (2, m) numbers of both of them.
        frames: of the arm.
        samples: (m,) numbers of the configurations.
        directions: (m, 3) unit vectors from the first to the second, base axes.
        ahead: (m,) s.
    """
    both = np.concatenate([directions, -directions])
    reach = _supports(bodies, sides.ravel(), frames, np.tile(samples, 2), both, np.tile(ahead, 2))
    return -np.sum(reach.reshape(2, -1), axis=0)


def _supports(
    bodies: BodyArrays,
    which: np.ndarray,
    frames: JointFrames,
    samples: np.ndarray,
    direction: np.ndarray,
    ahead: np.ndarray,
) -> np.ndarray:
    """Largest coordinate (m,) of bodies along unit directions (m, 3) in base axes, every point moved on by its speed.

    With the frame's velocities v, w, a point r in it moves on by t (v + w x r), so along n it has n (p + t v) + g r
    with g = R^T (n + t n x w); a disc of radius r about a in the frame adds r |g - a (a g)|, a ball its radius.
    """
    joint, later = bodies.joint[which], ahead[:, None]
    pull = direction + later * cross(direction, frames.angular_velocity[joint, samples])
    pull = (pull[:, None] @ frames.rotation[joint, samples])[:, 0]
    base = frames.position[joint, samples] + later * frames.velocity[joint, samples]
    axis = bodies.rotation[which, :, 2]
    across = np.linalg.norm(pull - np.sum(pull * axis, axis=1, keepdims=True) * axis, axis=1)
    reach = np.empty(len(which))
    for number, core in enumerate(bodies.cores):
        own = np.flatnonzero(bodies.core[which] == number)
        place = bodies.place[which[own]]
        values = np.einsum("mkx,mx->mk", core.points[place], pull[own]) + across[own, None] * core.discs[place]
        reach[own] = np.max(values, axis=1)
    return np.sum(direction * base, axis=1) + reach + bodies.ball[which]
