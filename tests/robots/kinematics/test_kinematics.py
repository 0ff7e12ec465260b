"""Forward kinematics against Pinocchio, against finite differences and against the lab's own joint record."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.robots.description.catalog import ROBOTS, load_robot
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.tool import FLANGE, TOOL_NUMBERS, Tool
from tests.measured import measured_data

TOOL = Tool(np.array([0.03, -0.05, 0.108]), 0.7)
BRACKET = Tool(np.array([0.2, -0.05, 0.108]), 0.7, roll=-0.4, pitch=1.2)


def random_states(robot, count, seed=0):
    generator = np.random.default_rng(seed)
    q = generator.uniform(np.maximum(robot.lower, -6.0), np.minimum(robot.upper, 6.0), size=(count, len(robot.joints)))
    return q, robot.max_speed * generator.uniform(-1, 1, q.shape), 20.0 * generator.uniform(-1, 1, q.shape)


def about_z(angle):
    return np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])


@pytest.mark.oracle
@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("tool", [FLANGE, TOOL, BRACKET], ids=["flange", "tool", "bracket"])
def test_agrees_with_pinocchio(name, tool):
    pin = pytest.importorskip("pinocchio")
    robot = load_robot(name)
    model = pin.buildModelFromXML(robot.urdf)
    offset = pin.SE3(pin.rpy.rpyToMatrix(tool.roll, tool.pitch, tool.yaw), tool.position)
    flange = model.getFrameId(robot.tip)
    parent = model.frames[flange]
    frame = model.addFrame(
        pin.Frame("tool", parent.parentJoint, flange, parent.placement * offset, pin.FrameType.OP_FRAME)
    )
    data = model.createData()
    axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED

    q, qd, qdd = random_states(robot, 1000)
    motions = kinematics(robot).motions(q, qd, qdd, tool=tool)
    positions, rotations, jacobians = kinematics(robot).poses_and_jacobians(q, tool=tool)
    np.testing.assert_array_equal(jacobians, kinematics(robot).jacobians(q, tool=tool))
    for i in range(len(q)):
        pin.forwardKinematics(model, data, q[i], qd[i], qdd[i])
        pin.updateFramePlacements(model, data)
        pose = data.oMf[frame]
        velocity = pin.getFrameVelocity(model, data, frame, axes)
        acceleration = pin.getFrameClassicalAcceleration(model, data, frame, axes)
        pairs = (
            (positions[i], pose.translation),
            (rotations[i], pose.rotation),
            (motions.position[i], pose.translation),
            (motions.rotation[i], pose.rotation),
            (motions.velocity[i], velocity.linear),
            (motions.angular_velocity[i], velocity.angular),
            (motions.acceleration[i], acceleration.linear),
            (motions.angular_acceleration[i], acceleration.angular),
            (jacobians[i], pin.computeFrameJacobian(model, data, q[i], frame, axes)),
        )
        for ours, theirs in pairs:
            assert np.abs(ours - theirs).max() < 1e-9


def test_motion_agrees_with_finite_differences():
    robot = load_robot("comau-smart-six")
    arm = kinematics(robot)
    q, qd, qdd = random_states(robot, 50, seed=3)
    step = 1e-4

    def poses(t):
        return arm.poses(q + qd * t + 0.5 * qdd * t * t, tool=TOOL)

    (before, turned_before), (now, turned), (after, turned_after) = poses(-step), poses(0.0), poses(step)
    motions = arm.motions(q, qd, qdd, tool=TOOL)
    np.testing.assert_allclose((after - before) / (2 * step), motions.velocity, atol=5e-5)
    np.testing.assert_allclose((after - 2 * now + before) / step**2, motions.acceleration, atol=2e-3)
    spin = (turned_after - turned_before) / (2 * step) @ np.swapaxes(turned, 1, 2)
    rates = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)
    np.testing.assert_allclose(rates, motions.angular_velocity, atol=5e-5)
    later = arm.motions(q + qd * step + 0.5 * qdd * step**2, qd + qdd * step, qdd).angular_velocity
    earlier = arm.motions(q - qd * step + 0.5 * qdd * step**2, qd - qdd * step, qdd).angular_velocity
    np.testing.assert_allclose((later - earlier) / (2 * step), motions.angular_acceleration, atol=5e-5)


def test_jacobian_carries_speeds_to_the_twist():
    robot = load_robot("comau-smart-six")
    q, qd, qdd = random_states(robot, 100, seed=4)
    arm = kinematics(robot)
    motions = arm.motions(q, qd, qdd, tool=TOOL)
    twist = (arm.jacobians(q, tool=TOOL) @ qd[..., None])[..., 0]
    np.testing.assert_allclose(twist, np.hstack([motions.velocity, motions.angular_velocity]), atol=1e-12)


def test_rotations_are_rotations():
    robot = load_robot("comau-smart-six")
    _, rotations = kinematics(robot).poses(random_states(robot, 200)[0], tool=TOOL)
    np.testing.assert_allclose(
        rotations @ np.swapaxes(rotations, 1, 2), np.broadcast_to(np.eye(3), (200, 3, 3)), atol=1e-14
    )
    np.testing.assert_allclose(np.linalg.det(rotations), 1.0)


def test_smart_six_drawing():
    """All joints zero: the forearm stands up behind the elbow; q3 = -90 deg lays it forward."""
    arm = kinematics(load_robot("comau-smart-six"))
    q = np.zeros((2, 6))
    q[1, 2] = -np.pi / 2
    positions, rotations = arm.poses(q)
    np.testing.assert_allclose(positions[0], [0.150 - 0.130, 0, 0.450 + 0.590 + 0.64707 + 0.095], atol=1e-15)
    np.testing.assert_allclose(rotations[0], np.eye(3), atol=1e-15)
    np.testing.assert_allclose(positions[1], [0.150 + 0.64707 + 0.095, 0, 0.450 + 0.590 + 0.130], atol=1e-15)


def test_expressions_agree_with_samples_and_take_symbolic_tools():
    robot = load_robot("comau-smart-six")
    arm = kinematics(robot)
    q, qd, tool = ca.SX.sym("q", 6), ca.SX.sym("qd", 6), ca.SX.sym("tool", TOOL_NUMBERS)
    pose = arm.pose(q, tool=tool)
    twist = arm.twist(q, qd, tool=tool)
    function = ca.Function("f", [q, qd, tool], [*pose, *twist])
    state, speed, change = (array[0] for array in random_states(robot, 1))
    answers = [out.full() for out in function(state, speed, TOOL.row)]
    motions = arm.motions(state[None], speed[None], change[None], tool=TOOL)
    expected = (motions.position[0], motions.rotation[0], motions.velocity[0], motions.angular_velocity[0])
    for ours, theirs in zip(answers, expected, strict=True):
        np.testing.assert_allclose(ours.reshape(theirs.shape), theirs, atol=1e-14)


def test_expression_stays_small():
    """The optimal control problem maps this over its stages: its size is its cost."""
    q = ca.SX.sym("q", 6)
    pose = kinematics(load_robot("comau-smart-six")).pose(q, tool=Tool(np.array([0, 0, 0.108])).row)
    assert ca.Function("f", [q], list(pose)).n_nodes() <= 150


def test_one_build_per_chain_and_empty_batches():
    robot = load_robot("comau-smart-six")
    arm = kinematics(robot)
    assert kinematics(replace(robot, name="other name")) is arm
    positions, rotations = arm.poses(np.zeros((0, 6)))
    assert positions.shape == (0, 3)
    assert rotations.shape == (0, 3, 3)
    with pytest.raises(ValueError, match=r"expected \(4, 6\)"):
        arm.poses(np.zeros((4, 7)))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"tip": "tool0"}, "tip 'tool0'"),
        ({"urdf": "robots/arm.urdf"}, "no XML"),
        ({"urdf": "<mujoco/>"}, "starts with <mujoco> where <robot> is expected"),
        ({"joints": ("joint_1", "elbow")}, "elbow"),
    ],
)
def test_unusable_descriptions(change, words):
    with pytest.raises(ScenarioError, match=words):
        kinematics(replace(load_robot("comau-smart-six"), **change))


@pytest.mark.oracle
def test_recorded_joints_start_and_end_on_the_arc():
    record = measured_data("matrix-d3/executed-joints-liquid.csv")
    q = np.loadtxt(record, delimiter=",", skiprows=1)[:, 1:]
    # the laboratory's flange is turned by half a turn against this chain, and its forearm 0.03 mm longer
    robot = load_robot("comau-smart-six")
    tool = Tool(np.array([0, 0, 0.108]), np.pi)
    maker, _ = kinematics(robot).poses(q[[0, -1]], tool=tool)
    laboratory = replace(robot, urdf=robot.urdf.replace("0.64707", "0.6471"))
    positions, rotations = kinematics(laboratory).poses(q[[0, -1]], tool=tool)
    assert np.abs(positions - maker).max() < 5e-5
    np.testing.assert_allclose(positions[0], [0.15411, -0.59940, 1.21951], atol=1e-5)
    np.testing.assert_allclose(positions[1], [0.15414, 0.59938, 1.21953], atol=1e-5)
    np.testing.assert_allclose(rotations[0], np.eye(3), atol=1e-5)
    np.testing.assert_allclose(rotations[1], about_z(np.pi), atol=1e-5)
