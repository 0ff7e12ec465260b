"""Which branch is taken: the best, or the one near to where the arm comes from if it is nearly as good."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.robots.joint_paths.search import NEARLY_AS_FAST, JointPath, branch_in_words, preferred_path
from nospill.robots.robot import Robot
from nospill.scenario import read_scenario
from tests.builders import joint_paths_of


def made(start: float, figure: float) -> JointPath:
    q = np.full((2, 6), start)
    return JointPath(branch_in_words(q[0]), np.array([0.0, 1.0]), q, np.zeros((2, 6)), figure, 1.0)


@pytest.fixture(scope="module")
def arm() -> tuple[Robot, list[JointPath]]:
    scene = read_scenario("matrix-liquid")
    return scene.robot, joint_paths_of(scene)


def test_without_a_wish_the_best_is_taken(arm):
    robot, paths = arm
    assert preferred_path(paths, robot, None) is paths[0]


def test_every_branch_is_taken_by_an_arm_that_stands_there(arm):
    robot, paths = arm
    able = [path for path in paths if path.speed_figure <= NEARLY_AS_FAST * paths[0].speed_figure]
    assert len(able) > 1
    for path in able:
        assert preferred_path(paths, robot, path.q[0]) is path
        assert path.branch == branch_in_words(path.q[0])


def test_a_slow_branch_is_not_taken_however_near(arm):
    robot, _ = arm
    paths = [made(0.0, 1.0), made(1.0, 1.49), made(2.0, 1.51)]
    near = np.full(6, 2.0)
    assert preferred_path(paths, robot, near) is paths[1]
    assert preferred_path(paths[::2], robot, near) is paths[0]


def test_near_is_measured_by_the_time_of_each_joint(arm):
    robot, _ = arm
    slow = int(np.argmin(robot.max_speed))
    quick = int(np.argmax(robot.max_speed))
    first, second = made(0.0, 1.0), made(0.0, 1.0)
    first.q[0, slow], second.q[0, quick] = 1.0, 1.05
    assert robot.max_speed[quick] / robot.max_speed[slow] > 1.05
    assert preferred_path([first, second], robot, np.zeros(6)) is second


def test_a_long_way_of_one_joint_hides_no_other(arm):
    robot, _ = arm
    first, second = made(0.0, 1.0), made(0.0, 1.0)
    first.q[0, 0] = second.q[0, 0] = 3.0
    first.q[0, 3] = 3.1
    assert preferred_path([first, second], robot, np.zeros(6)) is second


def test_equals_keep_their_order(arm):
    robot, _ = arm
    paths = [made(1.0, 1.0), made(-1.0, 1.2)]
    assert preferred_path(paths, robot, np.zeros(6)) is paths[0]


def test_branches_in_words():
    assert branch_in_words(np.radians([0.2, -0.3, 89.6])) == "start (0, 0, 90) deg"
