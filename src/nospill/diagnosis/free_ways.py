"""Which way a free path takes: straight or in an arc, round what is in the way, or as random sampling finds it."""

from __future__ import annotations

import numpy as np

from nospill.collisions.configurations import Configurations
from nospill.collisions.sampled_ways import SampledWay, sampled_way, shortened
from nospill.core.waypoint_paths import path_through_waypoints
from nospill.diagnosis.collisions import free_paths, nearest_of, places_of, require_free_ends
from nospill.errors import NoSolutionError, ScenarioError
from nospill.robots.joint_paths.search import joint_paths, try_joint_paths
from nospill.scenario.free_way import along, ways
from nospill.scene.scene import Scene

SEEDS = (0, 1, 2)
"""Of the random numbers of each sampled way."""
_SAMPLES, _SHORTCUTS = 2000, 100
_SMOOTHINGS = (0.1, 0.05, 0.02, 0.01, 0.004)
"""m; how far a smooth curve may be from a sampled way, the smoothest that is clear is taken."""
_POINTS = 41
"""Of a smooth curve, as they are kept."""
_PLACES = 201
"""Places at which a joint path is looked at."""


def freest_way(scene: Scene) -> Scene:
    """The scene with a way in the place of one that its path leaves open.

    It is the fastest of the plain ways and detours on which nothing is in the way of the level tray; where none is
    clear, the fastest of those that are found by sampling; where there is none either, the one with most room, and the
    certificate decides then.

    Raises:
        ScenarioError: the arm can follow no way; or an obstacle is in the way of the tray at an end.
        NoSolutionError: no way is clear, and the tray is level; tells of the one with most room.
        MissingExtraError: the library coal is not installed.
    """
    if not scene.obstacles:
        return ways(scene)[0]
    try:
        candidates = ways(scene)
    except ScenarioError:
        found = sampled_scene(scene)
        if found is None:
            raise
        return found
    best: tuple[float, Scene] | None = None
    for candidate in candidates:
        paths = joint_paths(candidate.robot, candidate.path, tool=candidate.tray.tool)
        if best is None:
            require_free_ends(candidate, paths[0])
        room = max(item.room for item in nearest_of(candidate, paths))
        if room >= 0.0:
            return candidate
        if best is None or room > best[0]:
            best = room, candidate
    assert best is not None  # `ways` raises where there is none
    return sampled_scene(scene) or _with_most_room(best[1], len(candidates))


def _with_most_room(scene: Scene, tried: int) -> Scene:
    """The scene itself, if the motion may leave its way so far that the certificate must decide."""
    try:
        free_paths(scene, joint_paths(scene.robot, scene.path, tool=scene.tray.tool))
    except NoSolutionError as error:
        text = (
            f"{error}; the {tried} ways that were tried, round the base and over or under, are all blocked, "
            f"and {len(SEEDS)} random searches found no other"
        )
        raise NoSolutionError(text, error.reason) from None
    return scene


def sampled_scene(scene: Scene) -> Scene | None:
    """The scene with the fastest of some ways found by sampling, each with its own seed; None where none is found.

    Raises:
        MissingExtraError: the library coal is not installed.
    """
    best: tuple[float, Scene] | None = None
    for seed in SEEDS:
        way = sampled_way(scene, seed=seed, samples=_SAMPLES)
        found = None if way is None else _smooth(scene, shortened(scene, way, seed=seed, tries=_SHORTCUTS))
        if found is not None and (best is None or found[0] < best[0]):
            best = found
    return None if best is None else best[1]


def _smooth(scene: Scene, way: SampledWay) -> tuple[float, Scene] | None:
    """The scene along the smoothest clear curve beside a way, after its speed figure, s; None where none is clear."""
    configurations, s = Configurations(scene), np.linspace(0.0, 1.0, _PLACES)
    for smoothing in _SMOOTHINGS:
        try:
            curve = path_through_waypoints(way.poses[:, :3], yaw_at_points=way.poses[:, 3], smoothing=smoothing)
            poses = curve.at(np.linspace(0.0, 1.0, _POINTS))
            poses[[0, -1], :3] = scene.path.at(np.array([0.0, 1.0]))[:, :3]
            found = along(scene, poses[:, :3], poses[:, 3])
        except ScenarioError:  # no curve is that near, or the tray turns at one place
            continue
        seen: set[tuple[float, ...]] = set()
        for path in try_joint_paths(found.robot, found.path, tool=found.tray.tool).paths:
            branch = places_of(path)
            # a few places first, which sort most branches out
            if branch not in seen and all(configurations.clear(path.at(some)).all() for some in (s[::20], s)):
                return float(f"{path.speed_figure:.6g}"), found
            seen.add(branch)
    return None
