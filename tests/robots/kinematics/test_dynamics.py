"""Inverse dynamics against Pinocchio, against energy, against closed forms; and how large the expression is."""

from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.robots.description.catalog import ROBOTS, load_robot, moved_robot
from nospill.robots.description.urdf import BasePose
from nospill.robots.kinematics.dynamics import Load, dynamics, joint_torque, joint_torques, load_column, load_of
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.tool import Tool

REAL = [name for name in ROBOTS if load_robot(name).inertias_known]
GRAVITY = 9.80665


def random_states(robot, count, seed=0):
    generator = np.random.default_rng(seed)
    q = generator.uniform(np.maximum(robot.lower, -6.0), np.minimum(robot.upper, 6.0), size=(count, len(robot.joints)))
    return q, robot.max_speed * generator.uniform(-1, 1, q.shape), 20.0 * generator.uniform(-1, 1, q.shape)


def random_load(seed=1):
    generator = np.random.default_rng(seed)
    root = 0.05 * generator.normal(size=(3, 3))
    return load_of(2.3, generator.uniform(-0.2, 0.2, 3), root @ root.T + 1e-3 * np.eye(3))


def test_arms_with_real_inertias_are_known():
    assert REAL == ["ur5e", "ur10e", "franka-fr3"]


@pytest.mark.oracle
@pytest.mark.parametrize("name", REAL)
def test_agrees_with_pinocchio(name):
    pin = pytest.importorskip("pinocchio")
    base = BasePose((0.1, -0.4, 0.7), (0.3, -0.5, 1.1))
    robot = moved_robot(load_robot(name), base=base)
    load = random_load()
    model = pin.buildModelFromXML(robot.urdf)
    model.gravity.linear = np.array([0.0, 0.0, -GRAVITY])
    flange = model.frames[model.getFrameId(robot.tip)]
    centre = load.first_moment / load.mass
    about_centre = load.inertia - load.mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    model.appendBodyToJoint(flange.parentJoint, pin.Inertia(load.mass, centre, about_centre), flange.placement)
    data = model.createData()
    q, qd, qdd = random_states(robot, 1000)
    ours = joint_torques(robot, q, qd, qdd, load)
    theirs = np.array([pin.rnea(model, data, *(row for row in rows)) for rows in zip(q, qd, qdd, strict=True)])
    assert np.abs(ours - theirs).max() < 1e-7


@pytest.mark.parametrize("name", REAL)
def test_gravity_torque_is_the_slope_of_the_potential(name):
    """At rest, torques are the gradient of the potential energy; here of the load's, by the flange's own kinematics."""
    robot = load_robot(name)
    load = load_of(1.7, np.array([0.02, -0.07, 0.11]))
    q = random_states(robot, 40, seed=2)[0]
    rest = np.zeros_like(q)
    share = joint_torques(robot, q, rest, rest, load) - joint_torques(robot, q, rest, rest)
    jacobians = kinematics(robot).jacobians(q, tool=Tool(np.asarray(load.first_moment) / load.mass))
    np.testing.assert_allclose(share, load.mass * GRAVITY * jacobians[:, 2, :], atol=1e-10)


@pytest.mark.parametrize("name", REAL)
def test_power_is_the_growth_of_kinetic_energy(name):
    """Without gravity, torque times speed is the rate of the kinetic energy, which is quadratic in the speeds."""
    robot = load_robot(name)
    load = random_load()
    q, qd, qdd = random_states(robot, 30, seed=3)
    qd, qdd = 0.3 * qd, 0.3 * qdd

    def energy(q, qd):
        momenta = joint_torques(robot, q, 0 * q, qd, load, gravity=0.0)  # mass matrix times speed
        return 0.5 * (momenta * qd).sum(axis=1)

    step = 1e-5
    later = energy(q + step * qd + 0.5 * step**2 * qdd, qd + step * qdd)
    earlier = energy(q - step * qd + 0.5 * step**2 * qdd, qd - step * qdd)
    power = (joint_torques(robot, q, qd, qdd, load, gravity=0.0) * qd).sum(axis=1)
    np.testing.assert_allclose((later - earlier) / (2 * step), power, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("name", REAL)
def test_mass_matrix_is_symmetric_and_positive(name):
    robot = load_robot(name)
    count = len(robot.joints)
    for q in random_states(robot, 10, seed=4)[0]:
        rows = np.broadcast_to(q, (count, count))
        matrix = joint_torques(robot, rows, 0 * rows, np.eye(count), random_load(), gravity=0.0)
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-12)
        assert np.linalg.eigvalsh(matrix)[0] > 0.0


def test_load_counts_like_a_link():
    """A body fixed to the flange in the URDF and the same body as a load give the same torques."""
    robot = load_robot("ur5e")
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    load = load_of(1.2, np.array([0.03, 0.01, 0.2]), np.diag([0.01, 0.02, 0.025]), rotation=turned)
    link = (
        '<link name="tool0"><inertial><origin xyz="0.03 0.01 0.2" rpy="0 0 1.5707963267948966"/><mass value="1.2"/>'
        '<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.025"/></inertial></link>'
    )
    heavier = replace(robot, urdf=robot.urdf.replace('<link name="tool0"/>', link))
    states = random_states(robot, 50, seed=5)
    np.testing.assert_allclose(joint_torques(robot, *states, load), joint_torques(heavier, *states), atol=1e-11)


def test_loads_add_up():
    first, second = random_load(1), random_load(2)
    both = first + second
    robot = load_robot("franka-fr3")
    states = random_states(robot, 20, seed=6)
    none = joint_torques(robot, *states)
    parts = joint_torques(robot, *states, first) + joint_torques(robot, *states, second) - none
    np.testing.assert_allclose(joint_torques(robot, *states, both), parts, atol=1e-10)


def test_expression_takes_symbols_and_agrees_with_samples():
    robot = load_robot("franka-fr3")
    q, qd, qdd = (ca.SX.sym(name, 7) for name in ("q", "qd", "qdd"))
    column, gravity = ca.SX.sym("load", 13), ca.SX.sym("gravity")
    load = Load(column[0], column[1:4], ca.reshape(column[4:], 3, 3))
    function = ca.Function("f", [q, qd, qdd, column, gravity], [joint_torque(robot, q, qd, qdd, load, gravity=gravity)])
    states = random_states(robot, 1)
    outputs: Any = function(*(rows[0] for rows in states), load_column(random_load()), GRAVITY)
    answer = outputs.full().ravel()
    expected = joint_torques(robot, *states, random_load())[0]
    np.testing.assert_allclose(answer, expected, atol=1e-12)


@pytest.mark.parametrize(("name", "most"), [("ur5e", 660), ("ur10e", 620), ("franka-fr3", 860)])
def test_expression_stays_small(name, most):
    """The optimal control problem differentiates it twice: its size is its cost."""
    assert dynamics(load_robot(name)).torque_function.n_instructions() <= most


def test_one_build_per_chain_shapes_and_empty_batches():
    robot = load_robot("ur5e")
    assert dynamics(replace(robot, name="other")) is dynamics(robot)
    none, wrong = np.zeros((0, 6)), np.zeros((4, 7))
    assert joint_torques(robot, none, none, none).shape == (0, 6)
    with pytest.raises(ValueError, match=r"expected \(4, 6\)"):
        joint_torques(robot, wrong, wrong, wrong)


def test_unknown_inertias_are_refused():
    with pytest.raises(ScenarioError, match=r"'comau-smart-six': masses and inertias are not known \(link 'link_1'"):
        dynamics(load_robot("comau-smart-six"))
