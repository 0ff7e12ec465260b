"""Whether the arm can stand where its path starts and ends, clear of itself, its load and the obstacles.

That is said before any search, with the smallest of some changes that helps; each of them is tried.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import islice

import numpy as np

from nospill.collisions.along_path import Nearness, freest_of_arm
from nospill.collisions.pairs import scene_pairs
from nospill.core.units import quantity
from nospill.errors import REST, Change, NoSolutionError, ScenarioError
from nospill.laws.constraints.clearance import Clearance
from nospill.path_search.branches import are_clear, free_paths
from nospill.path_search.level_arm import LevelArm
from nospill.path_search.words import in_words, nearness_reason
from nospill.robots.joint_paths.no_joint_path import place_in_words
from nospill.robots.joint_paths.search import JointPath, try_joint_paths
from nospill.robots.kinematics.closed_form import has_closed_form
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.redundancy import redundant_joint
from nospill.scene.scene import Scene

_ENDS = {"starts": 0.0, "ends": 1.0}
_HIGHER = np.array([0.02, 0.04, 0.06, 0.08, 0.1, 0.13, 0.16, 0.2, 0.25, 0.3])
"""m; by which the tray may stand farther from the flange."""
_TURNS = np.radians([15, -15, 30, -30, 45, -45, 60, -60, 90, -90, 120, -120, 150, -150, 180])
_MOVED = tuple(sign * size for size in (0.1, 0.2, 0.3, 0.4) for sign in (1.0, -1.0))
"""m; by which the arm's base may stand lower or higher."""
_AWAY = (0.05, 0.1, 0.15, 0.2, 0.25, 0.3)
"""m; by which an end of the path may stand farther from the base's axis or higher."""
_SPARSE, _TRIED = 12, 40
"""Every so many positions of a seventh joint are looked at, before all are, and where a change is tried."""
_FOLLOWED = 3
"""Changes of one kind with which start and end are free, whose whole path is looked at."""


def require_standing_room(scene: Scene) -> None:
    """Refuse a path at whose start or end every configuration of the arm touches itself, its load or an obstacle.

    Only where all configurations are known: they are stated, or there is a closed form. An end that no configuration
    reaches is no concern of it. The tray is level at both ends, whatever its freedom between.

    Raises:
        ScenarioError: naming the pair, the depth, the place, and changes that help.
    """
    for verb, s in _ENDS.items():
        if scene.path.joint_curve is not None:  # looked at as a whole, and changed by none of these
            return
        q, found = _freest(scene, s)
        if found is None or found.slack >= 0.0:
            continue
        stated = scene.path.ends[round(s)] is not None
        which = "in the joints stated" if stated else f"in the freest of its {len(q)} configurations"
        which = "in its only configuration" if len(q) == 1 and not stated else which
        changes = tuple(helpful_moves(scene))
        advice = advice_on(found.pair.subject, changes)
        if found.pair.second.obstacle is not None:
            moved = "move the obstacle, that end of the path or the arm's base"
            advice = f"{moved}; {advice}" if changes else moved
        raise ScenarioError(
            f"path: the arm cannot stand where it {verb}, {place_in_words(scene.path, s)}: {which} "
            f"{in_words(found, '')}; {advice}",
            replace(nearness_reason(found, REST), changes=changes),
        )


def _freest(scene: Scene, s: float) -> tuple[np.ndarray, Nearness | None]:
    """Configurations (k, n) at an end, rad, and what comes nearest in the freest; None where they are not known."""
    q, found = np.empty((0, len(scene.robot.joints))), None
    pose = scene.path.at(np.array([s]))[0]
    for every in (_SPARSE, 1):
        q = _configurations(scene, pose, s, every)
        found = freest_of_arm(scene, q, s) if len(q) else None
        if (found is not None and found.slack >= 0.0) or redundant_joint(scene.robot) is None:
            break
    return q, found


def advised_free_paths(scene: Scene, candidates: Sequence[JointPath]) -> list[JointPath]:
    """`free_paths`; where the arm touches itself or its load on every joint path, with changes that help."""
    try:
        return free_paths(scene, candidates)
    except NoSolutionError as error:
        reason = error.reason
        if reason is None or not can_be_advised(scene, reason.subject):
            raise
        changes = tuple(helpful_moves(scene))
        text = f"{error}; {advice_on(reason.subject, changes)}"
        raise NoSolutionError(text, replace(reason, changes=changes)) from None


def can_be_advised(scene: Scene, subject: str) -> bool:
    """Whether a pair that comes too near is of the arm with itself or its load, and the path is not one of the joints.

    It is for such pairs that `helpful_moves` are.
    """
    own = {pair.subject for pair in scene_pairs(scene) if pair.of_arm}
    return subject in own and scene.path.joint_curve is None


def advice_on(subject: str, changes: tuple[Change, ...]) -> str:
    """What to do about a pair of the arm: the changes that were found to help, else what was tried in vain."""
    if changes:
        return "smallest single change found: " + "; or ".join(change.text for change in changes)
    return (
        f"move the path, or keep {subject} apart otherwise: neither "
        f"a tray up to {1e3 * _HIGHER[-1]:.0f} mm farther from the flange, nor "
        f"another yaw of the path, nor a base up to {1e3 * max(_MOVED):.0f} mm lower or higher helps by itself"
    )


def helpful_moves(scene: Scene) -> Iterator[Change]:
    """The smallest change of each kind with which the arm stands free at both ends, and along a path that is given."""
    found = False
    for kind in (_farther_from_flange, _path_turns):
        change = _first_helpful(scene, kind(scene))
        if change is not None:
            found = True
            yield change
    for kind in () if found else (_end_shifts, _base_shifts):
        change = _first_helpful(scene, kind(scene))
        if change is not None:
            yield change


def _first_helpful(scene: Scene, changes: Iterator[Change]) -> Change | None:
    for change in islice(changes, _FOLLOWED):
        try:
            changed = scene.changed(change.values)
        except ScenarioError:  # another limit of the scenario is in the way
            continue
        if changed.source["path"]["type"] == "free":  # its way is looked for with the change
            return change
        paths = try_joint_paths(changed.robot, changed.path, tool=changed.tray.tool).paths
        if any(are_clear(changed, paths)):
            return change
    return None


def _farther_from_flange(scene: Scene) -> Iterator[Change]:
    """Offsets of the tray with which the arm stands free at both ends."""
    tool = scene.tray.tool
    for higher in _HIGHER.tolist():
        position = tool.position + np.array([0.0, 0.0, higher])
        changed = replace(scene, tray=replace(scene.tray, tool=replace(tool, position=position)))
        if _stands_free(changed, _end_poses(scene)):
            text = f"tray.offset = {_lengths(position)}, {1e3 * higher:.0f} mm farther from the flange"
            yield Change.of_limit(Clearance.name, "tray", "tray.offset", position.tolist(), text)


def _path_turns(scene: Scene) -> Iterator[Change]:
    """Turns of the tray against the path, likewise; of paths whose yaw stands in one key."""
    table = scene.source["path"]
    before = table.get("yaw", [0.0, 0.0]) if isinstance(table, dict) else None
    if not isinstance(before, list) or table.get("type") == "free" or len(before) != 2:
        return
    ends = _end_poses(scene)
    for turn in _TURNS.tolist():
        poses = ends + np.array([0.0, 0.0, 0.0, turn])
        if _stands_free(scene, poses):
            values = [f"{math.degrees(value):.6g} deg" for value in poses[:, 3].tolist()]
            text = f"path.yaw = [{', '.join(values)}], the tray turned by {math.degrees(turn):.0f} deg"
            yield Change.of_limit(Clearance.name, "tray", "path.yaw", values, text)


def _end_shifts(scene: Scene) -> Iterator[Change]:
    """Places of the one end that is blocked, farther out or higher, likewise; of lines and free paths."""
    table, poses = scene.source["path"], _end_poses(scene)
    of_kind = {"line": ("start", "end"), "free": ("start.position", "goal.position")}
    blocked = [index for index, s in enumerate(_ENDS.values()) if not _stands_free_at(scene, poses[index], s)]
    if len(blocked) != 1 or table["type"] not in of_kind:
        return
    end, key = blocked[0], of_kind[table["type"]][blocked[0]]
    name, _, inner = key.partition(".")
    at = table[name].get(inner) if inner else table[name]
    radius = float(np.hypot(*poses[end, :2]))
    if at is None or radius == 0.0:  # stated by joints, or above the base's axis
        return
    outwards = np.append(poses[end, :2] / radius, 0.0)
    for away in _AWAY:
        for step, where in ((away * outwards, "farther out"), (np.array([0.0, 0.0, away]), "higher")):
            if not _stands_free_at(scene, poses[end] + np.append(step, 0.0), float(end)):
                continue
            # to whole millimetres, as it is shown
            position = np.round(np.array([quantity(value, "length") for value in at]) + step, 3)
            text = f"path.{key} = {_lengths(position)}, {1e3 * away:.0f} mm {where}"
            change = Change.of_limit(Clearance.name, "path", f"path.{key}", position.tolist(), text)
            if _stands_free_with(scene, change):
                yield change


def _base_shifts(scene: Scene) -> Iterator[Change]:
    """Heights of the base, likewise."""
    base = scene.source["robot"].get("base_position", [0.0, 0.0, 0.0])
    if not all(isinstance(value, int | float) for value in base):
        return
    for lower in _MOVED:
        position = [float(base[0]), float(base[1]), float(base[2]) - lower]
        where = "lower" if lower > 0.0 else "higher"
        text = f"robot.base_position = {_lengths(np.array(position))}, {1e3 * abs(lower):.0f} mm {where}"
        change = Change.of_limit(Clearance.name, "robot", "robot.base_position", position, text)
        if _stands_free_on(scene, change, lower):
            yield change


def _stands_free_on(scene: Scene, change: Change, lower: float) -> bool:
    """`_stands_free` with the base lower, m: without surroundings that is the path as much higher."""
    if not scene.has_surroundings:
        return _stands_free(scene, _end_poses(scene) + np.array([0.0, 0.0, lower, 0.0]))
    return _stands_free_with(scene, change)


def _stands_free_with(scene: Scene, change: Change) -> bool:
    """`_stands_free` of the scene with a change."""
    try:
        changed = scene.changed(change.values)
    except ScenarioError:  # another limit of the scenario is in the way
        return False
    return _stands_free(changed, _end_poses(changed))


def _end_poses(scene: Scene) -> np.ndarray:
    """x, y, z (m) and yaw (rad) at both ends of the path, (2, 4)."""
    return scene.path.at(np.array(list(_ENDS.values())))


def _stands_free(scene: Scene, poses: np.ndarray) -> bool:
    """Whether at both poses (2, 4) of the tray some configuration is clear of the arm, its load and the obstacles."""
    return all(_stands_free_at(scene, pose, s) for s, pose in zip(_ENDS.values(), poses, strict=True))


def _stands_free_at(scene: Scene, pose: np.ndarray, s: float) -> bool:
    """The same at the pose (4,) of one end."""
    q = _configurations(scene, pose, s, _TRIED)
    found = freest_of_arm(scene, q, s) if len(q) else None
    return found is not None and found.slack >= 0.0


def _configurations(scene: Scene, pose: np.ndarray, s: float, every: int) -> np.ndarray:
    """All configurations (k, n) within the limits at a pose (4,), rad; none where they are not known.

    Those stated at that end of the path where some are. With a seventh joint at every so many of its positions.
    """
    stated = scene.path.ends[round(s)]
    if stated is not None:
        return np.array([stated])
    arm = _level_arm(scene)
    if not has_closed_form(kinematics(arm.robot), arm.redundant):
        return np.empty((0, len(scene.robot.joints)))
    held = arm.held[::every]
    return np.concatenate(arm.solutions(np.tile(pose, (len(held), 1)), held))


_level_arm = lru_cache(maxsize=4)(LevelArm)


def _lengths(position: np.ndarray) -> str:
    return "[" + ", ".join(f'"{1e3 * value:.6g} mm"' for value in position) + "]"
