"""A tray turned on its flange: the bundled example against Pinocchio, and against an arm whose flange is turned."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.certification.certificate import judge
from nospill.collisions.bodies import HOLDER, TRAY, scene_bodies
from nospill.export.payload import payload_of
from nospill.laws.scene_parameters import flange_load
from nospill.robots.description.urdf_tree import rotation_of
from nospill.robots.kinematics.dynamics import joint_torques
from nospill.robots.kinematics.frames import arm_chain
from tests.motions import smooth_motion

BRACKET = "bracket-tray"


def quarter() -> np.ndarray:
    """The example's turn, tray to flange axes: tray x, y, z are flange x, z, -y."""
    return np.column_stack([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def test_axes_are_those_of_the_bracket() -> None:
    tray = smooth_motion(BRACKET).scene.tray
    np.testing.assert_allclose(tray.tool.rotation, quarter(), atol=1e-15)
    np.testing.assert_allclose(tray.tool.row, [*tray.tool.position, *quarter().ravel()], atol=1e-15)


@pytest.mark.oracle
def test_pinocchio_carries_the_same_tray_with_the_same_torques() -> None:
    pin = pytest.importorskip("pinocchio")
    scene = smooth_motion(BRACKET).scene
    model = pin.buildModelFromXML(scene.robot.urdf)
    model.gravity.linear = np.array([0.0, 0.0, -scene.gravity])
    flange = model.frames[model.getFrameId(scene.robot.tip)]
    tray = flange.placement * pin.SE3(quarter(), np.asarray(scene.tray.tool.position))
    x, y = scene.tray.size
    plate = scene.tray.mass / 12.0 * np.diag([y * y, x * x, x * x + y * y])
    model.appendBodyToJoint(flange.parentJoint, pin.Inertia(scene.tray.mass, np.zeros(3), plate), tray)
    for item in scene.cargo:
        body = pin.Inertia(item.total.mass, item.total.centre, item.total.inertia)
        model.appendBodyToJoint(flange.parentJoint, body, tray * pin.SE3(np.eye(3), np.asarray(item.place)))
    frame = model.addFrame(pin.Frame("tray", flange.parentJoint, 0, tray, pin.FrameType.OP_FRAME))
    data, played = model.createData(), smooth_motion(BRACKET).trajectory
    some = slice(None, None, 25)
    q, rates, changes = (part[some] for part in (played.joint_position, played.joint_speed, played.joint_acceleration))
    ours = joint_torques(scene.robot, q, rates, changes, flange_load(scene))
    for row, (at, speed, change) in enumerate(zip(q, rates, changes, strict=True)):
        np.testing.assert_allclose(ours[row], pin.rnea(model, data, at, speed, change), atol=1e-9)
        pin.framesForwardKinematics(model, data, at)
        np.testing.assert_allclose(data.oMf[frame].translation, played.tray_position[some][row], atol=1e-9)
        np.testing.assert_allclose(data.oMf[frame].rotation[:, 2], [0.0, 0.0, 1.0], atol=1e-9)


def test_the_judge_sees_the_same_as_on_a_flange_that_is_turned() -> None:
    """With the turn stated of the flange (tip_rpy) every row is the same but distances, to another holder."""
    motion = smooth_motion(BRACKET)
    angles = (np.pi / 2, 0.0, 0.0)
    offset = rotation_of(angles).T @ motion.scene.tray.tool.position
    twin = motion.scene.changed(
        {"robot.tip_rpy": list(angles), "tray.rotation": [0.0, 0.0, 0.0], "tray.offset": offset.tolist()}
    )
    ours, theirs = (
        {row.label: row for row in judge(motion.trajectory, scene).certificate.rows if row.constraint != "clearance"}
        for scene in (motion.scene, twin)
    )
    assert ours.keys() == theirs.keys() and any(row.constraint == "joint torque" for row in ours.values())
    for label, row in ours.items():
        assert row.worst_margin == pytest.approx(theirs[label].worst_margin, abs=1e-7), label
    one, other = payload_of(motion.scene), payload_of(twin)
    assert one.mass == other.mass
    np.testing.assert_allclose(one.centre, rotation_of(angles) @ other.centre, atol=1e-12)


def test_it_stands_on_an_l() -> None:
    """One bar along the flange and the tray's normal, the other one under the board, to its middle."""
    scene = smooth_motion(BRACKET).scene
    bodies, chain = scene_bodies(scene), arm_chain(scene.robot)
    first, second = (item for item in bodies if item.name == HOLDER)
    board = next(item for item in bodies if item.name == TRAY)
    up = board.rotation[:, 2]
    np.testing.assert_allclose(up, -chain.flange_rotation[:, 1], atol=1e-12)
    along, under = np.diff(first.points, axis=0)[0], np.diff(second.points, axis=0)[0]
    assert np.linalg.norm(np.cross(along, up)) < 1e-12
    assert abs(under @ up) < 1e-12
    # round bars of 25 mm: the second one touches the underside of the board, 6 mm below the surface
    middle = second.points[np.argmin(np.linalg.norm(second.points - board.position, axis=1))]
    np.testing.assert_allclose(board.position - middle, (0.025 + 0.003) * up, atol=1e-12)
