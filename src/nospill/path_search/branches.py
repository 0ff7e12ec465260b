"""Which of the arm's branches are free of collisions, and what is in the way where none is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from nospill.collisions.along_path import Nearness, nearest_along, nearest_of_tray
from nospill.collisions.configurations import Configurations
from nospill.errors import REST, ROBOT, NoSolutionError, ScenarioError
from nospill.path_search.blocked_places import blocked_place
from nospill.path_search.words import in_words, nearness_reason
from nospill.paths.path import Path
from nospill.robots.joint_paths.no_joint_path import place_in_words
from nospill.robots.joint_paths.search import JointPath
from nospill.robots.kinematics.redundancy import redundant_joint
from nospill.scene.scene import Scene

_ENDS = {0.0: "start", 1.0: "end"}
_PLACES = (11, 201)
"""Numbers of places at which a joint path among obstacles is looked at, one after the other."""
_ALONE = (51,)
"""The same of an arm that keeps from itself and its load alone: so few cost no more than fewer would."""


def free_paths(scene: Scene, candidates: Sequence[JointPath]) -> list[JointPath]:
    """The joint paths on which nothing is in the way of the level tray, in their order; all where there is no obstacle.

    Where there is none, the freest one if the motion may leave it: the tray may tilt, or the arm has a seventh joint,
    and that may help at each place where something is in the way of one of them. The certificate decides then.

    Raises:
        ScenarioError: an obstacle is in the way of the tray or its cargo where the path starts or ends.
        NoSolutionError: something is in the way on every joint path, and the tray is level, or in every configuration
            at a place on the path; names it.
    """
    if not scene.keeps_distances:
        return list(candidates)
    require_free_ends(scene)
    free = [joint_path for joint_path, clear in zip(candidates, are_clear(scene, candidates), strict=True) if clear]
    if free:
        return free
    found = nearest_of(scene, candidates)
    freest = max(range(len(found)), key=lambda index: found[index].slack)
    if not scene.leaves_time_alone and (
        scene.motion.tilt_free or (redundant_joint(scene.robot) is not None and not _on_path(found[freest]))
    ):
        blocked = blocked_place(scene, dict.fromkeys(item.s for item in found))
        if blocked is None:
            return [candidates[freest]]
        raise NoSolutionError(_refusal_of_place(scene, blocked), nearness_reason(blocked, ROBOT))
    raise NoSolutionError(
        _refusal(found[freest], len({places_of(joint_path) for joint_path in candidates})),
        nearness_reason(found[freest], ROBOT),
    )


def require_free_ends(scene: Scene) -> None:
    """Raise the error for an obstacle in the way of the tray or its cargo where the path starts or ends.

    A path of the joints is looked at as a whole.
    """
    if not scene.has_surroundings or scene.path.joint_curve is not None:
        return
    ends = nearest_of_tray(scene, scene.path, places=2)
    if ends.slack < 0.0:
        where = f"where the path {_ENDS[ends.s]}s"
        raise ScenarioError(f"{in_words(ends, where)}; {_advice(ends)}", nearness_reason(ends, REST))


def tray_is_clear(scene: Scene, path: Path) -> bool:
    """Whether nothing is in the way of the level tray and its cargo along a path, whatever the arm does."""
    if not scene.has_surroundings:
        return True
    return all(nearest_of_tray(scene, path, places=places).slack >= 0.0 for places in _PLACES)


def are_clear(scene: Scene, candidates: Sequence[JointPath]) -> Iterator[bool]:
    """Of each joint path whether nothing is in the way of the level tray; a few places first, which sort most out."""
    configurations, known = Configurations(scene), dict[tuple[float, ...], bool]()
    counts = _PLACES if scene.has_surroundings else _ALONE
    for joint_path in candidates:
        branch = places_of(joint_path)
        if branch not in known:
            looks = (joint_path.at(np.linspace(0.0, 1.0, places)) for places in counts)
            known[branch] = all(configurations.clear(q).all() for q in looks)
        yield known[branch]


def nearest_of(scene: Scene, candidates: Sequence[JointPath]) -> list[Nearness]:
    """What comes nearest along each joint path."""
    known: dict[tuple[float, ...], Nearness] = {}
    found = []
    for joint_path in candidates:
        places = places_of(joint_path)
        known[places] = known.get(places) or nearest_along(scene, joint_path)
        found.append(known[places])
    return found


def places_of(joint_path: JointPath) -> tuple[float, ...]:
    """Where a joint path leads, but for whole turns of its joints."""
    q = joint_path.q[:: len(joint_path.q) // 2]
    # + 0 turns -0 into 0
    return tuple((np.round(np.concatenate([np.cos(q), np.sin(q)]), 3) + 0.0).ravel().tolist())


def _refusal(nearest: Nearness, branches: int) -> str:
    words = in_words(nearest, f"at s = {nearest.s:.2f}")
    if _on_path(nearest):
        return f"No way found: {words}, whatever the arm does; {_advice(nearest)}"
    which = "on its only branch" if branches == 1 else f"on the freest of its {branches} branches"
    if nearest.pair.of_arm:
        return f"No way found for the arm: {which} {words}"
    return f"No way found for the arm: {which} {words}; move the obstacle, the path or the arm's base"


def _refusal_of_place(scene: Scene, nearest: Nearness) -> str:
    every = "all configurations and tilts of the tray" if scene.motion.tilt_free else "all configurations"
    words = in_words(nearest, f"at {place_in_words(scene.path, nearest.s)}")
    moved = "" if nearest.pair.of_arm else "; move the obstacle, the path or the arm's base"
    return f"No way found for the arm: in the freest of {every} {words}{moved}"


def _advice(nearness: Nearness) -> str:
    """What may help where the tray or its cargo is in the way."""
    return "enlarge the region or move the path" if nearness.pair.second.of_region else "move the obstacle or the path"


def _on_path(nearness: Nearness) -> bool:
    return nearness.pair.first.on_path and nearness.pair.second.obstacle is not None
