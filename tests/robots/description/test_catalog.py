"""Every arm of the catalogue, and what happens with a name that is not in it."""

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.robots.description.catalog import ROBOTS, load_robot, robot_table
from tests.waiting import run_python


@pytest.mark.parametrize("name", ROBOTS)
def test_record_is_complete_and_constant(name):
    robot = load_robot(name)
    count = len(robot.joints)
    for array in (robot.lower, robot.upper, robot.max_speed):
        assert array.shape == (count,)
        assert not array.flags.writeable
    assert (robot.lower < robot.upper).all()
    assert (robot.max_speed > 0.1).all()
    assert (robot.max_speed < 16.0).all()
    for quantity in ("chain", "position", "speed"):
        assert robot.sources[quantity]
    if robot.max_acceleration is not None:
        assert robot.max_acceleration.shape == (count,)
        assert robot.sources["acceleration"]


@pytest.mark.parametrize("name", ROBOTS)
def test_urdf_says_the_same_as_the_data_file(name):
    robot = load_robot(name)
    tree = ElementTree.fromstring(robot.urdf)
    moving = [joint for joint in tree.iter("joint") if joint.get("type") != "fixed"]
    assert tuple(joint.get("name") for joint in moving) == robot.joints
    for index, joint in enumerate(moving):
        limit = joint.find("limit")
        assert limit is not None
        for key, array in (("lower", robot.lower), ("upper", robot.upper), ("velocity", robot.max_speed)):
            assert float(limit.get(key, "nan")) == pytest.approx(array[index], abs=1e-11)
    assert robot.tip in {link.get("name") for link in tree.iter("link")}
    assert not list(tree.iter("mesh"))


def test_smart_six_figures():
    robot = load_robot("comau-smart-six")
    np.testing.assert_allclose(np.degrees(robot.upper), [170, 155, 0, 210, 130, 2700])
    np.testing.assert_allclose(np.degrees(robot.max_speed), [140, 160, 170, 450, 375, 550])
    assert robot.max_acceleration is not None
    assert robot.max_acceleration.tolist() == [6.5, 8.5, 10, 15, 20, 20]
    assert "LAR-IRMA" in robot.sources["acceleration"]


def test_table_is_plain_and_round():
    (row,) = [row for row in robot_table() if row["name"] == "comau-smart-six"]
    assert row["reach_m"] == 1.4
    assert row["payload_kg"] == 6.0
    assert row["max_speed_deg_s"] == [140, 160, 170, 450, 375, 550]
    assert row["lower_deg"] == [-170, -85, -170, -210, -130, -2700]
    assert "joint torque" in load_robot("comau-smart-six").not_known
    assert [entry["name"] for entry in robot_table()] == list(ROBOTS)


def test_wrong_name_lists_what_there_is():
    with pytest.raises(ScenarioError, match=r"'comau-smart-6' is not in the catalogue.*did you mean 'comau-smart-six'"):
        load_robot("comau-smart-6")
    with pytest.raises(ScenarioError, match=r"known: .*comau-smart-six.*\)$"):
        load_robot("zzz")


def test_import_is_light():
    code = (
        "import sys, nospill.robots.joint_paths.search, nospill.robots.description.catalog;"
        "print([name for name in ('adam', 'scipy', 'eaik') if name in sys.modules])"
    )
    answer = run_python("-c", code, check=True)
    assert answer.stdout.strip() == "[]"
