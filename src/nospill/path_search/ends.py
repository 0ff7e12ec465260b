"""Whether the arm can stand at the start and at the goal: a look at every configuration, before any search."""

from __future__ import annotations

import numpy as np

from nospill.collisions.distances import Distances
from nospill.collisions.pairs import Pair, scene_pairs
from nospill.core.units import as_written, format_quantity
from nospill.errors import REST, Reason, ScenarioError
from nospill.laws.constraints.clearance import Clearance
from nospill.robots.joint_paths.following import tray_poses
from nospill.robots.joint_paths.no_joint_path import place_in_words
from nospill.robots.kinematics.closed_form import has_closed_form, solutions_anywhere, with_turns
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from nospill.scene.scene import Scene

_ENDS = (("start", 0.0), ("goal", 1.0))


def require_clear_arm_at_ends(scene: Scene) -> None:
    """Refuse a start or a goal at which a link is in an obstacle, or too near to it, in every configuration of the arm.

    Looked at where all configurations are known: of six joints with a closed form, and of joints that are stated. The
    tray is level there, whatever its freedom between.

    Raises:
        ScenarioError: there is one; names the obstacle, the link and the depth in the freest configuration.
    """
    if not scene.obstacles:
        return
    for (name, s), stated in zip(_ENDS, scene.path.ends, strict=True):
        q = _configurations(scene, s) if stated is None else stated[None]
        if not len(q):
            continue  # out of reach, of which another check tells; or not all of them are known
        pairs = [pair for pair in scene_pairs(scene) if pair.second.obstacle is not None and not pair.first.on_path]
        frames, every = joint_frames(arm_chain(scene.robot), q), np.arange(len(q))
        room = np.array([Distances(pair.first, pair.second).at(frames, every)[0] - pair.limit for pair in pairs])
        freest = int(np.argmax(room.min(axis=0)))
        nearest = int(np.argmin(room[:, freest]))
        slack, pair = float(room[nearest, freest]), pairs[nearest]
        if slack < 0.0:
            which = _which(name, len(q), is_stated=stated is not None)
            raise ScenarioError(
                f"path: the arm cannot stand at the {name}, {place_in_words(scene.path, s)}: {which} "
                f"{_in_words(pair, slack)}; move the obstacle, the {name} or the arm's base",
                Reason(REST, Clearance.name, pair.subject, at_s=s, excess=-slack, unit="m"),
            )


def _configurations(scene: Scene, s: float) -> np.ndarray:
    """All solutions (k, n), rad, within the joint limits at an end; none where they are not all known."""
    arm = kinematics(scene.robot)
    if arm.n != 6 or not has_closed_form(arm, None):
        return np.empty((0, arm.n))
    positions, rotations = tray_poses(scene.path, np.array([s]))
    q = solutions_anywhere(scene.robot, positions[0], rotations[0], tool=scene.tray.tool)
    return np.array([own for own in q if len(with_turns(scene.robot, own[None]))]).reshape(-1, arm.n)


def _which(name: str, configurations: int, *, is_stated: bool) -> str:
    if is_stated:
        return f"in {name}.joints"
    return f"in the freest of its {configurations} configurations" if configurations > 1 else "as it has to stand"


def _in_words(pair: Pair, slack: float) -> str:
    distance, obstacle = slack + pair.limit, as_written(pair.second.name)
    if distance < 0.0:
        return f"the {pair.first.name} enters {obstacle} by {_shown(-distance)}"
    kept = _shown(pair.limit)
    return f"the {pair.first.name} comes within {_shown(distance)} of {obstacle}, and {kept} must be kept"


def _shown(length: float) -> str:
    return format_quantity(length, "length", digits=3)
