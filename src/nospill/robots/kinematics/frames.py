"""Frames of all moving joints of an arm at many configurations, with their velocities: numbers, sample by sample."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from nospill.core.arrays import cross
from nospill.robots.description.urdf_tree import read_tree
from nospill.robots.kinematics.bodies import BodyChain, chain_bodies
from nospill.robots.kinematics.forward import ArmChain


@dataclass(frozen=True, slots=True)
class JointFrames:
    """Frames fixed to what each of b joints carries (as in `bodies`), the base first, in base axes.

    Attributes:
        position: (b + 1, m, 3) origins, m.
        rotation: (b + 1, m, 3, 3) axes.
        velocity: (b + 1, m, 3) of the origins, m/s.
        angular_velocity: (b + 1, m, 3), rad/s.
    """

    position: np.ndarray
    rotation: np.ndarray
    velocity: np.ndarray
    angular_velocity: np.ndarray


def arm_chain(robot: ArmChain) -> BodyChain:
    """The bodies of an arm; read once per chain."""
    return _chain(robot.urdf, robot.joints, robot.tip)


@lru_cache(maxsize=32)
def _chain(urdf: str, joints: tuple[str, ...], tip: str) -> BodyChain:
    return chain_bodies(read_tree(urdf), joints, tip)


def joint_frames(chain: BodyChain, q: np.ndarray, qd: np.ndarray | None = None) -> JointFrames:
    """The frames at joint positions q (m, n), rad, moving at qd (m, n), rad/s; at rest when left out.

    w' = w + z qd and v' = v + w x r from joint to joint, as in `kinematics.chain`.
    """
    q, qd = chain.angles(q), None if qd is None else chain.rates(qd)
    count, samples = len(chain.bodies), len(q)
    position, velocity, spin = (np.zeros((count + 1, samples, 3)) for _ in range(3))
    rotation = np.empty((count + 1, samples, 3, 3))
    rotation[0] = np.eye(3)
    cosines, sines = np.cos(q).T[:, :, None], np.sin(q).T[:, :, None]
    for index, body in enumerate(chain.bodies):
        step = rotation[index] @ body.position
        position[index + 1] = position[index] + step
        fixed, turned = rotation[index] @ body.rotation, rotation[index + 1]
        x, y, c, s = fixed[:, :, 0], fixed[:, :, 1], cosines[index], sines[index]
        turned[:, :, 0], turned[:, :, 1], turned[:, :, 2] = c * x + s * y, c * y - s * x, fixed[:, :, 2]
        if qd is not None:
            velocity[index + 1] = velocity[index] + cross(spin[index], step)
            spin[index + 1] = spin[index] + fixed[:, :, 2] * qd[:, index, None]
    return JointFrames(position, rotation, velocity, spin)


def axis_reach(chain: BodyChain, joint: int, points: np.ndarray, widening: float) -> np.ndarray:
    """Greatest distance (bodies,), m, of points fixed to a joint's frame from each body's axis, in any configuration.

    Args:
        chain: the arm.
        joint: number of the joints before the frame; axes behind it do not move the points: zero.
        points: (k, 3) in that frame, m.
        widening: radius about each of them, m.

    Returns:
        A bound, for every body's axis: from its own axis exact, from the others the way along the chain.
    """
    reach = np.zeros(len(chain.bodies))
    if joint == 0:
        return reach
    reach[joint - 1] = float(np.max(np.hypot(points[:, 0], points[:, 1]))) + widening
    along = float(np.max(np.linalg.norm(points, axis=1))) + widening
    for index in range(joint - 2, -1, -1):
        step = chain.bodies[index + 1].position
        reach[index] = float(np.hypot(step[0], step[1])) + along
        along += float(np.linalg.norm(step))
    return reach
