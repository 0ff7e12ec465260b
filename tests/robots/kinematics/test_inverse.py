"""Inverse solutions: closure, completeness against random-start Newton, limits and turns; many poses at once."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.errors import ModelError, ScenarioError
from nospill.robots.description.catalog import load_robot
from nospill.robots.joint_paths.search import inverse_solutions, solve_joints
from nospill.robots.kinematics.closed_form import (
    TURN,
    approximate_solutions,
    count_turns,
    solutions_anywhere,
    with_turns,
)
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.newton import RESIDUAL, newton
from nospill.robots.kinematics.redundancy import redundant_joint
from nospill.robots.tool import Tool

ROBOT = load_robot("comau-smart-six")
ARM = kinematics(ROBOT)
TOOL = Tool(np.array([0.03, -0.05, 0.108]), 0.7)
# away from the wrist singularity, which has infinitely many solutions
JOINTS = st.tuples(
    *(
        st.floats(low, high)
        for low, high in ((-2.9, 2.9), (-1.4, 2.6), (-2.9, -0.1), (-3.6, 3.6), (0.1, 2.2), (-9.0, 9.0))
    )
).map(np.array)


# a seventh joint between wrist and flange, about x: the axis a URDF joint has when it states none
SEVEN = replace(
    ROBOT,
    urdf=ROBOT.urdf.replace('name="flange_fixed" type="fixed"', 'name="joint_7" type="continuous"'),
    joints=(*ROBOT.joints, "joint_7"),
)


def wrapped(q):
    return (q + np.pi) % (2 * np.pi) - np.pi


def distance(q, rows):
    """Largest joint difference, whole turns removed, to the nearest row."""
    return np.abs(wrapped(q - rows)).max(axis=1).min() if len(rows) else np.inf


@settings(max_examples=60, deadline=None)
@given(q=JOINTS)
def test_solutions_close_and_contain_where_we_came_from(q):
    position, rotation = (array[0] for array in ARM.poses(q[None], tool=TOOL))
    found = inverse_solutions(ROBOT, position, rotation, tool=TOOL)
    assert distance(q, found) < 1e-7
    positions, rotations = ARM.poses(found, tool=TOOL)
    assert np.abs(positions - position).max() < 1e-12
    assert np.abs(rotations - rotation).max() < 1e-12
    assert (found >= ROBOT.lower - 1e-9).all()
    assert (found <= ROBOT.upper + 1e-9).all()
    gaps = np.abs(found[:, None] - found[None]).max(axis=2) + np.eye(len(found))
    assert gaps.min() > 1e-6


def test_none_is_missed():
    """Newton from 500 random starts finds every solution of a six-joint arm; the closed form must have the same set."""
    generator = np.random.default_rng(11)
    counts = set()
    for _ in range(12):
        q = generator.uniform(np.maximum(ROBOT.lower, -np.pi), np.minimum(ROBOT.upper, np.pi))
        position, rotation = (array[0] for array in ARM.poses(q[None]))
        closed = solutions_anywhere(ROBOT, position, rotation)
        starts = generator.uniform(-np.pi, np.pi, size=(500, 6))
        reached, error = newton(
            ARM, np.tile(position, (500, 1)), np.tile(rotation, (500, 1, 1)), starts, max_iterations=60
        )
        brute = reached[error < RESIDUAL]
        assert len(brute) > 100
        assert max(distance(row, closed) for row in brute) < 1e-6
        assert max(distance(row, brute) for row in closed) < 1e-6
        counts.add(len(closed))
    assert counts <= {2, 4, 6, 8}
    assert 8 in counts


def test_turns_of_the_last_joint_stay_near_the_middle():
    position, rotation = (array[0] for array in ARM.poses(np.array([[0.3, 0.2, -1.5, 0.4, 1.0, 0.5]])))
    found = inverse_solutions(ROBOT, position, rotation)
    assert np.abs(found[:, 5]).max() <= 2 * np.pi
    same_arm = found[np.abs(found[:, :5] - [0.3, 0.2, -1.5, 0.4, 1.0]).max(axis=1) < 1e-9]
    np.testing.assert_allclose(np.sort(same_arm[:, 5]), [0.5 - 2 * np.pi, 0.5], atol=1e-9)


def test_limits_have_an_effect():
    position, rotation = (array[0] for array in ARM.poses(np.array([[0.3, 0.2, -1.5, 0.4, 1.0, 0.5]])))
    narrow = replace(ROBOT, lower=np.array([-1, -1, -2, -1, 0, -1.0]), upper=np.array([1, 1, 0, 1, 2, 1.0]))
    assert len(inverse_solutions(narrow, position, rotation)) == 1
    assert len(inverse_solutions(ROBOT, position, rotation)) > 1


def test_out_of_reach_has_no_solution():
    assert inverse_solutions(ROBOT, np.array([3.0, 0, 1]), np.eye(3)).shape == (0, 6)


def test_seven_joints_are_distinguished():
    with pytest.raises(ScenarioError, match="has 7 moving joints"):
        inverse_solutions(SEVEN, np.array([0.6, 0, 1]), np.eye(3))


def test_solve_joints_in_bulk():
    generator = np.random.default_rng(5)
    q = generator.uniform([-2, -1, -2.5, -3, 0.3, -3], [2, 1, -0.5, 3, 2, 3], size=(1000, 6))
    positions, rotations = ARM.poses(q, tool=TOOL)
    solved = solve_joints(ROBOT, positions, rotations, q + generator.normal(scale=0.01, size=q.shape), tool=TOOL)
    assert np.abs(solved - q).max() < 1e-9
    reached, turned = ARM.poses(solved, tool=TOOL)
    assert max(np.abs(reached - positions).max(), np.abs(turned - rotations).max()) < 1e-13
    assert solve_joints(ROBOT, positions[:0], rotations[:0], q[:0]).shape == (0, 6)


def test_solve_joints_takes_redundant_arms():
    """Any exact answer near the guess will do."""
    guess = np.tile([0.3, 0.2, -1.5, 0.4, 1.0, 0.5, 0.1], (20, 1))
    positions, rotations = kinematics(SEVEN).poses(
        guess + np.random.default_rng(1).normal(scale=0.05, size=guess.shape)
    )
    solved = solve_joints(SEVEN, positions, rotations, guess)
    reached, turned = kinematics(SEVEN).poses(solved)
    assert max(np.abs(reached - positions).max(), np.abs(turned - rotations).max()) < RESIDUAL
    assert np.abs(solved - guess).max() < 0.4


def test_solve_joints_converges_from_half_a_turn():
    position, rotation = ARM.poses(np.array([[0.3, 0.2, -1.5, 0.4, 1.0, 0.5]]))
    solved = solve_joints(ROBOT, position, rotation, np.array([[0.3, 0.2, -1.5, 0.4, 1.0, 0.5 + np.pi]]))
    np.testing.assert_allclose(ARM.poses(solved)[1], rotation, atol=1e-12)


@pytest.mark.parametrize("bad", [3.0, np.nan])
def test_solve_joints_names_the_worst_sample(bad):
    q = np.tile([0.3, 0.2, -1.5, 0.4, 1.0, 0.5], (5, 1))
    positions, rotations = ARM.poses(q)
    positions[3, 0] = bad
    with pytest.raises(ModelError, match=r"1 of 5 tray poses; worst is sample 3 at .* allowed 1e-11"):
        solve_joints(ROBOT, positions, rotations, q)


TURNS = np.array(list(product((-1, 0, 1), (-1, 0, 1), (-1, 0, 1), range(-2, 3), (-1, 0, 1), range(-3, 4))))
"""Whole turns of the joints: all that any limits leave, and more."""


@settings(max_examples=60, deadline=None)
@given(st.lists(JOINTS, max_size=4))
def test_whole_turns_are_all_that_the_limits_leave_in_their_order(rows):
    # Rounded: of an angle of 1e-15 it is rounding that tells whether a whole turn more is within the limits.
    q = np.round(np.array(rows), 9).reshape(-1, 6)
    middle = 0.5 * (ROBOT.lower + ROBOT.upper)
    lowest, highest = np.maximum(ROBOT.lower, middle - TURN), np.minimum(ROBOT.upper, middle + TURN)
    turned = q[:, None] + TURN * TURNS
    expected = turned[np.all((turned >= lowest) & (turned <= highest), axis=2)]
    found = with_turns(ROBOT, q)
    assert np.allclose(found, expected, rtol=0.0, atol=1e-12)
    assert count_turns(ROBOT, q).tolist() == [len(with_turns(ROBOT, row[None])) for row in q]


@settings(max_examples=30, deadline=None)
@given(st.lists(JOINTS, min_size=1, max_size=4))
def test_the_closed_form_of_many_poses_is_that_of_each_to_six_digits(rows):
    positions, rotations = ARM.poses(np.array(rows), tool=TOOL)
    found = approximate_solutions(ROBOT, positions, rotations, tool=TOOL)
    assert len(found) == len(rows)
    for position, rotation, some in zip(positions, rotations, found, strict=True):
        exact = solutions_anywhere(ROBOT, position, rotation, tool=TOOL)
        assert all(distance(q, some) < 1e-5 for q in exact)


def test_the_closed_form_with_a_held_joint_is_that_of_each_position():
    """Every pose with a position of its own of the seventh joint, some without a solution."""
    arm = load_robot("franka-fr3")
    joint = redundant_joint(arm)
    assert joint is not None
    q = np.random.default_rng(0).uniform(arm.lower, arm.upper, (20, 7))
    positions, rotations = kinematics(arm).poses(q)
    positions[3] += 2.0
    found = approximate_solutions(arm, positions, rotations, held=(joint, q[:, joint]))
    assert len(found[3]) == 0
    for index, (position, rotation, some) in enumerate(zip(positions, rotations, found, strict=True)):
        assert np.all(some[:, joint] == q[index, joint])
        exact = solutions_anywhere(arm, position, rotation, held=(joint, float(q[index, joint])))
        assert all(distance(own, some) < 1e-5 for own in exact)
