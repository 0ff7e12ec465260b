"""An arm one joint of which follows another, planned and certified: its flange is where Pinocchio has it."""

from __future__ import annotations

import copy
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nospill.errors import NoSolutionError
from nospill.planning.planner import plan
from nospill.robots.kinematics.forward import kinematics
from nospill.scenario import scene_from_table

VALID: dict[str, Any] = tomllib.loads(
    (Path(__file__).parents[1] / "scenario" / "bad_scenarios" / "_valid.toml").read_text(encoding="utf-8")
)
AXES = ("0 0 1", "0 1 0", "0 1 0", "0 0 1", "0 1 0", "0 0 1")
STEPS = (0.3, 0.0, 0.42, 0.18, 0.2, 0.1)
FACTOR = -0.5


def arm_text() -> str:
    """Six joints, and between the third and the fourth one that turns back by half of the third's angle."""
    rows, parent = ['<link name="base"/>'], "base"
    for k, (axis, step) in enumerate(zip(AXES, STEPS, strict=True), start=1):
        rows.append(_joint(f"j{k}", parent, f"l{k}", step, axis))
        parent = f"l{k}"
        if k == 3:
            follow = f'<mimic joint="j3" multiplier="{FACTOR}"/>'
            rows.append(_joint("follower", parent, "l3b", 0.05, "0 1 0", follow))
            parent = "l3b"
    rows.append(
        f'<link name="tool0"/><joint name="t" type="fixed"><parent link="{parent}"/><child link="tool0"/></joint>'
    )
    return f'<robot name="follows">{"".join(rows)}</robot>'


def _joint(name: str, parent: str, child: str, step: float, axis: str, more: str = "") -> str:
    inertia = '<inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/>'
    return (
        f'<link name="{child}"><inertial><origin xyz="0 0 0.08"/><mass value="{1.5 + step}"/>{inertia}</inertial>'
        f'</link><joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 0 {step}"/><axis xyz="{axis}"/>'
        f'<limit lower="-2.6" upper="2.6" velocity="3" effort="150"/>{more}</joint>'
    )


def table(**changes: Any) -> dict[str, Any]:
    found = {**copy.deepcopy(VALID), "robot": {"urdf_text": arm_text(), "limits": {"acceleration": 20}}}
    found["cargo"] = found["cargo"][1:]
    found["tray"] = {"size": [0.2, 0.2], "friction": 0.4, "mass": 0.2, "offset": [0, 0, 0.04]}
    found["cargo"][0]["at"] = [0, 0]
    found["path"] = {"type": "line", "start": [0.6, -0.1, 0.8], "end": [0.6, 0.1, 0.8]}
    found["planning"] = {"intervals": 24}
    return found | changes


@pytest.mark.slow
@pytest.mark.oracle
def test_the_certified_motion_is_of_the_whole_arm() -> None:
    pin = pytest.importorskip("pinocchio")
    scene = scene_from_table(table(), name="follows", folder=Path("."))
    outcome = plan(scene)
    assert outcome.certificate.ok
    assert {row.subject for row in outcome.certificate.rows if row.constraint == "joint torque"} == set(
        scene.robot.joints
    )
    q = outcome.trajectory.joint_position
    model = pin.buildModelFromXML(arm_text())
    data, frame = model.createData(), model.getFrameId("tool0")
    places = {name: number for number, name in enumerate(list(model.names)[1:])}
    positions, rotations = kinematics(scene.robot).poses(q)
    assert np.ptp(q[:, 2]) > 0.01
    for k in range(0, len(q), 20):
        whole = np.zeros(model.nq)
        for name, value in zip(scene.robot.joints, q[k], strict=True):
            whole[places[name]] = value
        whole[places["follower"]] = FACTOR * q[k, 2]
        pin.framesForwardKinematics(model, data, whole)
        np.testing.assert_allclose(positions[k], data.oMf[frame].translation, atol=1e-9)
        np.testing.assert_allclose(rotations[k], data.oMf[frame].rotation, atol=1e-9)


@pytest.mark.slow
def test_a_joint_that_hardly_moves_is_told_what_it_needs() -> None:
    """The speed that the message names leads to a motion."""
    robot = {"model": "ur10e", "limits": {"speed": [2, 2, 3, 3, 3, 2.8e-8]}}
    path = {"type": "line", "start": [0.6, -0.2, 0.5], "end": [0.6, 0.2, 0.5]}
    slow = scene_from_table(table(robot=robot, path=path), name="slow", folder=Path("."))
    with pytest.raises(NoSolutionError, match=r"the path turns wrist_3_joint by .* deg, which takes .* s") as caught:
        plan(slow)
    assert "standing still" not in str(caught.value)
    needed = str(caught.value).split(" asks ")[1].split(" of it")[0]
    robot["limits"]["speed"][-1] = needed
    assert plan(scene_from_table(table(robot=robot, path=path), name="slow", folder=Path("."))).certificate.ok
