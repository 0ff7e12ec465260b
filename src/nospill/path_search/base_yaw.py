"""`base_yaw = "free"`: the turn of the arm's base that lets it follow the path best, found from joint paths alone."""

from __future__ import annotations

from typing import Any

from nospill.errors import ScenarioError
from nospill.robots.joint_paths.no_joint_path import farthest_reached
from nospill.robots.joint_paths.search import try_joint_paths
from nospill.scenario.scenes import scene_from_table
from nospill.scene.scene import Scene

STEP_DEG = 30
"""Between two turns that are tried."""


def has_free_base(scene: Scene) -> bool:
    """Whether the scenario leaves the base yaw to the planner."""
    return _robot_table(scene).get("base_yaw") == "free"


def choose_base_yaw(scene: Scene) -> Scene:
    """The scene with a base yaw in the place of "free"; as it is where none is free.

    Every 30 deg is tried. The best joint path of each is compared by its speed figure, a bound on how fast the path can
    be followed; where these agree (an upright arm's first joint turns with the base), by its distance from the joint
    limits, then by the size of the turn. Nothing is optimised. The table `source` of the scene has the value
    written out, so that its scenario says what was planned.

    Raises:
        ScenarioError: the path cannot be followed at any turn; tells of the one where it could be followed farthest.
    """
    if not has_free_base(scene):
        return scene
    turns = sorted(range(-180 + STEP_DEG, 181, STEP_DEG), key=lambda turn: (abs(turn), -turn))
    choices: list[tuple[float, float, int, Scene]] = []
    nearest: tuple[float, int, Scene] | None = None
    for order, turn in enumerate(turns):
        candidate = _turn_base(scene, turn)
        reached = farthest_reached(candidate.robot, candidate.path, candidate.tray.tool)
        if reached == 1.0:  # else following it, which takes much longer, leads nowhere
            tried = try_joint_paths(candidate.robot, candidate.path, tool=candidate.tray.tool)
            reached += tried.reached
            if tried.paths:
                best = tried.paths[0]
                # rounded, so that turns of an upright arm compare by their margins and not by rounding errors
                choices.append(
                    (float(f"{best.speed_figure:.6g}"), -float(f"{best.limit_margin:.6g}"), order, candidate)
                )
        if nearest is None or reached > nearest[0]:
            nearest = reached, turn, candidate
    if not choices:
        assert nearest is not None  # there are turns
        _, turn, candidate = nearest
        failure = _failure(candidate)
        raise ScenarioError(
            f'[robot]: base_yaw is "free", but none of {len(turns)} turns of the base lets the arm '
            f"follow the path; the nearest to it: at {turn} deg, {failure}",
            failure.reason,
        )
    return min(choices, key=lambda entry: entry[:3])[3]


def base_yaw_text(scene: Scene) -> str:
    """The base yaw as the scenario writes it."""
    return str(_robot_table(scene).get("base_yaw", "0 deg"))


def _robot_table(scene: Scene) -> dict[str, Any]:
    table = scene.source["robot"]
    assert isinstance(table, dict)  # the reader saw to it
    return table


def _turn_base(scene: Scene, turn: int) -> Scene:
    table = scene.source | {"robot": _robot_table(scene) | {"base_yaw": f"{turn} deg"}}
    return scene_from_table(table, name=scene.name).limited_as(scene)


def _failure(scene: Scene) -> ScenarioError:
    """Why an arm cannot follow its path."""
    return try_joint_paths(scene.robot, scene.path, tool=scene.tray.tool).failure()
