"""Joint paths of a seven-joint arm on a grid: path parameter by position of the redundant joint.

A joint path for which the redundant joint stands still, or for which the joints move least, may break a limit where
another one keeps all of them. With the redundant joint at a given position the other six have a closed form, so all
configurations within the limits are known at every place of the grid. Those of neighbouring places that lie close to
each other are joined, and the shortest way through (dynamic programming over the squared joint steps in units of the
speed limits) is smoothed and solved exactly. Within the resolution of the grid the search is complete: where no way
leads through, there is none.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from nospill.paths.path import Path
from nospill.robots.joint_paths.following import MAX_PREDICTION, tray_poses
from nospill.robots.kinematics.closed_form import approximate_solutions, count_turns, with_turns
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.newton import RESIDUAL, Held, newton
from nospill.robots.robot import Robot
from nospill.robots.tool import Tool

PLACES = 51
"""Places of the grid along the path."""
POSITIONS = 241
"""Positions of the redundant joint over its range."""

_FINER = 8
"""An interval of positions at whose ends the number of configurations differs is divided so often: near the edge of the
workspace the redundant joint has a range of a few degrees only."""

_RESERVES = (0.1, 0.03, 0.0)
"""Distances from the joint limits that are tried, rad, the widest first."""
_STIFFNESSES = tuple(10.0**-power for power in range(2, 11))
"""Of the smoothing spline through the way on the grid, the smoothest first."""
_MOST = 4
"""Joint paths that are returned at most."""
_APART = 0.5
"""Largest difference of a joint, rad, from which on two joint paths start apart."""


def paths_on_grid(
    robot: Robot, path: Path, joint: int, s: np.ndarray, *, tool: Tool
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Joint motions within the limits along the path of the level tray, the redundant joint moving as it has to.

    Args:
        robot: the arm.
        path: path of the tray.
        joint: index of the redundant joint, which leaves a closed form to the others.
        s: (m,) increasing path parameters from 0 to 1 of the answer.
        tool: frame carried by the flange.

    Returns:
        For each one q (m, n), rad, exact, and the derivative (m,) of its redundant joint with respect to s, rad; with
        the widest reserve of the joint limits first, then the shortest first. Empty where there is none.
    """
    places = np.linspace(0.0, 1.0, PLACES)
    columns: list[np.ndarray] = []
    for place in places.tolist():
        columns.append(_configurations(robot, path, joint, place, tool))
        if not len(columns[-1]):
            return []
    smooth_paths: list[tuple[np.ndarray, np.ndarray]] = []
    for reserve in _RESERVES:
        inside = [
            column[np.all((column >= robot.lower + reserve) & (column <= robot.upper - reserve), axis=1)]
            for column in columns
        ]
        for way in _shortest_ways(inside, robot.max_speed):
            if all(np.abs(way[0] - q[0]).max() > _APART for q, _ in smooth_paths):
                smooth = _smoothed(robot, path, joint, places, way, s, tool=tool)
                if smooth is not None:
                    smooth_paths.append(smooth)
            if len(smooth_paths) == _MOST:
                return smooth_paths
    return smooth_paths


def _configurations(robot: Robot, path: Path, joint: int, place: float, tool: Tool) -> np.ndarray:
    """All configurations (k, n) within the limits at a place of the path, to the accuracy of the closed form."""
    position, rotation = tray_poses(path, np.array([place]))

    def at(values: np.ndarray) -> list[np.ndarray]:
        poses = np.repeat(position, len(values), axis=0), np.repeat(rotation, len(values), axis=0)
        return approximate_solutions(robot, *poses, tool=tool, held=(joint, values))

    values = np.linspace(robot.lower[joint], robot.upper[joint], POSITIONS)
    configurations = at(values)
    lengths = [len(q) for q in configurations]
    counts = np.bincount(
        np.repeat(np.arange(len(values)), lengths), count_turns(robot, np.concatenate(configurations)), len(values)
    )
    between = [
        np.linspace(low, high, _FINER + 1)[1:-1]
        for (low, some), (high, others) in pairwise(zip(values.tolist(), counts.tolist(), strict=True))
        if some != others
    ]
    if between:
        configurations += at(np.concatenate(between))
    return with_turns(robot, np.concatenate(configurations))


def _shortest_ways(columns: list[np.ndarray], max_speed: np.ndarray) -> list[np.ndarray]:
    """The shortest way (len(columns), n) from each configuration of the first column, the shortest of all first."""
    cost = np.zeros(len(columns[-1]))
    successors: list[np.ndarray] = []
    for here, there in zip(reversed(columns[:-1]), reversed(columns[1:]), strict=True):
        if not len(here) or not len(there):
            return []
        steps = np.abs(here[:, None, :] - there[None, :, :])
        lengths = ((steps / max_speed) ** 2).sum(axis=2)
        lengths[steps.max(axis=2) > MAX_PREDICTION] = np.inf
        total = lengths + cost[None, :]
        best = np.argmin(total, axis=1)
        successors.insert(0, best)
        cost = total[np.arange(len(here)), best]
    ways: list[np.ndarray] = []
    for start in np.argsort(cost, kind="stable"):
        if not np.isfinite(cost[start]):
            break
        chosen = [int(start)]
        for successor in successors:
            chosen.append(int(successor[chosen[-1]]))
        ways.append(np.array([column[index] for column, index in zip(columns, chosen, strict=True)]))
    return ways


def _smoothed(
    robot: Robot, path: Path, joint: int, places: np.ndarray, way: np.ndarray, s: np.ndarray, *, tool: Tool
) -> tuple[np.ndarray, np.ndarray] | None:
    """The smoothest exact motion (m, n) beside a way on the grid that keeps the limits, and its redundant joint's rate.

    None where none does.
    """
    # imported here: slow to import, and needed for few arms and paths
    from scipy.interpolate import make_smoothing_spline

    guess = np.stack([np.interp(s, places, column) for column in way.T], axis=1)
    positions, rotations = tray_poses(path, s)
    direction = np.eye(len(robot.joints))[joint]
    for stiffness in _STIFFNESSES:
        spline = make_smoothing_spline(places, way[:, joint], lam=stiffness)
        held = Held(direction, spline(s))
        q, error = newton(kinematics(robot), positions, rotations, guess, tool=tool, held=held)
        continuous = np.abs(np.diff(q, axis=0)).max() < MAX_PREDICTION and np.abs(q - guess).max() < MAX_PREDICTION
        if error.max() < RESIDUAL and continuous and np.all((q >= robot.lower) & (q <= robot.upper)):
            return q, spline.derivative()(s)
    return None
