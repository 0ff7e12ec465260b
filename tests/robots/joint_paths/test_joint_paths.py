"""Joint paths along a tray path: they follow it, never jump, keep the limits, and say why when there is none."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.errors import ScenarioError
from nospill.paths.path import preset_path, straight_line
from nospill.robots.description.catalog import load_robot
from nospill.robots.joint_paths.following import tray_poses
from nospill.robots.joint_paths.search import inverse_solutions, joint_paths, solve_joints
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.tool import Tool

ROBOT = load_robot("comau-smart-six")
TOOL = Tool(np.array([0.0, 0.0, 0.108]))


@pytest.fixture(scope="module")
def arc():
    return preset_path("arc", yaw=[0.0, np.pi])


@pytest.fixture(scope="module")
def arc_joints(arc):
    return joint_paths(ROBOT, arc, tool=TOOL)


def check(path, found, *, robot=ROBOT, tool=TOOL):
    """What every joint path promises."""
    arm = kinematics(robot)
    for way in found:
        positions, rotations = tray_poses(path, way.s)
        reached, turned = arm.poses(way.q, tool=tool)
        assert np.abs(reached - positions).max() < 1e-11
        assert np.abs(turned - rotations).max() < 1e-11
        assert (way.q >= robot.lower - 1e-9).all()
        assert (way.q <= robot.upper + 1e-9).all()
        room = np.minimum(way.q - robot.lower, robot.upper - way.q).min()
        assert way.limit_margin == pytest.approx(room)
        assert way.speed_figure == pytest.approx((np.abs(way.dq_ds) / robot.max_speed).max())
        assert not way.q.flags.writeable
    figures = [way.speed_figure for way in found]
    assert figures == sorted(figures) or np.diff(figures).min() > -1e-5 * max(figures)


def test_arc_has_two_arms_by_whole_turns(arc, arc_joints):
    """Elbow up in front, the wrist either way up, joint 4 on either side, joint 6 by turns."""
    check(arc, arc_joints)
    assert len(arc_joints) == 6
    assert len({way.branch for way in arc_joints}) == 6
    assert sorted(round(float(np.degrees(way.q[0, 4]))) for way in arc_joints) == [-101, -101, 101, 101, 101, 101]
    best = arc_joints[0]
    assert best.q[0, 4] < 0
    assert abs(best.q[:, 5].mean()) < np.pi / 2 + 0.01


def test_arc_level_tray_keeps_the_forearm_unturned(arc_joints):
    """Flange straight up: joint 4 stays at zero and joint 6 undoes joint 1 and adds the yaw."""
    best = arc_joints[0]
    assert np.abs(best.q[:, 3]).max() < 1e-12
    # flange up with q4 = 0: q2 - q3 + q5 = 0
    np.testing.assert_allclose(best.q[:, 1] - best.q[:, 2] + best.q[:, 4], 0, atol=1e-11)
    np.testing.assert_allclose(wrapped(-best.q[:, 0] - best.q[:, 5] - np.pi * best.s), 0, atol=1e-11)


def wrapped(q):
    return (q + np.pi) % (2 * np.pi) - np.pi


def test_arc_slope_and_interpolation(arc, arc_joints):
    way = arc_joints[0]
    step = way.s[1]
    central = (way.q[2:] - way.q[:-2]) / (2 * step)
    # second-order difference on a quartic spline with steep ends
    assert np.abs(central - way.dq_ds[1:-1]).max() < 0.03
    dense = np.linspace(0, 1, 1733)
    exact = solve_joints(ROBOT, *tray_poses(arc, dense), way.at(dense), tool=TOOL)
    assert np.abs(way.at(dense) - exact).max() < 1e-5
    np.testing.assert_array_equal(way.at(way.s)[:-1], way.q[:-1])


@settings(max_examples=25, deadline=None)
@given(
    start=st.tuples(st.floats(0.45, 0.7), st.floats(-0.4, 0.4), st.floats(1.05, 1.3)),
    end=st.tuples(st.floats(0.45, 0.7), st.floats(-0.4, 0.4), st.floats(1.05, 1.3)),
    turn=st.floats(-1.5, 1.5),
)
def test_branches_are_continuous_and_all_there(start, end, turn):
    if np.linalg.norm(np.subtract(start, end)) < 0.05:
        return
    path = straight_line(start, end, yaw=[0.3, 0.3 + turn])
    found = joint_paths(ROBOT, path, tool=TOOL)
    check(path, found)
    for way in found:
        # the exact slope integrates to the samples: no jump to another branch
        steps = np.diff(way.q, axis=0)
        trapezoid = 0.5 * (way.dq_ds[1:] + way.dq_ds[:-1]) * np.diff(way.s)[:, None]
        assert np.abs(steps - trapezoid).max() < 1e-3
    # the closed form at the far end knows each of them
    positions, rotations = tray_poses(path, np.array([1.0]))
    ends = inverse_solutions(ROBOT, positions[0], rotations[0], tool=TOOL)
    for way in found:
        assert np.abs(wrapped(way.q[-1] - ends)).max(axis=1).min() < 1e-7


def test_close_to_the_first_axis_small_steps_keep_the_branch():
    """The wrist passes 5 mm beside axis 1: joint 1 turns by almost half a turn within a few samples."""
    path = straight_line((0.5, 0.005, 1.5), (-0.5, 0.005, 1.5))
    free = replace(ROBOT, lower=np.full(6, -50.0), upper=np.full(6, 50.0))
    found = joint_paths(free, path, samples=21, tool=TOOL)
    check(path, found, robot=free)
    turned = {round(float(np.degrees(abs(way.q[-1, 0] - way.q[0, 0])))) for way in found}
    assert turned == {179}


def test_tray_yaw_on_the_flange_turns_only_the_last_joint(arc):
    plain = joint_paths(ROBOT, arc, tool=TOOL)[0]
    turned = joint_paths(ROBOT, arc, tool=replace(TOOL, yaw=0.4))
    check(arc, turned, tool=replace(TOOL, yaw=0.4))
    shift = wrapped(turned[0].q - plain.q)
    np.testing.assert_allclose(shift[:, :5], 0, atol=1e-10)
    np.testing.assert_allclose(np.abs(shift[:, 5]), 0.4, atol=1e-10)


def test_out_of_reach_says_from_where_and_how_far():
    """Straight out along x: the arm is stretched when the wrist is its two lengths from the shoulder."""
    path = straight_line((0.9, 0, 1.2), (2.0, 0, 1.2))
    upper_arm, forearm = 0.590, np.hypot(0.130, 0.64707)
    height = 1.2 - 0.108 - 0.095 - 0.450
    stretched = 0.150 + np.sqrt((upper_arm + forearm) ** 2 - height**2)
    beyond = np.hypot(2.0 - 0.150, height) - upper_arm - forearm
    with pytest.raises(ScenarioError) as caught:
        joint_paths(ROBOT, path, tool=TOOL)
    message = str(caught.value)
    edge = f"s = {(stretched - 0.9) / 1.1:.3f} (x, y, z = {1000 * stretched:.0f}, 0, 1200 mm)"
    assert f"from {edge} on" in message
    assert f"by up to {1000 * beyond:.4g} mm at s = 1.000 (x, y, z = 2000, 0, 1200 mm)" in message
    assert "\n" not in message


def test_start_out_of_reach():
    with pytest.raises(
        ScenarioError,
        match=r"out of reach of robot 'comau-smart-six' .* from s = 0\.000 \(x, y, z = 3000, 0, 1000 mm\) on",
    ):
        joint_paths(ROBOT, straight_line((3, 0, 1), (0.8, 0, 1)), tool=TOOL)


def test_joint_limit_in_the_way_is_named(arc, arc_joints):
    highest = arc_joints[0].q[:, 0].max()
    where = arc_joints[0].s[int(np.argmax(arc_joints[0].q[:, 0] > 1.0))]
    narrow = replace(ROBOT, upper=np.array([1.0, *ROBOT.upper[1:]]))
    with pytest.raises(ScenarioError) as caught:
        joint_paths(narrow, arc, tool=TOOL)
    message = str(caught.value)
    assert "passes the upper limit of joint_1 (57.2958 deg)" in message
    assert f"by {np.degrees(highest - 1.0):.3g} deg" in message
    assert f"from s = {where:.3f} (x, y, z = " in message


def test_lower_limit_in_the_way():
    with pytest.raises(ScenarioError, match=r"passes the lower limit of joint_2 \(-85 deg\) by 7\.99 deg"):
        joint_paths(ROBOT, straight_line((0.6, 0.0, 1.0), (0.1, 0.02, 1.0)), tool=TOOL)


def test_singularity_in_the_way():
    """The wrist passes a thousandth of a micrometre beside axis 1: half a turn of joint 1 in no time."""
    with pytest.raises(ScenarioError, match=r"all \d branches end in a singularity, the last near s = 0\.5"):
        joint_paths(ROBOT, straight_line((0.5, 1e-9, 1.5), (-0.5, 1e-9, 1.5)), tool=TOOL)


@pytest.mark.parametrize(("name", "yaw"), [("ark", (0.0, 0.0)), ("pp", (0.0, 0.0)), ("sl", (0.0, np.pi / 2))])
def test_published_paths_can_be_followed(name, yaw):
    path = preset_path(name, yaw=yaw)
    check(path, joint_paths(ROBOT, path, tool=TOOL))
