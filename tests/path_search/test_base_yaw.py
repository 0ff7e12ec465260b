"""The free base yaw: one is found that lets the arm follow the path, and the scene says which."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.path_search.base_yaw import base_yaw_text, choose_base_yaw, has_free_base
from nospill.robots.joint_paths.search import joint_paths
from nospill.scenario import scene_from_table
from nospill.scene.scene import Scene


def best_figure(scene: Scene) -> float:
    tool = scene.tray.tool
    return joint_paths(scene.robot, scene.path, tool=tool)[0].speed_figure


def test_a_base_that_is_given_is_left_alone(changed_scene):
    scene = changed_scene("matrix-liquid", {"robot.base_yaw": "10 deg"})
    assert not has_free_base(scene)
    assert choose_base_yaw(scene) is scene


def test_of_equal_turns_the_smallest_is_taken(changed_scene):
    """An upright arm's first joint turns with the base: only its limits can tell the turns apart."""
    scene = changed_scene("matrix-liquid", {"robot.base_yaw": "free"})
    found = choose_base_yaw(scene)
    assert base_yaw_text(found) == "0 deg" and not has_free_base(found)
    assert best_figure(found) == pytest.approx(best_figure(changed_scene("matrix-liquid", {})), rel=1e-9)


def narrow(scene: Scene, reach: float) -> dict[str, list[float]]:
    """The robot's own limits, but joint_1 within +-reach, rad."""
    return {"lower": [-reach, *scene.robot.lower[1:].tolist()], "upper": [reach, *scene.robot.upper[1:].tolist()]}


def test_a_path_behind_the_arm_is_reached_by_turning_it(changed_scene):
    """With joint_1 within +-91 deg the arm reaches a path on its other side only when its base is turned."""
    ahead = changed_scene("matrix-liquid", {})
    limits = {"robot.limits": narrow(ahead, 1.6)}
    # the path turned half about the base: both preset's ends lie at x > 0 and now behind the arm
    points = ahead.path.at(np.linspace(0.0, 1.0, 9))[:, :3] * [-1.0, -1.0, 1.0]
    path = {"type": "waypoints", "points": points.tolist(), "yaw": ["180 deg", "360 deg"]}
    with pytest.raises(ScenarioError):
        best_figure(changed_scene("matrix-liquid", limits | {"path": path}))
    found = choose_base_yaw(changed_scene("matrix-liquid", limits | {"path": path, "robot.base_yaw": "free"}))
    assert best_figure(found) > 0.0
    assert abs(float(base_yaw_text(found).removesuffix(" deg"))) >= 150.0


@pytest.mark.slow
def test_an_arm_that_leans_gains_by_turning_and_the_copy_says_so(changed_scene):
    leaning = {"robot.base_roll": "30 deg"}
    scene = changed_scene("matrix-liquid", leaning | {"robot.base_yaw": "free"})
    found = choose_base_yaw(scene)
    figures = []
    for turn in range(-150, 181, 30):
        try:
            figures.append(best_figure(changed_scene("matrix-liquid", leaning | {"robot.base_yaw": f"{turn} deg"})))
        except ScenarioError:
            continue
    assert best_figure(found) == pytest.approx(min(figures), rel=1e-6)
    table = tomllib.loads(found.text())
    assert table["robot"]["base_yaw"] == base_yaw_text(found) != "free"
    again = scene_from_table(table, name="again")
    assert again.robot.urdf == found.robot.urdf
    assert np.array_equal(again.robot.lower, found.robot.lower)


def test_where_no_turn_helps_the_best_failure_is_reported(changed_scene):
    limits = narrow(changed_scene("matrix-liquid", {}), 0.5)
    scene = changed_scene("matrix-liquid", {"robot.limits": limits, "robot.base_yaw": "free"})
    with pytest.raises(ScenarioError) as caught:
        choose_base_yaw(scene)
    text = str(caught.value)
    assert text.startswith('[robot]: base_yaw is "free", but none of 12 turns')
    assert "joint_1" in text and " deg, " in text and "\n" not in text
