"""Newton's method on many poses at once: joint positions whose tool pose is a given one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.core.batches import evaluate
from nospill.errors import ModelError
from nospill.robots.kinematics.forward import Kinematics, kinematics
from nospill.robots.kinematics.newton_steps import DAMPING, step_functions
from nospill.robots.robot import Robot
from nospill.robots.tool import FLANGE, Tool

RESIDUAL = 1e-11
"""Largest pose error (m and rad, norm of six) that counts as solved."""
ROUNDING = 1e-15
"""Pose error below which a further step brings nothing."""


@dataclass(frozen=True, slots=True)
class Held:
    """A combination of the joints with given values, which takes the freedom of a seventh joint.

    Attributes:
        direction: (n,), for example a unit vector for a joint that is held.
        values: (m,) of direction . q, rad, one for each pose.
    """

    direction: np.ndarray
    values: np.ndarray

    def added(
        self, jacobian: np.ndarray, gap: np.ndarray, q: np.ndarray, samples: np.ndarray | slice = slice(None)
    ) -> tuple[np.ndarray, np.ndarray]:
        """Jacobians (k, 7, n) and gaps (k, 7) with the further row, for the chosen samples at q (k, n)."""
        row = np.broadcast_to(self.direction, (len(q), 1, jacobian.shape[2]))
        missing = self.values[samples] - q @ self.direction
        return np.concatenate([jacobian, row], axis=1), np.concatenate([gap, missing[:, None]], axis=1)


def solve_joints(
    robot: Robot,
    positions: np.ndarray,
    rotations: np.ndarray,
    q_start: np.ndarray,
    *,
    tool: Tool = FLANGE,
    held: Held | None = None,
    max_iterations: int = 30,
) -> np.ndarray:
    """Solve the tool pose for the joint positions at m samples, each from its own guess.

    Newton's method with the least-norm step J^T (J J^T)^-1 e; joint limits are not looked at. Where the arm has more
    joints than the pose has numbers, `held` says what a combination of them shall be; without it the nearest solution
    is taken.

    Args:
        robot: the arm.
        positions: (m, 3) tool origins in the base frame, m.
        rotations: (m, 3, 3) tool axes to base axes.
        q_start: (m, n) guesses, rad.
        tool: frame carried by the flange.
        held: a combination of the joints whose values are given.
        max_iterations: Newton steps before it gives up.

    Returns:
        (m, n) joint positions, rad, with pose errors below `RESIDUAL`.

    Raises:
        ModelError: a sample does not converge; the message names the worst one and its error.
    """
    q, error = newton(
        kinematics(robot),
        positions,
        rotations,
        q_start,
        tool=tool,
        held=held,
        max_iterations=max_iterations,
    )
    if len(q) and not error.max() < RESIDUAL:  # a NaN fails as well
        worst = int(np.nanargmax(np.where(np.isnan(error), np.inf, error)))
        unsolved = int(np.sum(~(error < RESIDUAL)))
        raise ModelError(
            f"robot {robot.name!r}: no joint positions found for {unsolved} of {len(q)} tray poses; worst is sample "
            f"{worst} at {_point(positions[worst])} m with a pose error of {error[worst]:.3g} (m, rad), "
            f"allowed {RESIDUAL:g}; the pose is out of reach or at a singularity"
        )
    return q


def newton(
    arm: Kinematics,
    positions: np.ndarray,
    rotations: np.ndarray,
    q_start: np.ndarray,
    *,
    tool: Tool = FLANGE,
    held: Held | None = None,
    max_iterations: int = 30,
    max_step: float = 0.3,
    enough: float = ROUNDING,
) -> tuple[np.ndarray, np.ndarray]:
    """Iterate as `solve_joints` does, but return what was reached instead of judging it.

    Args:
        arm: forward kinematics.
        positions: (m, 3), m.
        rotations: (m, 3, 3).
        q_start: (m, n), rad.
        tool: frame carried by the flange.
        held: a combination of the joints whose values are given; what it is off counts as pose error.
        max_iterations: Newton steps.
        max_step: largest change of one joint in one step, rad.
        enough: pose error below which no further step is made.

    Returns:
        Joint positions (m, n), rad, and pose errors (m,), the norm of position (m) and rotation (rad) error. A sample
        stops when it is solved and a further step brings nothing, so the answer is as good as rounding allows where
        `enough` asks for that.
    """
    q = np.array(q_start, dtype=float)
    error = np.full(len(q), np.inf)
    active = np.arange(len(q))
    correction, shared = step_functions(arm, held=held is not None)["correction"], arm.shared_of(tool)
    pose, aim = pose_columns(positions, rotations), aim_columns(held, len(q))
    for iteration in range(max_iterations + 1):
        if active.size == 0:
            break
        correction_and_error = evaluate(correction, [q[active].T, pose[:, active], aim[:, active]], shared)
        better = correction_and_error[0] < error[active]
        error[active] = correction_and_error[0]
        if iteration == max_iterations:
            break
        # finished: solved, and the last step brought nothing more
        going = ~((correction_and_error[0] < enough) | ((correction_and_error[0] < RESIDUAL) & ~better))
        active = active[going]
        q[active] += np.clip(correction_and_error[1:, going].T, -max_step, max_step)
    return q, error


def pose_columns(positions: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Poses (12, m), as functions of columns have them, of positions (m, 3) and rotations (m, 3, 3)."""
    return np.concatenate([positions.T, rotations.reshape(-1, 9).T])


def aim_columns(held: Held | None, count: int) -> np.ndarray:
    """What is held of so many samples, as `step_functions` have it."""
    if held is None:
        return np.zeros((0, count))
    return np.concatenate([np.repeat(held.direction[:, None], count, axis=1), held.values[None]])


def least_norm_step(jacobian: np.ndarray, gap: np.ndarray) -> np.ndarray:
    """Return the shortest joint changes (m, n) whose first-order effect is the gaps (m, k); jacobian is (m, k, n)."""
    transposed = np.swapaxes(jacobian, 1, 2)
    gram = jacobian @ transposed + DAMPING * np.eye(jacobian.shape[1])
    return (transposed @ np.linalg.solve(gram, gap[..., None]))[..., 0]


def _point(position: np.ndarray) -> str:
    return "(" + ", ".join(f"{value:.4f}" for value in position) + ")"
