"""`[path] type = "free"`: the ways along which a motion from here to there is looked for."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np

from nospill.core.piecewise import interpolating_pieces
from nospill.errors import NoSolutionError, ScenarioError
from nospill.paths.path import Path
from nospill.robots.description.urdf import base_pose
from nospill.robots.joint_paths.no_joint_path import require_reachable_ends
from nospill.robots.joint_paths.search import JointPath, try_joint_paths
from nospill.robots.kinematics.redundancy import redundant_joint
from nospill.scenario.free_path_entry import FreePath
from nospill.scenario.scenes import scene_from_table
from nospill.scene.scene import Scene

_POINTS = 13
"""Of an arc about the base, from place to place."""
_NEAR_THE_AXIS = 0.05
"""m; nearer to the base's axis there is no direction to turn from."""
_DIGITS = 9
"""Of the numbers of a way, m and rad."""
_NEARER = (0.0, -0.1, -0.2, -0.3, 0.15)
_HIGHER = (0.0, 0.2, 0.4, -0.2)
"""How much farther from the axis, and higher, detours are half way, in parts of the arm's reach."""


def has_free_path(scene: Scene) -> bool:
    """Whether the scenario leaves the way to the planner."""
    table = path_table_of(scene)
    return table.get("type") == "free" and "way" not in table


def has_found_path(scene: Scene) -> bool:
    """Whether the scene goes the way that the planner took in the place of one left open."""
    table = path_table_of(scene)
    return table.get("type") == "free" and "way" in table


@dataclass(frozen=True, slots=True)
class FeasiblePath:
    """A way that the arm can follow.

    Attributes:
        scene: the task with it.
        paths: its joint paths, best first.
    """

    scene: Scene
    paths: list[JointPath]


@dataclass(frozen=True, slots=True, eq=False)
class PathCandidate:
    """A way that is looked at, whether the arm can follow it or not.

    Attributes:
        task: the scene that leaves it open.
        path: of the tray along it.
        points: (m, 3) of the tray's centre, m; None for the one that the task itself begins with.
    """

    task: Scene
    path: Path
    points: np.ndarray | None = None

    def scene(self) -> Scene:
        """The task with it: a whole scenario is read."""
        return self.task if self.points is None else with_path(self.task, self.points)


def path_candidates(scene: Scene) -> Iterator[PathCandidate]:
    """Each way that is looked at.

    The straight line from start to goal, and arcs about the base's vertical axis either way round: on the plain ones
    distance from the axis and height change evenly; where there are obstacles and six joints, detours lead by half way
    nearer to the axis or farther from it, and higher or lower. With places between them smooth curves through all, in
    the base's axes or in angle, distance and height, and no detours.
    """
    yield PathCandidate(scene, scene.path)
    yield from _arcs(scene)


def feasible_paths(scene: Scene) -> list[FeasiblePath]:
    """Each possible way that the arm can follow from start to goal, the fastest by its speed figure first.

    Raises:
        ScenarioError: start or goal is out of reach, or no joints within their limits hold the level tray there.
        NoSolutionError: the arm can follow none of the ways; tells of the first one.
    """
    require_reachable_ends(scene.robot, scene.path, scene.tray.tool)
    scenes = [way.scene() for way in path_candidates(scene)]
    tried = [try_joint_paths(item.robot, item.path, tool=item.tray.tool) for item in scenes]
    feasible = [FeasiblePath(item, one.paths) for item, one in zip(scenes, tried, strict=True) if one.paths]
    if not feasible:
        first = tried[0].failure()
        which = "the only way that was tried" if len(tried) == 1 else f"any of the {len(tried)} ways that were tried"
        raise NoSolutionError(
            f"No way found: the arm cannot follow {which} from start to goal; of "
            f"{'it' if len(tried) == 1 else 'the first one'}, {str(first).removeprefix('path: ')}",
            first.reason,
        )
    # rounded, so that ways that are alike compare by their order
    return sorted(feasible, key=lambda way: float(f"{way.paths[0].speed_figure:.6g}"))


def _arcs(scene: Scene) -> Iterator[PathCandidate]:
    # along each of them an arm of seven joints is searched for its elbow, which takes longer than any random search
    detours = scene.has_surroundings and not scene.motion.via and redundant_joint(scene.robot) is None
    bumps = [*product(_NEARER, _HIGHER)] if detours else [(0.0, 0.0)]
    table = FreePath.model_validate(path_table_of(scene)).placed(scene.robot, scene.tray.tool, base_is_free=False)
    foot, _ = base_pose(scene.robot.urdf)
    ends, reach = scene.path.at([0.0, 1.0])[:, :3], scene.robot.reach or 1.0
    places = np.array([ends[0], *(item.position for item in scene.motion.via), ends[1]]) - foot
    distances = np.hypot(places[:, 0], places[:, 1])
    lengths = np.linalg.norm(np.diff(places, axis=0), axis=1)
    if np.min(distances) < _NEAR_THE_AXIS or not lengths.all():  # a turn on the spot
        return
    directions = np.arctan2(places[:, 1], places[:, 0])
    turns = [math.remainder(turn, math.tau) for turn in np.diff(directions).tolist()]
    knots = np.append(0.0, np.cumsum(lengths) / np.sum(lengths))
    share = np.linspace(0.0, 1.0, _POINTS)
    at = np.append(0.0, np.concatenate([first + share[1:] * (last - first) for first, last in pairwise(knots)]))
    rise = 16.0 * at**2 * (1.0 - at) ** 2
    # the short way round everywhere, or the long one from one of the places to the next
    longer = [[*turns[:leg], turn - math.copysign(math.tau, turn), *turns[leg + 1 :]] for leg, turn in enumerate(turns)]
    for angles, (out, up) in product([turns, *longer], bumps):
        turned = directions[0] + np.append(0.0, np.cumsum(angles))
        curve = interpolating_pieces(knots, np.column_stack([turned, distances, places[:, 2]]))
        direction, distance, height = curve(at).T
        distance, height = distance + out * reach * rise, height + up * reach * rise
        points = np.column_stack([distance * np.cos(direction), distance * np.sin(direction), height])
        points[:: _POINTS - 1] = places
        points = np.round(points + foot, _DIGITS)
        with suppress(ScenarioError):  # points that coincide make no way, or it passes a place too far away
            path = table.model_copy(update={"way": points.tolist()}).build()
            table.places_passed(path)
            yield PathCandidate(scene, path, points)


def with_path(
    scene: Scene, points: np.ndarray, yaw: np.ndarray | None = None, joints: np.ndarray | None = None
) -> Scene:
    """The scene with a way in the place of the open one.

    Args:
        scene: the task.
        points: (m, 3) of the tray's centre, m.
        yaw: (m,) of the tray at them, rad, which then are at even parameters of the path.
        joints: (m, 7) of an arm of seven that holds the tray at them, rad.

    Raises:
        ScenarioError: the points make no way.
    """
    stated: dict[str, object] = {"way": np.round(points, _DIGITS).tolist()}
    for key, values in (("way_yaw", yaw), ("way_joints", joints)):
        if values is not None:
            stated[key] = np.round(values, _DIGITS).tolist()
    read = scene_from_table(scene.source | {"path": path_table_of(scene) | stated}, name=scene.name)
    return read.limited_as(scene)


def path_table_of(scene: Scene) -> dict[str, object]:
    """The `[path]` of a scene's scenario."""
    table = scene.source["path"]
    assert isinstance(table, dict)  # the reader saw to it
    return table
