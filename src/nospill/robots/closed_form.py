"""All inverse solutions of a six-joint arm, by EAIK's subproblem decomposition polished on our own forward kinematics.

Source: Ostermeier, Kuelz, Althoff, "Automatic geometric decomposition for analytical inverse kinematics", IEEE
RA-L 2025 (EAIK).
EAIK knows neither tool nor limits and mixes least-squares answers in; all three are dealt with here.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np

from nospill.errors import ScenarioError
from nospill.robots.kinematics import FLANGE, Kinematics, ToolPosition, kinematics
from nospill.robots.newton import RESIDUAL, newton
from nospill.robots.robot import Robot

TURN = 2.0 * np.pi
SAME = 1e-6
"""Solutions closer than this in every joint (rad, whole turns removed) are one."""


def inverse_solutions(
    robot: Robot,
    position: np.ndarray,
    rotation: np.ndarray,
    *,
    tool_position: ToolPosition = FLANGE,
    tool_yaw: float = 0.0,
) -> np.ndarray:
    """Return every joint position within the limits that puts the tool at a pose.

    Args:
        robot: an arm of six joints.
        position: (3,) tool origin in the base frame, m.
        rotation: (3, 3) tool axes to base axes.
        tool_position: (3,) tool origin in flange axes, m.
        tool_yaw: turn of the tool about the flange's z, rad.

    Returns:
        (k, 6), rad; k is 0 where there is none. A joint that can turn by more than a full turn gives one row per
        admissible turn, at most one full turn away from the middle of its range.

    Raises:
        ScenarioError: the arm has not six joints, or no closed form is known for its geometry.
    """
    exact = solutions_anywhere(robot, position, rotation, tool_position=tool_position, tool_yaw=tool_yaw)
    rows = [q + TURN * np.array(turns) for q in exact for turns in product(*turn_choices(robot, q, q))]
    return np.array(rows).reshape(-1, len(robot.joints))


def turn_choices(robot: Robot, lowest: np.ndarray, highest: np.ndarray) -> list[list[int]]:
    """Return, per joint, the whole turns that may be added to a motion from `lowest` to `highest` (n,) within limits.

    A joint with a range of several turns is kept within one turn of its middle: farther turns are the same motion
    with less room.
    """
    middle = 0.5 * (robot.lower + robot.upper)
    bottom = np.ceil((np.maximum(robot.lower, middle - TURN) - lowest) / TURN - 1e-12)
    top = np.floor((np.minimum(robot.upper, middle + TURN) - highest) / TURN + 1e-12)
    choices = [list(range(int(low), int(high) + 1)) for low, high in zip(bottom, top, strict=True)]
    # a motion wider than the two turns around the middle may still fit into the limits
    for joint, fitting in enumerate(choices):
        if not fitting:
            turn = round(float((middle - 0.5 * (lowest + highest))[joint] / TURN))
            inside = (
                robot.lower[joint] <= lowest[joint] + TURN * turn and highest[joint] + TURN * turn <= robot.upper[joint]
            )
            choices[joint] = [turn] if inside else []
    return choices


def solutions_anywhere(
    robot: Robot,
    position: np.ndarray,
    rotation: np.ndarray,
    *,
    tool_position: ToolPosition = FLANGE,
    tool_yaw: float = 0.0,
) -> np.ndarray:
    """Return the distinct exact solutions (k, 6) for one pose, limits ignored, every joint in (-pi, pi], rad.

    Raises:
        ScenarioError: the arm has not six joints, or no closed form is known for its geometry.
    """
    arm = kinematics(robot)
    turn = np.array([[np.cos(tool_yaw), -np.sin(tool_yaw), 0], [np.sin(tool_yaw), np.cos(tool_yaw), 0], [0, 0, 1]])
    flange_rotation = np.asarray(rotation, dtype=float) @ turn.T
    flange_position = np.asarray(position, dtype=float) - flange_rotation @ np.asarray(tool_position, dtype=float)
    solver, zero_rotation = _solver(arm, robot.name)
    pose = np.eye(4)
    pose[:3, :3] = flange_rotation @ zero_rotation.T
    pose[:3, 3] = flange_position
    answer = solver.calculate_IK(pose)
    rows = np.array(answer.Q, dtype=float).reshape(-1, arm.n)
    approximate = np.array(answer.is_LS, dtype=bool).reshape(-1)
    start = rows[~approximate & np.isfinite(rows).all(axis=1)]
    polished, error = newton(
        arm,
        np.broadcast_to(flange_position, (len(start), 3)),
        np.broadcast_to(flange_rotation, (len(start), 3, 3)),
        start,
        max_iterations=10,
    )
    return _distinct(_wrap(polished[error < RESIDUAL]))


@lru_cache(maxsize=32)
def _solver(arm: Kinematics, name: str) -> tuple[Any, np.ndarray]:
    """Return EAIK's solver for a chain and the flange's rotation at zero, which EAIK takes as identity."""
    if arm.n != 6:
        raise ScenarioError(f"robot {name!r} has {arm.n} moving joints; all inverse solutions are available for six")
    # imported here: compiled module that only planning needs
    from eaik.pybindings import EAIK

    zero = np.zeros((1, arm.n))
    position, rotation, jacobian = (array[0] for array in arm.poses_and_jacobians(zero))
    axes = jacobian[3:].T
    # v = axis x (p - o): the point o of the axis next to the flange is p + axis x v
    points = position + np.cross(axes, jacobian[:3].T)
    offsets = np.diff(np.vstack([np.zeros(3), points, position]), axis=0)
    try:
        solver = EAIK.Robot(axes.T, offsets.T, np.eye(3), [], True)
        known = solver.has_known_decomposition()
    except RuntimeError as error:
        raise ScenarioError(f"robot {name!r}: no closed form for its geometry ({error})") from error
    if not known:
        raise ScenarioError(f"robot {name!r}: no closed form is known for its geometry")
    return solver, rotation


def _wrap(q: np.ndarray) -> np.ndarray:
    return q - TURN * np.ceil(q / TURN - 0.5)


def _distinct(q: np.ndarray) -> np.ndarray:
    kept: list[np.ndarray] = []
    for row in q:
        if all(np.abs(_wrap(row - other)).max() > SAME for other in kept):
            kept.append(row)
    return np.array(kept).reshape(-1, q.shape[1])
