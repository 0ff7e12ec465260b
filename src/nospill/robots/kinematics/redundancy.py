"""The freedom of a seven-joint arm: a number that stands for it.

With a pose given, one parameter of seven joints is free. To find solutions one joint is held: the six others then form
an ordinary arm. To carry a motion, planner and exporter use the value of a combination of the joints, direction . q: it
parametrises the self-motion as long as the null vector of the Jacobian is not orthogonal to the direction; so the
direction is taken whose least product with the null vectors along the way is greatest. A single joint would do it too,
but every joint has places within the workspace where the self-motion leaves it at rest, and there a motion would have a
singularity that the arm does not have.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from nospill.robots.kinematics.closed_form import has_closed_form
from nospill.robots.kinematics.forward import ArmChain, Kinematics, kinematics
from nospill.robots.robot import Robot

_SAMPLES = 200
_HELD_POSITIONS = 13
_LONGEST = 1e3
"""Of a vector with products of 1 or more with unit vectors: where it is longer, no direction is on one side of them."""


def redundant_joint(robot: ArmChain) -> int | None:
    """Index of the joint that is held when solutions are looked for; None for six joints or fewer.

    Among the joints whose locking leaves a closed form (all joints, where there is none): the one with the largest
    median, over random configurations, of the least singular value of the Jacobian with the joint's own row added.
    """
    return _redundant_joint(robot.urdf, robot.joints, robot.tip)


def held_positions(robot: Robot, joint: int) -> np.ndarray:
    """Positions (k,), rad, of a redundant joint that are tried, evenly over its range."""
    inside = np.linspace(0.0, 1.0, _HELD_POSITIONS + 2)[1:-1]
    return robot.lower[joint] + inside * (robot.upper[joint] - robot.lower[joint])


@lru_cache(maxsize=32)
def _redundant_joint(urdf: str, joints: tuple[str, ...], tip: str) -> int | None:
    if len(joints) <= 6:
        return None
    arm = kinematics(_NamedChain(urdf, joints, tip))
    solvable = [index for index in range(arm.n) if has_closed_form(arm, index)]
    return max(solvable or range(arm.n), key=lambda index: _conditioning(arm, index))


def _conditioning(arm: Kinematics, index: int) -> float:
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, size=(_SAMPLES, arm.n))
    row = np.zeros((_SAMPLES, 1, arm.n))
    row[:, 0, index] = 1.0
    stacked = np.concatenate([arm.jacobians(q), row], axis=1)
    return float(np.median(np.linalg.svd(stacked, compute_uv=False)[:, -1]))


def self_motion(robot: ArmChain, q: np.ndarray) -> np.ndarray:
    """Direction (n,) whose least product with the self-motion along joint positions (m, n) is greatest; seven joints.

    The null vectors' mean where no direction has a product of one sign with all of them.
    """
    jacobians = kinematics(robot).jacobians(q)
    vectors = np.linalg.svd(jacobians, full_matrices=True)[2][:, -1, :]
    turned = np.where(np.einsum("ij,ij->i", vectors[1:], vectors[:-1]) < 0, -1.0, 1.0)
    vectors *= np.concatenate([[1.0], np.cumprod(turned)])[:, None]
    return widest_direction(vectors)


def widest_direction(vectors: np.ndarray) -> np.ndarray:
    """Unit vector (n,) whose least product with vectors (m, n) is greatest; along their mean where none is above zero.

    It is the direction of the shortest vector whose products with all of them are 1 or more: a quadratic programme, as
    for the hyperplane of maximum margin.
    """
    count, size = vectors.shape
    sparsity = {"h": ca.Sparsity.diag(size), "a": ca.Sparsity.dense(count, size)}
    shortest = ca.conic("direction", "daqp", sparsity, {"error_on_fail": False})
    solution = shortest(h=ca.DM.eye(size), a=vectors, lba=1.0, uba=np.inf)
    direction = np.asarray(solution["x"]).ravel()
    if not shortest.stats()["success"] or np.linalg.norm(direction) > _LONGEST:
        direction = vectors.mean(axis=0)
    return direction / np.linalg.norm(direction)


class _NamedChain:
    """A chain by its three facts."""

    def __init__(self, urdf: str, joints: tuple[str, ...], tip: str) -> None:
        self.urdf, self.joints, self.tip = urdf, joints, tip
