"""`[path] type = "free"`: the ways along which a motion from here to there is looked for."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from itertools import product

import numpy as np

from nospill.errors import ScenarioError
from nospill.robots.description.urdf import base_pose
from nospill.robots.joint_paths.search import try_joint_paths
from nospill.robots.kinematics.redundancy import redundant_joint
from nospill.scenario.reader import scene_from_table
from nospill.scene.scene import Scene

_POINTS = 13
"""Of an arc about the base."""
_NEAR_THE_AXIS = 0.05
"""m; nearer to the base's axis there is no direction to turn from."""
_NEARER = (0.0, -0.1, -0.2, -0.3, 0.15)
_HIGHER = (0.0, 0.2, 0.4, -0.2)
"""How much farther from the axis, and higher, detours are half way, in parts of the arm's reach."""


def has_free_way(scene: Scene) -> bool:
    """Whether the scenario leaves the way to the planner."""
    table = _path_table(scene)
    return table.get("type") == "free" and "way" not in table


def ways(scene: Scene) -> list[Scene]:
    """The scene with each way that the arm can follow in the place of the open one, the fastest first.

    The straight line from start to goal, and arcs about the base's vertical axis either way round: on the plain ones
    distance from the axis and height change evenly; where there are obstacles and six joints, detours lead by half way
    nearer to the axis or farther from it, and higher or lower. They are compared by the speed figures of their joint
    paths.

    Raises:
        ScenarioError: the arm can follow none; tells of the line.
    """
    scenes = [scene, *_arcs(scene)]
    tried = [try_joint_paths(item.robot, item.path, tool=item.tray.tool) for item in scenes]
    # rounded, so that ways that are alike compare by their order
    figures = [float(f"{one.paths[0].speed_figure:.6g}") if one.paths else math.inf for one in tried]
    if min(figures) == math.inf:
        raise tried[0].failure()
    order = sorted(range(len(scenes)), key=lambda index: figures[index])
    return [scenes[index] for index in order if figures[index] < math.inf]


def _arcs(scene: Scene) -> Iterator[Scene]:
    # along each of them an arm of seven joints is searched for its elbow, which takes longer than any random search
    detours = bool(scene.obstacles) and redundant_joint(scene.robot) is None
    bumps = [*product(_NEARER, _HIGHER)] if detours else [(0.0, 0.0)]
    foot, _ = base_pose(scene.robot.urdf)
    (x0, y0, z0), (x1, y1, z1) = scene.path.at([0.0, 1.0])[:, :3] - foot
    if min(math.hypot(x0, y0), math.hypot(x1, y1)) < _NEAR_THE_AXIS:
        return
    first, turn = math.atan2(y0, x0), math.remainder(math.atan2(y1, x1) - math.atan2(y0, x0), math.tau)
    share, reach = np.linspace(0.0, 1.0, _POINTS), scene.robot.reach or 1.0
    rise = 16.0 * share**2 * (1 - share) ** 2
    for angle, (out, up) in product((turn, turn - math.copysign(math.tau, turn)), bumps):
        directions = first + share * angle
        distances = (1 - share) * math.hypot(x0, y0) + share * math.hypot(x1, y1) + out * reach * rise
        heights = (1 - share) * z0 + share * z1 + up * reach * rise
        points = np.column_stack([distances * np.cos(directions), distances * np.sin(directions), heights])
        points[[0, -1]] = (x0, y0, z0), (x1, y1, z1)
        with suppress(ScenarioError):  # points that coincide make no way
            yield along(scene, points + foot)


def along(scene: Scene, points: np.ndarray, yaw: np.ndarray | None = None, joint: np.ndarray | None = None) -> Scene:
    """The scene with a way in the place of the open one.

    Args:
        scene: the task.
        points: (m, 3) of the tray's centre, m.
        yaw: (m,) of the tray at them, rad, which then are at even parameters of the path.
        joint: (m,) of the redundant joint of seven at them, rad.

    Raises:
        ScenarioError: the points make no way.
    """
    stated: dict[str, object] = {"way": np.round(points, 9).tolist()}
    for key, values in (("way_yaw", yaw), ("way_joint", joint)):
        if values is not None:
            stated[key] = np.round(values, 9).tolist()
    return scene_from_table(scene.source | {"path": _path_table(scene) | stated}, name=scene.name)


def _path_table(scene: Scene) -> dict[str, object]:
    table = scene.source["path"]
    assert isinstance(table, dict)  # the reader saw to it
    return table
