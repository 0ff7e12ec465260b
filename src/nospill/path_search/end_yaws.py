"""`yaw = "free"` at an end of a free path: which way the tray is turned there, found from joint paths alone.

The yaws of a grid are compared by the time that the slowest joint needs at full speed from a configuration at the start
to one at the goal, the arm and its tray clear of everything in both; the best few are followed along the straight way.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import islice
from typing import Any

import numpy as np

from nospill.errors import NoSolutionError, ScenarioError
from nospill.path_search.free_path import fastest_clear_path
from nospill.path_search.level_arm import LevelArm
from nospill.robots.description.urdf_tree import about_axis
from nospill.robots.joint_paths.search import try_joint_paths
from nospill.robots.kinematics.closed_form import has_closed_form, inverse_solutions
from nospill.robots.kinematics.forward import kinematics
from nospill.scenario.fields import FREE
from nospill.scenario.scenes import scene_from_table
from nospill.scene.scene import Scene

STEP = math.radians(15.0)
"""Between two yaws that are tried."""
_ENDS = ("start", "goal")
_WIDE = 2
"""So many steps from yaw to yaw with a redundant joint."""
_HELD = 10
"""Positions of the redundant joint at which configurations are looked for."""
_FOLLOWED = 6
"""Pairs of yaws that are followed, best first."""
_LOOKED_FOR = 3
"""Likewise among obstacles, where a way is looked for: that may take half a minute where there is none."""


def free_ends(scene: Scene) -> tuple[str, ...]:
    """The ends of the path, "start" and "goal", whose yaw the scenario leaves to the planner."""
    table = _path_table(scene)
    if table.get("type") != "free":
        return ()
    places = {end: table.get(end) for end in _ENDS}
    return tuple(end for end, place in places.items() if isinstance(place, Mapping) and place.get("yaw") == FREE)


def choose_end_yaws(scene: Scene) -> Scene:
    """The scene with a yaw in the place of each that is free; as it is where none is.

    Nothing is optimised. The table `source` of the scene has the values written out, so that its scenario says what was
    planned.

    Raises:
        ScenarioError: the arm holds the level tray at one of the places with no yaw, or something is in the way there.
        NoSolutionError: the arm can follow no way between the best pairs of yaws; tells of the best one.
    """
    free = free_ends(scene)
    if not free:
        return scene
    found: list[tuple[float, int, Scene]] = []
    failure: NoSolutionError | ScenarioError | None = None
    most = _LOOKED_FOR if scene.has_surroundings else _FOLLOWED
    for order, yaws in enumerate(islice(_in_order(scene, free), most)):
        candidate = _turned(scene, dict(zip(_ENDS, yaws, strict=True)), free)
        try:
            if scene.has_surroundings:
                fastest_clear_path(candidate)
                return candidate
            tried = try_joint_paths(candidate.robot, candidate.path, tool=candidate.tray.tool)
            if not tried.paths:
                raise tried.failure()
        except (NoSolutionError, ScenarioError) as error:
            failure = failure or error
            continue
        # rounded, so that yaws that are alike compare by their order
        found.append((float(f"{tried.paths[0].speed_figure:.3g}"), order, candidate))
    if found:
        return min(found, key=lambda entry: entry[:2])[2]
    assert failure is not None  # there are pairs
    raise failure


def end_yaws_text(scene: Scene, free: tuple[str, ...]) -> str:
    """The yaws that were chosen, as "goal 45 deg"."""
    table = _path_table(scene)
    places = {end: table[end] for end in free}
    return ", ".join(f"{end} {place['yaw']}" for end, place in places.items() if isinstance(place, Mapping))


def _in_order(scene: Scene, free: tuple[str, ...]) -> list[tuple[float, float]]:
    """Pairs of yaws, rad, at start and goal, those first between which the joints need the least time."""
    arm = LevelArm(scene)
    stands = {end: _configurations(arm, index, end in free) for index, end in enumerate(_ENDS)}
    (start, first), (goal, last) = stands["start"], stands["goal"]
    gaps = np.abs(arm.apart(first[:, None], last[None])) / arm.robot.max_speed
    # the slowest joint decides, the others where it is the same
    times = gaps.max(axis=2) + 1e-3 * np.sqrt(np.sum(gaps**2, axis=2))
    best: dict[tuple[float, float], float] = {}
    for here, there in np.argwhere(times < np.inf):
        pair = float(start[here]), float(goal[there])
        best[pair] = min(best.get(pair, np.inf), float(f"{times[here, there]:.6g}"))
    ordered = sorted(best, key=lambda pair: (best[pair], abs(math.remainder(pair[1] - pair[0], math.tau)), pair))
    return [_short_turn(pair, free) for pair in ordered]


def _short_turn(pair: tuple[float, float], free: tuple[str, ...]) -> tuple[float, float]:
    """The same attitudes with less than half a turn between them; the yaw that is stated stays."""
    start, goal = pair
    turn = math.remainder(goal - start, math.tau)
    return (start, start + turn) if "goal" in free else (goal - turn, goal)


def _configurations(arm: LevelArm, index: int, free: bool) -> tuple[np.ndarray, np.ndarray]:
    """Yaws (k,), rad, and the clear configurations (k, n), rad, in which the arm holds the tray at an end.

    Raises:
        ScenarioError: there is none.
    """
    end, stated = arm.ends[index], arm.scene.path.ends[index]
    if stated is not None:
        return end[3:], stated[None]
    step = STEP if arm.redundant is None else _WIDE * STEP
    yaws = np.arange(-math.pi + step, math.pi + step / 2, step) if free else end[3:]
    held = arm.held if arm.redundant is None else arm.held[:: max(1, len(arm.held) // _HELD)]
    poses = np.repeat(np.column_stack([np.tile(end[:3], (len(yaws), 1)), yaws]), len(held), axis=0)
    choices = _solutions(arm, poses, np.tile(held, len(yaws)))
    counts = [len(some) for some in choices]
    poses, q = np.repeat(poses, counts, axis=0), np.concatenate(choices)
    clear = arm.clear(poses, q) if len(q) else np.zeros(0, dtype=bool)
    if not clear.any():
        why = "something is in the way" if len(q) else "it is out of reach of the arm"
        turns = f"any of {len(yaws)} yaws" if free else "the stated yaw"
        raise ScenarioError(
            f"path.{_ENDS[index]}: the arm cannot hold the tray there, at {turns}: {why}; move the place"
        )
    return poses[clear, 3], q[clear]


def _solutions(arm: LevelArm, poses: np.ndarray, held: np.ndarray) -> list[np.ndarray]:
    """Configurations (k, n), rad, at each of poses (m, 4), the redundant joint at given positions (m,), rad."""
    if has_closed_form(kinematics(arm.robot), arm.redundant):
        return arm.solutions(poses, held)
    found = []
    for pose, value in zip(poses, held, strict=True):
        given = None if arm.redundant is None else (arm.redundant, float(value))
        turn = about_axis((0.0, 0.0, 1.0), float(pose[3]))
        found.append(inverse_solutions(arm.robot, pose[:3], turn, tool=arm.scene.tray.tool, held=given))
    return found


def _turned(scene: Scene, yaws: Mapping[str, float], free: tuple[str, ...]) -> Scene:
    table = _path_table(scene)
    stated = {end: {**_place(table, end), "yaw": f"{math.degrees(yaws[end]):.9g} deg"} for end in free}
    return scene_from_table(scene.source | {"path": table | stated}, name=scene.name).limited_as(scene)


def _place(table: Mapping[str, Any], end: str) -> dict[str, Any]:
    place = table[end]
    assert isinstance(place, dict)  # the reader saw to it
    return place


def _path_table(scene: Scene) -> dict[str, Any]:
    table = scene.source["path"]
    assert isinstance(table, dict)  # the reader saw to it
    return table
