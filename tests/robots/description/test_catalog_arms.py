"""The catalogue walked arm by arm: limits sane, a source for every figure, geometry as the sources state it."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

from nospill.robots.description.catalog import ROBOTS, load_robot, moved_robot, robot_table
from nospill.robots.description.urdf import read_arm
from nospill.robots.description.urdf_tree import read_tree
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.inertias import inertia_faults
from nospill.scenario.robot_entry import JointLimitsTable, RobotTable

FORWARD = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
UR_SIDEWAYS = [[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]

AT_ZERO = {
    # flange at all joints zero, summed by hand from the dimensions that the source named in the data file states, m
    "comau-smart-six": ((0.150 - 0.130, 0.0, 0.450 + 0.590 + 0.64707 + 0.095), np.eye(3)),
    "comau-racer-5-080": ((0.0, 0.0, 0.1895 + 0.1755 + 0.37 + 0.121 + 0.26494 + 0.0665), np.eye(3)),
    # Denavit-Hartenberg: x = -(a2 + a3), y = d4 + d6, z = d1 - d5, x forwards (half a turn from the controller's base)
    "ur5e": ((0.425 + 0.3922, 0.1333 + 0.0996, 0.1625 - 0.0997), UR_SIDEWAYS),
    "ur10e": ((0.6127 + 0.57155, 0.17415 + 0.11655, 0.1807 - 0.11985), UR_SIDEWAYS),
    "franka-fr3": ((0.088, 0.0, 0.333 + 0.316 + 0.384 - 0.107), np.diag([1.0, -1.0, -1.0])),
    "kuka-kr6-r900": ((0.025 + 0.455 + 0.420 + 0.080, 0.0, 0.400 + 0.035), FORWARD),
    "abb-irb1200-5-90": ((0.451 + 0.082, 0.0, 0.3991 + 0.448 + 0.042), FORWARD),
}

WRIST_REACH = {
    # shoulder-to-wrist-centre length plus the shoulder's offset from axis 1, from the same dimensions, m
    "comau-smart-six": 0.150 + 0.590 + np.hypot(0.64707, 0.130),
    "comau-racer-5-080": 0.05 + 0.37 + np.hypot(0.38594, 0.05),
    "kuka-kr6-r900": 0.025 + 0.455 + np.hypot(0.420, 0.035),
    "abb-irb1200-5-90": 0.448 + np.hypot(0.451, 0.042),
}


def test_the_table_is_complete():
    assert set(AT_ZERO) == set(ROBOTS)
    assert len(ROBOTS) >= 7
    assert any(len(load_robot(name).joints) == 7 for name in ROBOTS)


@pytest.mark.parametrize("name", ROBOTS)
def test_flange_at_zero_is_where_the_source_puts_it(name):
    robot = load_robot(name)
    (position,), (rotation,) = kinematics(robot).poses(np.zeros((1, len(robot.joints))))
    np.testing.assert_allclose(position, AT_ZERO[name][0], atol=1e-12)
    np.testing.assert_allclose(rotation, AT_ZERO[name][1], atol=1e-12)


@pytest.mark.parametrize("name", ROBOTS)
def test_reach_is_plausible(name):
    """The flange comes farther from axis 1 than the stated reach, to the wrist centre, but not by more than a hand."""
    robot = load_robot(name)
    assert robot.reach is not None
    generator = np.random.default_rng(0)
    q = generator.uniform(np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi), (20000, len(robot.joints)))
    positions = kinematics(robot).poses(q)[0]
    farthest = np.hypot(positions[:, 0], positions[:, 1]).max()
    assert 0.9 * robot.reach < farthest < robot.reach + 0.25
    if name in WRIST_REACH:
        assert WRIST_REACH[name] == pytest.approx(robot.reach, abs=1.5e-3)


@pytest.mark.parametrize("name", ROBOTS)
def test_every_figure_has_a_source(name):
    robot = load_robot(name)
    needed = {"chain", "position", "speed", "payload", "reach", "capsules"}
    for quantity, value in (
        ("acceleration", robot.max_acceleration),
        ("jerk", robot.max_jerk),
        ("torque", robot.max_torque),
        ("inertia", robot.inertias_known or None),
    ):
        if value is not None:
            needed.add(quantity)
        else:
            words = "link masses and inertias" if quantity == "inertia" else f"joint {quantity}"
            assert words in robot.not_known
    assert set(robot.sources) == needed | ({"braking"} if robot.braking is not None else set())
    assert all(len(source) > 15 for source in robot.sources.values())
    assert robot.not_known


@pytest.mark.parametrize("name", ROBOTS)
def test_limits_are_sane(name):
    robot = load_robot(name)
    count = len(robot.joints)
    for array, least, most in (
        (robot.max_acceleration, 1.0, 50.0),
        (robot.max_jerk, 100.0, 2e4),
        (robot.max_torque, 5.0, 500.0),
    ):
        if array is not None:
            assert array.shape == (count,) and not array.flags.writeable
            assert (array >= least).all() and (array <= most).all()
    assert robot.payload is not None and 2.0 < robot.payload < 20.0
    assert robot.max_torque is None or robot.inertias_known


@pytest.mark.parametrize("name", ROBOTS)
def test_home_carries_a_level_tray_away_from_the_limits(name):
    robot = load_robot(name)
    assert robot.home is not None and not robot.home.flags.writeable
    (position,), (rotation,) = kinematics(robot).poses(robot.home[None])
    assert np.minimum(robot.home - robot.lower, robot.upper - robot.home).min() > np.radians(9.0)
    np.testing.assert_allclose(rotation[:, 2], [0.0, 0.0, 1.0], atol=1e-12)
    assert robot.reach is not None and 0.3 < position[0] < robot.reach
    jacobian = kinematics(robot).jacobians(robot.home[None])[0]
    assert np.linalg.svd(jacobian, compute_uv=False)[-1] > 0.05  # not singular


@pytest.mark.parametrize("name", ROBOTS)
def test_data_file_and_description_agree(name):
    """Read as any user's URDF is read, the description gives the joints, tip, limits and torques of the data file."""
    robot = load_robot(name)
    arm = read_arm(robot.urdf, tip=robot.tip)
    assert arm.joints == robot.joints
    np.testing.assert_allclose(arm.lower, robot.lower, atol=1e-11)
    np.testing.assert_allclose(arm.upper, robot.upper, atol=1e-11)
    if robot.max_torque is None:
        assert np.isnan(arm.max_torque).all()
    else:
        np.testing.assert_array_equal(arm.max_torque, robot.max_torque)
    assert (inertia_faults(read_tree(robot.urdf), robot.joints).reason is None) == robot.inertias_known
    assert not [element for element in ElementTree.fromstring(robot.urdf).iter() if element.tag in ("visual", "mesh")]


def test_rows_are_json_ready():
    for row in robot_table():
        assert row["joint_count"] == len(row["joints"]) == len(row["home_deg"]) == len(row["lower_deg"])
        assert row["inertias_known"] in (True, False)
    (row,) = [row for row in robot_table() if row["name"] == "franka-fr3"]
    assert row["max_jerk_rad_s3"] == [5000.0] * 7
    assert row["max_torque_nm"] == [87.0] * 4 + [12.0] * 3
    assert row["braking_deceleration_rad_s2"][1:3] == [2.585, 3.5] and row["braking_offset_rad_s"][-1] == 0.35


def test_braking_is_that_of_the_joints_that_move_and_of_one_arm_alone():
    arm = load_robot("franka-fr3")
    assert [name for name in ROBOTS if load_robot(name).braking is not None] == [arm.name]
    locked = moved_robot(arm, locked={"fr3_joint3": "0 deg"}).braking
    assert arm.braking is not None and locked is not None
    np.testing.assert_array_equal(locked.upper, np.delete(arm.braking.upper, 2))
    assert (arm.braking.lower <= arm.lower).all() and (arm.braking.upper >= arm.upper).all()


def test_page_shows_the_catalogue():
    page = (Path(__file__).parents[3] / "docs" / "robots.md").read_text(encoding="utf-8")
    for row in robot_table():
        stated = [key for key in ("acceleration_rad_s2", "jerk_rad_s3", "torque_nm") if row[f"max_{key}"] is not None]
        limits = ", ".join(["position", "speed", *(key.split("_")[0] for key in stated)])
        cells = (
            f"`{row['name']}`",
            row["title"],
            row["joint_count"],
            f"{row['reach_m']:g}",
            f"{row['payload_kg']:g}",
            limits,
            "; ".join(row["not_known"]),
        )
        assert f"| {' | '.join(map(str, cells))} |\n" in page


def test_page_names_every_key():
    page = (Path(__file__).parents[3] / "docs" / "robots.md").read_text(encoding="utf-8")
    for key in (*RobotTable.model_fields, *JointLimitsTable.model_fields):
        assert f"`{key}`" in page or f"[robot.{key}]" in page, key
