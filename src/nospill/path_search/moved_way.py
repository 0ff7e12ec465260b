"""The way of an earlier plan, moved to other ends of a free path: no other one is searched then."""

from __future__ import annotations

from typing import Any

import numpy as np

from nospill.errors import NospillError
from nospill.path_search.candidates import has_found_path, has_free_path, path_table_of, with_path
from nospill.path_search.level_arm import LEVER, LevelArm
from nospill.robots.kinematics.newton import Held
from nospill.robots.kinematics.redundancy import redundant_joint, self_motion
from nospill.scene.scene import Scene

FARTHEST = 0.4
"""m, a turn counted by `LEVER`: ends that are moved farther, both together, have a way of their own."""
_POINTS = 41
"""Of a way that is moved, at even parameters of the path."""
_SAME = 1e-9
"""m and rad; ends that differ by less are the same."""


def way_of(before: Scene, scene: Scene) -> Scene | None:
    """A scene that leaves its way open with the one of an earlier scene, moved to its ends; None where that is none.

    From start to goal the way is moved by what the ends are, one after the other by a quintic, and turned likewise.
    """
    if not (has_free_path(scene) and (has_free_path(before) or has_found_path(before))):
        return None
    if [item.position for item in scene.motion.via] != [item.position for item in before.motion.via]:
        return None
    old, new = before.path.at([0.0, 1.0]), scene.path.at([0.0, 1.0])
    moved = new - old
    moved[:, 3] = np.remainder(moved[:, 3] + np.pi, 2.0 * np.pi) - np.pi
    if np.linalg.norm(moved[:, :3], axis=1).sum() + LEVER * np.abs(moved[:, 3]).sum() > FARTHEST:
        return None
    found = path_table_of(before)
    stated = {key: found[key] for key in ("way", "way_yaw", "way_joints") if key in found}
    try:
        if np.abs(moved).max() < _SAME:
            return with_path(scene, *map(_array, (stated["way"], *_further(stated)))) if stated else scene
        return _moved(before, scene, moved, _array(stated.get("way_joints")))
    except NospillError:  # its points make no way, or its places are passed too far away
        return None


def _further(stated: dict[str, Any]) -> tuple[Any, Any]:
    return stated.get("way_yaw"), stated.get("way_joints")


def _array(values: Any) -> Any:
    return None if values is None else np.array(values, dtype=float)


def _moved(before: Scene, scene: Scene, moved: np.ndarray, joints: np.ndarray | None) -> Scene | None:
    s = np.linspace(0.0, 1.0, _POINTS if joints is None else len(joints))
    share = (s**3 * (10.0 - 15.0 * s + 6.0 * s**2))[:, None]
    poses = before.path.at(s) + (1.0 - share) * moved[0] + share * moved[1]
    poses[[0, -1], :3] = scene.path.at([0.0, 1.0])[:, :3]
    if joints is not None and redundant_joint(scene.robot) is not None:
        direction = self_motion(scene.robot, joints)
        joints = LevelArm(scene).joints_at(poses, joints, Held(direction, joints @ direction))
        if joints is None:
            return None
    return with_path(scene, poses[:, :3], poses[:, 3], joints)


def same_surroundings(before: Scene, scene: Scene) -> bool:
    """Whether a scene has the ends of an earlier one, and what stands around is written alike."""
    ends = np.abs(before.path.at([0.0, 1.0]) - scene.path.at([0.0, 1.0])).max() < _SAME
    return bool(ends) and before.regions == scene.regions and _obstacles(before) == _obstacles(scene)


def _obstacles(scene: Scene) -> object:
    return scene.source.get("obstacle", [])
