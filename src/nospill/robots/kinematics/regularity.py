"""How far an arm is from a singularity, as one number with a sign: the determinant of its Jacobian.

Along a motion that keeps its branch the determinant keeps its sign: two inverse solutions meet and change places where
it is zero. An optimiser that sees single instants only could hop from one branch to the other there, or drive through
the edge of the workspace. With seven joints the row of the free parameter (see `redundancy`) makes the matrix square.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from nospill.core.frames import SX
from nospill.robots.kinematics.forward import ArmChain, kinematics

_LEAST_SHARE = 1e-3
"""A determinant this much smaller than along the rest of the motion counts as zero."""


_CLEARANCE = 0.05
"""Share of the typical determinant that a motion keeps."""


def determinant_expression(chain: ArmChain, q: SX, self_motion: SX) -> SX:
    """Determinant of the geometric Jacobian at the flange, with the row `self_motion` (n,) for seven joints; q (n,)."""
    arm = kinematics(chain)
    jacobian = arm.jacobian(q)
    return _determinant(jacobian if arm.n == jacobian.shape[0] else ca.vertcat(jacobian, self_motion.T))


def determinants(robot: ArmChain, q: np.ndarray, self_motion: np.ndarray | None) -> np.ndarray:
    """The same at samples q (m, n), rad: shape (m,)."""
    jacobians = kinematics(robot).jacobians(q)
    if self_motion is not None:
        row = np.broadcast_to(self_motion, (len(q), 1, q.shape[1]))
        jacobians = np.concatenate([jacobians, row], axis=1)
    return np.linalg.det(jacobians)


def keeps_branch(values: np.ndarray) -> bool:
    """Whether determinants (m,) along a motion keep their sign and stay clear of zero."""
    turned = values * np.sign(np.median(values))
    return bool(turned.min() > _LEAST_SHARE * np.median(turned))


def clearance(values: np.ndarray) -> float:
    """What the determinant has to stay beyond, sign included, for determinants (m,) along the level tray's path.

    A share of what it typically is, or less where the path itself goes nearer to a singularity.
    """
    typical = float(np.median(values))
    nearest = float(np.min(values * np.sign(typical)))
    return float(np.sign(typical)) * min(_CLEARANCE * abs(typical), 0.5 * max(nearest, _LEAST_SHARE * abs(typical)))


def _determinant(matrix: SX) -> SX:
    """Laplace expansion that computes every minor once: no divisions, so no pivot can vanish."""
    size = matrix.shape[0]

    @cache
    def minor(row: int, columns: tuple[int, ...]) -> Any:
        if row == size - 1:
            return matrix[row, columns[0]]
        total = SX(0)
        for place, column in enumerate(columns):
            entry = matrix[row, column]
            if not entry.is_zero():
                rest = minor(row + 1, columns[:place] + columns[place + 1 :])
                total = total + (-1) ** place * entry * rest
        return total

    return minor(0, tuple(range(size)))
