"""Which way a free path takes: straight or in an arc, round what is in the way, or as random sampling finds it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import islice, product

import numpy as np

from nospill.errors import NoSolutionError, ScenarioError
from nospill.path_search.branches import are_clear, free_paths, nearest_of, require_free_ends, tray_is_clear
from nospill.path_search.candidates import PathCandidate, feasible_paths, path_candidates, with_path
from nospill.path_search.level_arm import LEVER, METRIC, LevelArm
from nospill.path_search.over_the_base import axis_crossings, base_axis, lead_over_axis
from nospill.path_search.sampled_paths import SampledPath, concatenate, sample_path, shorten, split_after, time_along
from nospill.paths.path import Path
from nospill.paths.smoothing import smooth_curve
from nospill.robots.joint_paths.no_joint_path import require_reachable_ends
from nospill.robots.joint_paths.search import JointPath, TriedPaths, try_joint_paths
from nospill.robots.kinematics.closed_form import has_closed_form
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.newton import Held
from nospill.robots.kinematics.redundancy import redundant_joint, self_motion
from nospill.scene.scene import Scene

SEEDS = (0, 1, 2, 3)
"""Of the random numbers of each sampled way."""
SAMPLES = 2000
"""Poses that are drawn before a search gives up."""
_SHORTCUTS = 100
_SMOOTHED = 2
"""Sampled ways that are made smooth and compared, those first on which the joints take the least time."""
_SMOOTHINGS = (0.1, 0.05, 0.02, 0.01, 0.004)
"""m; how far a smooth curve may be from a sampled way, the smoothest that is clear is taken."""
_OF_RADIUS = 0.8
"""Part of the radius about a place on the way that smoothing may take at most."""
_SPARES = (0.015, 0.0)
"""m; slack that sampled ways keep from obstacles beyond the clearance, which leaves space for a smooth curve."""
_DENSE = 161
"""Points of a sampled way by which a smooth curve is fitted."""
_POINTS = 41
"""Of a smooth curve, as they are kept."""
_MUCH_FASTER = 0.75
"""Part of a detour's speed figure that a sampled way may have at most to take its place: with less of a difference the
smoother detour leads to the shorter motion (record 0043)."""
_COARSE_SAMPLES = (5, 17)
"""Places at which a way is looked at before it is followed, a few first, which sort most ways out."""


@lru_cache(maxsize=2)
def fastest_clear_path(scene: Scene) -> Scene:
    """The scene with a way in the place of one that its path leaves open; kept, as `tried_along`.

    It is the fastest of the plain ways and detours on which nothing is in the way of the level tray, or a much faster
    one that is found by sampling where the straight one or a faster one is blocked; where none is clear, the fastest of
    those that are found by sampling; where there is none either, the one with most slack, and the certificate decides
    then.

    Raises:
        ScenarioError: an end is out of reach, or an obstacle is in the way of the tray there.
        NoSolutionError: the arm can follow no way; or none is clear, and the tray is level: tells of the one with most
            slack.
    """
    if not scene.has_surroundings:
        ways = feasible_paths(scene)
        clear = (way.scene for way in ways if not scene.keeps_distances or any(are_clear(scene, way.paths)))
        fastest = next(clear, None)
        if fastest is not None:
            return fastest
    require_reachable_ends(scene.robot, scene.path, scene.tray.tool)
    require_free_ends(scene)
    in_order = clear_candidates(scene)
    straight_is_open = any(way.points is None for way in in_order)
    for number, way in enumerate(in_order):
        item = way.scene()
        paths = tried_along(item).paths
        # bodies and pairs are those of the task, whichever way it goes
        if any(are_clear(scene, paths)):
            is_fastest = number == 0 and straight_is_open
            return item if is_fastest else _or_sampled(item, paths[0].speed_figure, scene)
    fastest = fastest_sampled_path(scene)
    return _least_blocked(scene) if fastest is None else fastest[1]


def clear_candidates(scene: Scene) -> list[PathCandidate]:
    """The possible ways that may be clear, the fastest first: few of many are then followed all along."""
    arm = LevelArm(scene)
    figures = [(way, _figure(arm, way)) for way in path_candidates(scene)]
    # rounded, so that ways that are alike compare by their order
    return [way for way, figure in sorted(figures, key=lambda one: float(f"{one[1]:.6g}")) if figure < np.inf]


def _figure(arm: LevelArm, way: PathCandidate) -> float:
    """The speed figure, s, of a way; infinite where the arm cannot follow it, or something is seen to be in the way.

    Of six joints with a closed form it is what some places show, of others that of the fastest joint path.
    """
    closed = has_closed_form(kinematics(arm.robot), arm.redundant)
    if closed and arm.redundant is None:
        return _coarse_figure(arm, way.path)
    if not tray_is_clear(arm.scene, way.path):
        return np.inf
    seen = (way.path.at(np.linspace(0.0, 1.0, places)[1:-1]) for places in _COARSE_SAMPLES)
    if closed and not all(map(arm.can_stand, seen)):
        return np.inf
    return min((path.speed_figure for path in tried_along(way.scene()).paths), default=np.inf)


def _coarse_figure(arm: LevelArm, path: Path) -> float:
    """The speed figure, s, of a path as some places show it; infinite where at one of them nothing is clear."""
    figure = 0.0
    for places in _COARSE_SAMPLES:
        figure = arm.least_figure(path.at(np.linspace(0.0, 1.0, places)))
        if figure == np.inf:
            break
    return figure


@lru_cache(maxsize=8)
def tried_along(scene: Scene) -> TriedPaths:
    """The joint paths along the path of a scene; kept, since a way that is looked at may be the one that is taken."""
    return try_joint_paths(scene.robot, scene.path, tool=scene.tray.tool)


def paths_along(scene: Scene) -> list[JointPath]:
    """`joint_paths` along the path of a scene; raises the same."""
    tried = tried_along(scene)
    if tried.paths:
        return tried.paths
    raise tried.failure()


def _or_sampled(detour: Scene, figure: float, scene: Scene) -> Scene:
    """A clear detour with its speed figure, s, or a sampled way of the scene that is much faster."""
    found = fastest_sampled_path(scene)
    return detour if found is None or found[0] > _MUCH_FASTER * figure else found[1]


def _least_blocked(scene: Scene) -> Scene:
    """The scene with the way that has most slack, as far as the motion may leave it; raises where it may not."""
    try:
        candidates = feasible_paths(scene)
    except NoSolutionError as error:
        text = f"{error}; random searches found no other way"
        raise NoSolutionError(text, error.reason) from None
    freest = max(candidates, key=lambda way: max(item.slack for item in nearest_of(scene, way.paths))).scene
    try:
        free_paths(freest, paths_along(freest))
    except NoSolutionError as error:
        text = (
            f"{error}; the {len(candidates)} ways that were tried, round the base and over or under, are all blocked, "
            "and random searches found no other"
        )
        raise NoSolutionError(text, error.reason) from None
    return freest


def fastest_sampled_path(scene: Scene) -> tuple[float, Scene] | None:
    """The fastest of some ways found by sampling, each with its own seed; None where none is found.

    Returns:
        Its speed figure, s, and the scene with it.
    """
    seven, axis = redundant_joint(scene.robot) is not None, base_axis(scene)
    # what is longer, or harder to follow, where nothing else is found
    kinds = (False, True) if seven or axis is not None else (False,)
    for farther, spare in product(kinds, _SPARES):
        arm, over = LevelArm(scene, spare=spare, by_joints=seven and farther), axis if farther else None
        short = [way for seed in SEEDS if (way := _short_sample(arm, over, seed)) is not None]
        short.sort(key=lambda way: time_along(arm, way.q))
        smooth = [*islice(filter(None, (_smooth(scene, arm, over, way) for way in short)), _SMOOTHED)]
        if smooth:
            best = min(smooth, key=lambda way: way.speed_figure)
            return best.speed_figure, best.along(scene)
    return None


def _short_sample(arm: LevelArm, over: np.ndarray | None, seed: int) -> SampledPath | None:
    """The way that one seed finds, made shorter; None where it finds none.

    Where it passes over the axis of the base it is kept as it is.
    """
    legs = sample_path(arm, seed=seed, samples=SAMPLES, over=over)
    if not legs:
        return None
    if over is not None:
        legs = [part for leg in legs for part in split_after(leg, axis_crossings(leg.poses, leg.q, over))]
    return concatenate([shorten(arm, leg, seed=seed, tries=_SHORTCUTS) for leg in legs])


@dataclass(frozen=True, slots=True, eq=False)
class _SmoothPath:
    """A smooth clear curve near a sampled way.

    Attributes:
        speed_figure: of the fastest joint path along it, s.
        points: (m, 3) of the tray's centre, m.
        yaw: (m,) of the tray, rad.
        joints: (m, 7) of an arm of seven joints, rad.
    """

    speed_figure: float
    points: np.ndarray
    yaw: np.ndarray
    joints: np.ndarray | None

    def along(self, scene: Scene) -> Scene:
        """The scene with this way."""
        return with_path(scene, self.points, self.yaw, self.joints)


def _smooth(scene: Scene, arm: LevelArm, axis: np.ndarray | None, way: SampledPath) -> _SmoothPath | None:
    """The smoothest clear curve near a way; None where none is clear.

    Where the way passes over the axis of the base, so does the curve.
    """
    # with seven joints the self-motion is smoothed as well
    direction = np.zeros(len(arm.robot.joints)) if arm.redundant is None else self_motion(arm.robot, way.q)
    points = np.column_stack([way.poses * METRIC, LEVER * way.q @ direction])
    along_it = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    dense = np.linspace(0.0, along_it[-1], _DENSE)
    points, q = (np.column_stack([np.interp(dense, along_it, column) for column in of.T]) for of in (points, way.q))
    widest = min((_OF_RADIUS * item.radius for item in scene.motion.via), default=_SMOOTHINGS[0])
    for smoothing in dict.fromkeys(min(column, widest) for column in _SMOOTHINGS):
        curve = smooth_curve(points, smoothing)
        if curve is None:
            continue
        at = np.linspace(0.0, 1.0, _POINTS)
        values = curve.pieces(at)
        poses = values[:, :4] / METRIC
        if axis is not None:
            for look in axis_crossings(way.poses, way.q, axis):
                over = np.interp(0.5 * (along_it[look] + along_it[look + 1]), dense, curve.s)
                poses = lead_over_axis(poses, float(over), axis)
        poses[[0, -1], :3] = arm.ends[:, :3]
        joints = None
        if arm.redundant is not None:
            near = np.column_stack([np.interp(at, curve.s, column) for column in q.T])
            joints = arm.joints_at(poses, near, Held(direction, values[:, 4] / LEVER))
            if joints is None:
                continue
        try:
            smooth_scene = with_path(scene, poses[:, :3], poses[:, 3], joints)
        except ScenarioError:  # between its points it passes a place too far away
            continue
        if not tray_is_clear(scene, smooth_scene.path):
            continue
        paths = tried_along(smooth_scene).paths
        path = next((path for path, clear in zip(paths, are_clear(scene, paths), strict=True) if clear), None)
        if path is not None:
            return _SmoothPath(float(f"{path.speed_figure:.6g}"), poses[:, :3], poses[:, 3], joints)
    return None
