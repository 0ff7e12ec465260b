"""Drawn URDFs with the defects of real files: refused in one line, or the arm of the file, by Pinocchio's reading."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.errors import ScenarioError
from nospill.robots.description.urdf import UrdfArm, read_arm, standalone_urdf
from nospill.robots.kinematics.dynamics import NO_LOAD, STANDARD_GRAVITY, Dynamics
from nospill.robots.kinematics.forward import Kinematics
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from tests.drawn_urdfs import DEFECTS, DrawnUrdf, drawn_urdf

# Every file is an arm of its own, seen in a few states: to compile its functions takes longer than all the rest.
pytestmark = [pytest.mark.oracle, pytest.mark.usefixtures("in_virtual_machine")]
STATES = 3
REFUSED = ("millimetres", "rpy in degrees")


@given(st.integers(0, 10**6), st.frozensets(st.sampled_from(DEFECTS), max_size=4))
@settings(max_examples=40, deadline=None)
def test_a_drawn_file_is_the_arm_or_one_line(seed: int, defects: frozenset[str]) -> None:
    pin = pytest.importorskip("pinocchio")
    check(pin, drawn_urdf(seed, defects), defects)


def check(pin: Any, drawn: DrawnUrdf, defects: frozenset[str]) -> UrdfArm | None:
    """Read a file and compare; returns the arm, None where the file is refused."""
    locked = {"rail": "0.3 m"} if "rail" in defects else {}
    try:
        arm = read_arm(drawn.text, tip="tool0", locked=locked)
    except ScenarioError as error:
        assert len(str(error).splitlines()) == 1
        assert defects & {*REFUSED, "mimic", "mimic chain"}, error
        return None
    assert not defects & set(REFUSED)
    again = read_arm(standalone_urdf(drawn.text, name="x"), tip="tool0", locked=locked)
    assert (again.urdf, again.notes, again.doubts) == (arm.urdf, arm.notes, arm.doubts)
    assert not set(drawn.laws) & set(arm.joints)
    _check_limits(arm, drawn)
    _check_motion(pin, arm, drawn, 0.3 if "rail" in defects else None)
    if "turned tip" in defects:
        assert any(doubt.about == "tip" for doubt in arm.doubts)
    if defects & {"massless", "no inertial", "triangle"} and "gripper" not in defects:  # a jaw has mass
        assert arm.inertia_fault is not None and not arm.torque_known.all()
    return arm


def _check_limits(arm: UrdfArm, drawn: DrawnUrdf) -> None:
    """No limit is wider than the file's; what is not set has a reason."""
    for index, name in enumerate(arm.joints):
        lower, upper = arm.lower[index], arm.upper[index]
        if name in drawn.bounds:
            assert lower >= drawn.bounds[name][0] - 1e-12 and upper <= drawn.bounds[name][1] + 1e-12
        if name in drawn.speeds:
            assert arm.max_speed[index] <= drawn.speeds[name] + 1e-12
        for key, value in (("lower", lower), ("upper", upper), ("speed", arm.max_speed[index])):
            assert math.isnan(value) == (name in arm.not_set[key])
        for leader, factor, offset in drawn.laws.values():
            if leader == name:
                ends = sorted((factor * lower + offset, factor * upper + offset))
                assert ends[0] >= -2.0 - 1e-9 and ends[1] <= 2.1 + 1e-9
                assert abs(factor) * arm.max_speed[index] <= 1.5 + 1e-9


def _check_motion(pin: Any, arm: UrdfArm, drawn: DrawnUrdf, rail: float | None) -> None:
    """Flange, Jacobian and torques as Pinocchio has them, what follows substituted by its law."""
    model = pin.buildModelFromXML(drawn.text)
    model.gravity.linear = np.array([0.0, 0.0, -STANDARD_GRAVITY])
    data, frame = model.createData(), model.getFrameId("tool0")
    count = len(arm.joints)
    law, shift = np.zeros((model.nv, count)), np.zeros(model.nv)
    for number, name in enumerate(list(model.names)[1:]):
        leader, factor, offset = drawn.laws.get(name, (name, 1.0, 0.0))
        if leader in arm.joints:
            law[number, arm.joints.index(leader)], shift[number] = factor, offset
        elif name == "rail" and rail is not None:
            shift[number] = rail
    generator = np.random.default_rng(0)
    q, qd, qdd = (generator.uniform(-1.0, 1.0, (STATES, count)) for _ in range(3))
    kinematics = Kinematics(arm.urdf, arm.joints, arm.tip)
    positions, rotations = kinematics.poses(q)
    jacobians = kinematics.jacobians(q)
    motions = kinematics.motions(q, qd, qdd)
    frames = joint_frames(arm_chain(arm), q, qd)
    torques = Dynamics(arm.urdf, arm.joints, arm.tip).torques(q, qd, qdd, NO_LOAD, gravity=STANDARD_GRAVITY)
    assert frames.position.shape[0] == count + len(drawn.laws) + 1
    for k in range(STATES):
        state, rate, change = law @ q[k] + shift, law @ qd[k], law @ qdd[k]
        pin.forwardKinematics(model, data, state, rate, change)
        pin.updateFramePlacements(model, data)
        np.testing.assert_allclose(positions[k], data.oMf[frame].translation, atol=1e-9)
        np.testing.assert_allclose(rotations[k], data.oMf[frame].rotation, atol=1e-9)
        whole = pin.computeFrameJacobian(model, data, state, frame, pin.LOCAL_WORLD_ALIGNED)
        np.testing.assert_allclose(jacobians[k], whole @ law, atol=1e-9)
        moved = pin.getFrameClassicalAcceleration(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
        np.testing.assert_allclose(motions.acceleration[k], moved.linear, atol=1e-7)
        np.testing.assert_allclose(motions.angular_acceleration[k], moved.angular, atol=1e-7)
        # virtual work: a joint feels what follows it by the factor of its law
        np.testing.assert_allclose(torques[k], law.T @ pin.rnea(model, data, state, rate, change), atol=1e-7)
