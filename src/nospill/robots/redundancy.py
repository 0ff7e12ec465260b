"""The freedom of a seven-joint arm: which joint stands for it.

With a pose given, one parameter of seven joints is free. We take the position of one joint for it: the six others then
form an ordinary arm with a finite number of solutions, and planner and exporter carry that joint's motion beside the
path's. A good choice leaves the others well conditioned and, where possible, solvable in closed form.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from nospill.robots.closed_form import has_closed_form
from nospill.robots.kinematics import Chain, Kinematics, kinematics

_SAMPLES = 200
_HELD = (0.3, 0.7)


def redundant_joint(robot: Chain) -> int | None:
    """Index of the joint that parametrises the freedom of an arm; None for six joints or fewer.

    Among the joints whose locking leaves a closed form (all joints, where there is none): the one with the largest
    median, over random configurations, of the least singular value of the Jacobian with the joint's own row added.
    """
    return _redundant_joint(robot.urdf, robot.joints, robot.tip)


@lru_cache(maxsize=32)
def _redundant_joint(urdf: str, joints: tuple[str, ...], tip: str) -> int | None:
    if len(joints) <= 6:
        return None
    arm = kinematics(_Chain(urdf, joints, tip))
    solvable = [index for index in range(arm.n) if all(has_closed_form(arm, index, value) for value in _HELD)]
    return max(solvable or range(arm.n), key=lambda index: _conditioning(arm, index))


def _conditioning(arm: Kinematics, index: int) -> float:
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, size=(_SAMPLES, arm.n))
    row = np.zeros((_SAMPLES, 1, arm.n))
    row[:, 0, index] = 1.0
    stacked = np.concatenate([arm.jacobians(q), row], axis=1)
    return float(np.median(np.linalg.svd(stacked, compute_uv=False)[:, -1]))


class _Chain:
    """A chain by its three facts."""

    def __init__(self, urdf: str, joints: tuple[str, ...], tip: str) -> None:
        self.urdf, self.joints, self.tip = urdf, joints, tip
