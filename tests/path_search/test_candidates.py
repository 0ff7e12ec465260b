"""`type = "free"`: from here to there; what is refused, and along which ways a motion is looked for."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from benchmarks.carry.draw import PROBLEMS, read_problems
from nospill.errors import NoSolutionError, ScenarioError
from nospill.path_search.candidates import feasible_paths, has_free_path, path_candidates
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene

START: dict[str, Any] = {"position": ["154 mm", "-600 mm", "1220 mm"], "yaw": "10 deg"}
GOAL: dict[str, Any] = {"position": ["154 mm", "600 mm", "1220 mm"], "yaw": "180 deg"}


def scene_of(start: object = START, goal: object = GOAL, *, example: str = "matrix-rigid", **keys: object) -> Scene:
    table = read_scenario(example).source
    return scene_from_table({**table, "path": {"type": "free", "start": start, "goal": goal, **keys}}, name="free")


def test_it_is_a_straight_line_until_a_way_is_chosen() -> None:
    scene = scene_of()
    assert has_free_path(scene) and scene.motion.yaw_free
    assert scene.motion.corridor == pytest.approx(1.2)  # as far as the goal is from the start
    places = scene.path.at([0.0, 0.5, 1.0])
    np.testing.assert_allclose(places[:, 1], [-0.6, 0.0, 0.6], atol=1e-12)
    np.testing.assert_allclose(np.degrees(places[[0, 2], 3]), [10.0, 180.0])
    assert scene_of(corridor="300 mm").motion.corridor == pytest.approx(0.3)


def test_past_the_foot_of_the_arm_it_goes_round() -> None:
    scene = scene_of()
    found = feasible_paths(scene)
    best = found[0].scene
    assert not has_free_path(best)
    places = best.path.at(np.linspace(0.0, 1.0, 50))
    np.testing.assert_allclose(np.hypot(*places[:, :2].T), np.hypot(0.154, 0.6), atol=2e-3)
    assert places[25, 0] > 0.6  # the short way round, in front of the arm
    np.testing.assert_allclose(best.path.at([0.0, 1.0]), scene.path.at([0.0, 1.0]), atol=1e-9)
    again = scene_from_table(best.source, name="free")  # as the copy that is kept with a plan is read
    np.testing.assert_array_equal(again.path.coefficients, best.path.coefficients)


def test_where_the_line_is_the_fastest_it_stays() -> None:
    scene = scene_of({"position": [0.6, 0.0, 1.2]}, {"position": [0.85, 0.0, 1.2]})
    assert feasible_paths(scene)[0].scene is scene


@pytest.mark.parametrize("end", ["start", "goal"])
def test_an_end_out_of_reach_is_refused_whatever_the_way(end: str) -> None:
    said = rf"path: the {end}, s = \d\.000 \(x, y, z = 3000, 600, 1200 mm\), is out of reach of robot 'comau-smart-six'"
    far = {"position": [3.0, 0.6, 1.2]}
    with pytest.raises(ScenarioError, match=said) as caught:
        feasible_paths(scene_of(far if end == "start" else START, far if end == "goal" else GOAL))
    assert caught.value.exit_code == 2
    reason = caught.value.reason
    assert reason is not None and reason.excess is not None and 1.0 < reason.excess < 2.0


def test_an_end_outside_of_the_joint_limits_is_refused_whatever_the_way() -> None:
    """Where the arm stretches out, joint 3 is above -93 deg."""
    far = {"position": [1.3, 0.0, 0.8]}
    table = read_scenario("matrix-rigid").source
    limits = {"upper": ["170 deg", "155 deg", "-93 deg", "210 deg", "130 deg", "2700 deg"]}
    table["robot"] = {**table["robot"], "limits": limits}  # type: ignore[dict-item]
    scene = scene_from_table({**table, "path": {"type": "free", "start": far, "goal": GOAL}}, name="free")
    said = r"path: the start, s = 0\.000 .* is reached by robot 'comau-smart-six' outside of its joint limits only; .* "
    with pytest.raises(ScenarioError, match=said + r"passes the upper limit of joint_3 \(-93 deg\) by") as caught:
        feasible_paths(scene)
    assert caught.value.exit_code == 2 and caught.value.reason is not None
    assert caught.value.reason.subject == "joint_3"


def test_ways_that_the_arm_cannot_follow_are_not_found_and_not_refused() -> None:
    """From behind the arm to its front: with a level tray it has to pass a singularity, which a motion does."""
    table = {key: value for key, value in read_problems(PROBLEMS)[61]["table"].items() if key != "obstacle"}
    with pytest.raises(NoSolutionError, match=r"^No way found: the arm cannot follow any of the \d ways") as caught:
        feasible_paths(scene_from_table(table, name="behind"))
    assert caught.value.exit_code == 3
    assert re.search(r"; of the first one, no way to follow it keeps all joint limits of robot", str(caught.value))


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"goal": START}, r"\[path\]: goal is the start, place and yaw; give another one"),
        ({"goal": {"yaw": 1.0}}, r"\[path\]: goal: position is missing; give it, or joints"),
        ({"start": {**START, "jaw": 1.0}}, r'\[path.start\]: unknown key "jaw"; allowed here: position, yaw, joints'),
        ({"start": [1.0, 2.0, 3.0]}, r"\[path\]: start is not a table"),
        ({"goal": {"position": [1.0, 2.0]}}, r"\[path.goal\]: position \[1.0, 2.0\] has 2 values where 3 are needed"),
        ({"yaw": "free"}, r'\[path\]: unknown key "yaw"; allowed here: corridor, type, start, goal, via, region, way'),
        ({"corridor": "0 mm"}, "it must be at least 0.1 mm"),
        ({"way": [[0.154, -0.6, 1.22], [0.2, 0.0, 1.2]]}, "way: its end at the goal is 602 mm away from it"),
    ],
)
def test_refused(keys: dict[str, object], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        scene_of(**{"start": START, "goal": GOAL, **keys})


def test_the_path_of_a_possible_way_is_that_of_its_scene() -> None:
    """It is made without reading the whole scenario anew."""
    table = read_problems(PROBLEMS)[2]["table"]
    scene = scene_from_table(table, name="shelf")
    looked_at = [*path_candidates(scene)]
    assert looked_at[0].scene() is scene and len(looked_at) == 41
    for way in looked_at[1::10]:
        made = way.scene()
        np.testing.assert_array_equal(made.path.coefficients, way.path.coefficients)
        np.testing.assert_array_equal(made.path.breaks, way.path.breaks)
