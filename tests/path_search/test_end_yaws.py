"""`yaw = "free"` at the ends of a free path: which yaws are taken, against all others, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import nospill as ns
from nospill.errors import ScenarioError
from nospill.path_search.end_yaws import STEP, choose_end_yaws, free_ends
from nospill.robots.description.urdf_tree import about_axis
from nospill.robots.kinematics.closed_form import inverse_solutions
from tests.builders import one_mode
from tests.motions import gentle_plan

HERE, THERE = [0.5, -0.35, 0.35], [0.35, 0.45, 0.45]
YAW, TURNED = -1.8, -0.66  # the tray away from the arm at each


def scene(start: dict[str, Any], goal: dict[str, Any], **others: Any) -> ns.Scene:
    keys = {"path": {"type": "free", "start": {"position": HERE} | start, "goal": {"position": THERE} | goal}}
    return one_mode("bracket-tray").changed(keys | others)


def least_time(whole: ns.Scene, yaws: tuple[float, float]) -> float:
    """Of the slowest joint at full speed from any configuration at the start to any at the goal, s."""
    ends = []
    for position, yaw in zip((HERE, THERE), yaws, strict=True):
        turn = about_axis((0.0, 0.0, 1.0), yaw)
        ends.append(inverse_solutions(whole.robot, np.array(position), turn, tool=whole.tray.tool))
    if not all(map(len, ends)):
        return math.inf
    return float(np.min(np.max(np.abs(ends[0][:, None] - ends[1]) / whole.robot.max_speed, axis=2)))


@pytest.mark.parametrize("free", [("goal",), ("start",)])
def test_no_other_yaw_of_the_grid_has_nearer_joints(free: tuple[str, ...]) -> None:
    stated: dict[str, Any] = {
        end: {"yaw": "free" if end in free else yaw} for end, yaw in (("start", YAW), ("goal", TURNED))
    }
    whole = scene(**stated)
    assert free_ends(whole) == free
    chosen = choose_end_yaws(whole)
    assert free_ends(chosen) == () and chosen.source["path"][free[0]]["yaw"].endswith(" deg")
    start, goal = chosen.path.at([0.0, 1.0])[:, 3].tolist()
    assert abs(goal - start) <= math.pi
    grid = np.arange(-math.pi, math.pi, STEP)
    pairs = [(YAW, yaw) if free == ("goal",) else (yaw, TURNED) for yaw in grid.tolist()]
    times = sorted(least_time(whole, pair) for pair in pairs)
    # of the best few the one that can be followed fastest is taken
    assert least_time(whole, (start, goal)) <= times[5] + 1e-6
    assert choose_end_yaws(whole).path.at([0.0, 1.0]).tolist() == chosen.path.at([0.0, 1.0]).tolist()


def test_both_ends_together_are_no_worse_than_either() -> None:
    one, both = (
        choose_end_yaws(scene(start, {"yaw": "free"})).path.at([0.0, 1.0])[:, 3].tolist()
        for start in ({"yaw": YAW}, {"yaw": "free"})
    )
    whole = scene({"yaw": YAW}, {"yaw": YAW})
    assert least_time(whole, tuple(both)) <= least_time(whole, tuple(one)) + 0.05


@pytest.mark.slow
def test_a_yaw_in_the_way_of_an_obstacle_is_not_taken() -> None:
    """At the goal a post stands where a corner of the tray would be."""
    free = {"yaw": YAW}, {"yaw": "free"}
    bare = choose_end_yaws(scene(*free)).path.at([1.0])[0, 3]
    x, y, z = THERE
    corner = np.array([0.11, 0.07])
    at = about_axis((0.0, 0.0, 1.0), float(bare))[:2, :2] @ corner + [x, y]
    post = {"name": "post", "shape": "box", "at": [*at.tolist(), z - 0.02], "size": ["20 mm", "20 mm", "40 mm"]}
    chosen = choose_end_yaws(scene(*free, obstacle=[post])).path.at([1.0])[0, 3]
    assert abs(math.remainder(float(chosen - bare), math.tau)) > STEP / 2


@pytest.mark.parametrize(
    ("start", "goal", "others", "message"),
    [
        ({}, {"yaw": "fre"}, {}, r'goal.*yaw "fre" is not an angle; .*; the word "free" is possible too'),
        ({"yaw": "free"}, {}, {"robot.base_yaw": "free"}, r"start.yaw and robot.base_yaw are both free; state one"),
        ({"position": None, "joints": [0.0] * 6, "yaw": "free"}, {}, {}, "joints stand in the place of position and"),
        ({"yaw": "free"}, {"position": HERE, "yaw": "free"}, {}, "goal is the start, place and yaw"),
    ],
)
def test_what_cannot_mean_anything_is_refused(
    start: dict[str, Any], goal: dict[str, Any], others: dict[str, Any], message: str
) -> None:
    with pytest.raises(ScenarioError, match=message) as caught:
        scene(start, goal, **others)
    assert len(str(caught.value).splitlines()) == 1


def test_a_place_out_of_reach_is_named() -> None:
    with pytest.raises(
        ScenarioError, match=r"path.goal: the arm cannot hold the tray there, at any of 24 yaws: .*reach"
    ):
        choose_end_yaws(scene({}, {"position": [2.0, 0.0, 0.4], "yaw": "free"}))


def test_a_layout_does_not_move_under_a_free_yaw() -> None:
    with pytest.raises(ScenarioError, match=r'path.goal.yaw = "free" is chosen anew for every layout; state an angle'):
        ns.layout(scene({}, {"yaw": "free"}), {"cargo.*.at": None})


def test_the_next_motion_begins_with_the_yaw_in_which_the_arm_stands() -> None:
    before = gentle_plan("pp-two-cups")
    x, y, z, yaw = before.scene.path.at([1.0])[0].tolist()
    goal = before.scene.path.at([0.0])[0, :3].tolist()
    free = {"type": "free", "start": {"position": [x, y, z], "yaw": "free"}, "goal": {"position": goal}}
    after = before.scene.changed({"path": free, "name": "back"})
    going_on = ns.with_residual_slosh(after, before)
    assert free_ends(going_on) == ()
    assert going_on.path.at([0.0])[0, 3] == pytest.approx(yaw, abs=1e-6)
    assert going_on.path.ends[0] == pytest.approx(before.trajectory.joint_position[-1], abs=1e-6)


@pytest.mark.slow
def test_a_motion_to_a_free_yaw_is_certified_and_states_it() -> None:
    few = {"planning.intervals": 30, "cargo": one_mode("bracket-tray").source["cargo"][:1]}
    found = ns.plan(scene({"yaw": YAW}, {"yaw": "free"}, **few))
    assert found.certificate.ok and str(found.report.end_yaws) in found.text()
    assert found.scene.source["path"]["goal"]["yaw"] in str(found.report.end_yaws)
