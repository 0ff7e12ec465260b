"""Random paths of the campaign, and a base for the arm from which they are in reach, or not.

The search moves the path and not the arm: a turn of the base about the vertical and a shift of it are the same as the
contrary turn and shift of the path, and the kinematics of an arm mounted in one way are built once.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.campaign.distributions import Distributions
from nospill.errors import ScenarioError
from nospill.paths.path import PRESETS, Path
from nospill.robots.joint_paths.following import tray_poses
from nospill.robots.joint_paths.search import joint_paths
from nospill.robots.kinematics.closed_form import inverse_solutions
from nospill.robots.kinematics.redundancy import redundant_joint
from nospill.robots.robot import Robot
from nospill.robots.tool import Tool
from nospill.scenario import scene_from_table

_PATHS, _POSES = 8, 15
_SHRINK = 0.75
_MIDDLE = np.array([0.0, 0.0, 1.0])
_RADIAL, _UPWARD = (0.25, 0.8), (-0.1, 0.7)
_FAR = (1.15, 1.6)


def _direction(random: np.random.Generator) -> np.ndarray:
    """A unit vector (3,); ways over a table climb less than they go sideways."""
    vector = random.normal(size=3) * np.array([1.0, 1.0, 0.6])
    return vector / np.linalg.norm(vector)


def _points(values: np.ndarray) -> list[list[float]]:
    return np.round(values, 5).tolist()


def _wander(random: np.random.Generator, count: int, length: float) -> np.ndarray:
    """Points (count, 3), m, of a way of about `length` m around the middle, turning by less than a right angle each."""
    steps = [_direction(random)]
    while len(steps) < count - 1:
        step = _direction(random)
        if step @ steps[-1] > 0.0:
            steps.append(step)
    lengths = random.uniform(0.5, 1.5, len(steps))
    points = np.concatenate([np.zeros((1, 3)), np.cumsum(lengths[:, None] / lengths.sum() * length * steps, axis=0)])
    return points - points.mean(axis=0) + _MIDDLE


def _line(random: np.random.Generator, length: float) -> dict[str, Any]:
    half = _direction(random) * length / 2
    start, end = _points(np.array([_MIDDLE - half, _MIDDLE + half]))
    return {"type": "line", "start": start, "end": end}


def _arc(random: np.random.Generator, length: float) -> dict[str, Any]:
    angle = random.uniform(math.radians(30.0), math.radians(270.0))
    along = _direction(random)
    across = np.cross(along, _direction(random))
    across /= np.linalg.norm(across)
    phase = np.array([0.0, angle / 2, angle])[:, None]
    circle = length / angle * (np.cos(phase) * along + np.sin(phase) * across)
    start, through, end = _points(circle - circle.mean(axis=0) + _MIDDLE)
    return {"type": "arc", "start": start, "through": through, "end": end}


def _waypoints(random: np.random.Generator, length: float) -> dict[str, Any]:
    return {"type": "waypoints", "points": _points(_wander(random, int(random.integers(3, 8)), length))}


def _bspline(random: np.random.Generator, length: float) -> dict[str, Any]:
    points = _wander(random, int(random.integers(5, 9)), length)
    return {"type": "bspline", "control_points": _points(points), "degree": 4}


def _preset(random: np.random.Generator, length: float) -> dict[str, Any]:
    """A published path, whose length is its own."""
    return {"type": "preset", "name": str(random.choice(list(PRESETS)))}


PATHS: dict[str, Callable[[np.random.Generator, float], dict[str, Any]]] = {
    "line": _line,
    "arc": _arc,
    "waypoints": _waypoints,
    "bspline": _bspline,
    "preset": _preset,
}
"""Kind of path -> the entry of a random one of about a given length in m."""


def reachable_base(table: dict[str, Any], random: np.random.Generator, known: Distributions) -> dict[str, Any] | None:
    """The table with a path and a base from which the level tray follows it; None where none was found."""
    length, kind = known.path_length.draw(random), known.path.draw(random)
    roll = known.mounting.draw(random)
    for _ in range(_PATHS):
        scene_path, robot, drawn = _with_path(table, random, known, kind, length, roll)
        for _ in range(_POSES):
            base, yaw = _base(scene_path, robot, random, roll, _RADIAL)
            moved = _moved(scene_path, base, yaw)
            if _ends_reached(robot, moved, drawn):
                tool = Tool(np.array([0.0, 0.0, drawn["tray"]["offset"]]))
                try:
                    joint_paths(robot, moved, tool=tool)
                except ScenarioError:
                    continue
                return _placed(drawn, base, yaw)
        length *= _SHRINK
        if kind == "preset":
            roll = known.mounting.draw(random)
    return None


def unreachable_base(table: dict[str, Any], random: np.random.Generator, known: Distributions) -> dict[str, Any] | None:
    """The table with a path whose middle is farther from the base than the arm is long."""
    length, kind = known.path_length.draw(random), known.path.draw(random)
    roll = known.mounting.draw(random)
    scene_path, robot, drawn = _with_path(table, random, known, kind, length, roll)
    return _placed(drawn, *_base(scene_path, robot, random, roll, _FAR))


def _with_path(
    table: dict[str, Any], random: np.random.Generator, known: Distributions, kind: str, length: float, roll: float
) -> tuple[Path, Robot, dict[str, Any]]:
    drawn = copy.deepcopy(table)
    turns = known.yaw_values.draw(random)
    end = known.yaw_change.draw(random)
    inner = [known.yaw_change.draw(random) / 2 for _ in range(turns - 2)]
    drawn["path"] = PATHS[kind](random, length) | {"yaw": [f"{value} deg" for value in (0.0, *inner, end)]}
    drawn["robot"]["base_roll"] = f"{roll:g} deg"
    scene = scene_from_table(drawn, name=drawn["name"])
    return scene.path, scene.robot, drawn


def _base(
    path: Path, robot: Robot, random: np.random.Generator, roll: float, radial: tuple[float, float]
) -> tuple[np.ndarray, float]:
    """Position (3,) m and yaw (rad) of a base around which the middle of the path stands at a random place."""
    reach = robot.reach or 1.0
    around, distance, height = random.uniform(-np.pi, np.pi), random.uniform(*radial), random.uniform(*_UPWARD)
    place = reach * np.array([distance * math.cos(around), distance * math.sin(around), height])
    tilted = Rotation.from_euler("x", roll, degrees=True).apply(place)
    yaw = float(np.round(random.uniform(-np.pi, np.pi), 4))
    middle = path.at(np.linspace(0.0, 1.0, 21))[:, :3].mean(axis=0)
    return np.round(middle - _turn(yaw) @ tilted, 4), yaw


def _turn(yaw: float) -> np.ndarray:
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def _moved(path: Path, base: np.ndarray, yaw: float) -> Path:
    """The path as a base at that place sees it."""
    coefficients = path.coefficients.copy()
    coefficients[-1, :, :3] -= base
    coefficients[:, :, :3] = coefficients[:, :, :3] @ _turn(yaw)
    coefficients[-1, :, 3] -= yaw
    return Path(path.breaks, coefficients)


def _ends_reached(robot: Robot, path: Path, table: dict[str, Any]) -> bool:
    """Whether begin, middle and end are in reach within the limits: quick, and sorts out most bases."""
    tool = Tool(np.array([0.0, 0.0, table["tray"]["offset"]]))
    joint = redundant_joint(robot)
    if joint is None:
        choices: list[tuple[int, float] | None] = [None]
    else:
        choices = [(joint, float(value)) for value in np.linspace(robot.lower[joint], robot.upper[joint], 7)[1:-1]]
    for position, rotation in zip(*tray_poses(path, np.array([0.0, 1.0, 0.5])), strict=True):
        if not any(len(inverse_solutions(robot, position, rotation, tool=tool, held=held)) for held in choices):
            return False
    return True


def _placed(table: dict[str, Any], base: np.ndarray, yaw: float) -> dict[str, Any]:
    table["robot"] |= {"base_position": base.tolist(), "base_yaw": yaw}
    return table
