"""Bounds on what the arm carries and its links: beside the distances of coal, and beside each other."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.collisions.along_path import slack_bounds
from nospill.collisions.bodies import Body
from nospill.collisions.box_bounds import ball_bounds, box_bounds
from nospill.collisions.distances import Distances, ball_gaps
from nospill.collisions.pairs import scene_pairs
from nospill.core.shapes import box_shape, capsule_shape
from nospill.robots.kinematics.frames import JointFrames, arm_chain, joint_frames
from nospill.scenario import load

CONFIGURATIONS = 40


def placed(seed: int) -> tuple[Body, Body, JointFrames]:
    """A box and a capsule, each fixed to a frame somewhere, the axis of the capsule along the box's in some."""
    random = np.random.default_rng(seed)
    turns = np.linalg.qr(random.normal(size=(2, CONFIGURATIONS, 3, 3)))[0]
    turns *= np.sign(np.linalg.det(turns))[..., None, None]
    turns[1, ::4] = turns[0, ::4]
    still = np.zeros((2, CONFIGURATIONS, 3))
    frames = JointFrames(random.uniform(-0.5, 0.5, (2, CONFIGURATIONS, 3)), turns, still, still)
    box = Body("box", 0, box_shape((0.4, 0.3, 0.02)), np.zeros(3), np.eye(3), on_path=True)
    return box, Body("rod", 1, capsule_shape(0.03, 0.5), np.array([0.0, 0.1, 0.0]), np.eye(3)), frames


@pytest.mark.parametrize("seed", range(5))
def test_the_box_gives_the_distance_of_a_box_and_the_ball_no_more(seed: int) -> None:
    box, rod, frames = placed(seed)
    true, _ = Distances(box, rod).at(frames, np.arange(CONFIGURATIONS))
    by_box, by_ball = box_bounds([(box, rod)], frames)[0][0], ball_bounds([(box, rod)], frames)[0]
    by_balls = ball_gaps([(box, rod)], frames)[0]
    apart = true > -rod.shape.ball
    assert np.all(by_balls <= by_ball + 1e-12)
    assert np.all(by_ball <= by_box + 1e-8)
    assert np.all(by_box[apart] <= true[apart] + 1e-7)
    assert by_box[apart] == pytest.approx(true[apart], abs=1e-6)
    assert np.count_nonzero(apart) > CONFIGURATIONS // 2


def test_bounds_that_are_enough_leave_the_signs_as_they_are() -> None:
    scene = load("mixed-tray")
    q = np.random.default_rng(3).uniform(scene.robot.lower, scene.robot.upper, (300, len(scene.robot.joints)))
    frames, pairs = joint_frames(arm_chain(scene.robot), q), scene_pairs(scene)
    fine, coarse = slack_bounds(pairs, frames), slack_bounds(pairs, frames, enough=0.0)
    assert np.array_equal(fine < 0.0, coarse < 0.0)
    assert np.all(coarse <= fine + 1e-9)
    broken = np.min(fine, axis=1) < 0.0
    assert 0 < np.count_nonzero(broken) < len(pairs)
    assert coarse[broken] == pytest.approx(fine[broken], abs=1e-12)
    assert slack_bounds([], frames).shape == (0, 300)
