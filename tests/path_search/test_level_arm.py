"""An arm with a level tray goes from one configuration to another, straight for the tray or for the joints."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nospill.path_search.level_arm import LevelArm
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.newton import Held
from nospill.robots.kinematics.redundancy import self_motion
from nospill.scenario import scene_from_table

CUP = {"name": "cup", "shape": "cylinder", "radius": 0.03, "height": 0.08, "mass": 0.2, "centre_of_mass_height": 0.03}
FLOOR = {"name": "floor", "shape": "halfspace", "at": [0.0, 0.0, -0.5]}
RESTING = 6
"""Joint of the Franka FR3 that stands for its freedom where configurations of a pose are looked for."""


def arm_of(*obstacles: dict[str, Any], by_joints: bool = False) -> LevelArm:
    table = {
        "robot": {"model": "franka-fr3"},
        "tray": {"size": [0.16, 0.12], "offset": 0.08, "friction": 0.4},
        "cargo": [{**CUP, "at": [0.0, 0.0]}],
        "obstacle": [FLOOR, *obstacles],
        "path": {"type": "free", "start": {"position": [0.45, -0.35, 0.45]}, "goal": {"position": [0.45, 0.35, 0.45]}},
    }
    return LevelArm(scene_from_table(table, name="level"), by_joints=by_joints)


def round_the_turn(arm: LevelArm, pose: np.ndarray) -> np.ndarray:
    """Configurations (k, 7) at a pose along the self-motion, as far as the limits, on which joint 7 turns back."""
    held = np.linspace(1.0, 1.4, 9)
    for q in np.concatenate(arm.solutions(np.tile(pose, (len(held), 1)), held)):
        found, before = [q], None
        while np.all((found[-1] >= arm.robot.lower) & (found[-1] <= arm.robot.upper)) and len(found) < 120:
            jacobian = kinematics(arm.robot).jacobians(found[-1][None], tool=arm.scene.tray.tool)[0]
            rest = np.linalg.svd(jacobian)[2][-1]
            before = rest * np.sign(rest[RESTING] if before is None else rest @ before)
            found.append(found[-1] + 0.02 * before)
        there = np.diff(np.array(found[:-1])[:, RESTING])
        if there.min(initial=0.0) < -1e-3 and there.max(initial=0.0) > 1e-3:
            return np.array(found[:-1])
    raise AssertionError("no self-motion turns joint 7 back")


def test_where_the_arm_can_stand_some_configuration_is_clear() -> None:
    """A block beside the elbow leaves some positions of the redundant joint, one about the tray's place leaves none."""
    places = np.array([[0.45, -0.2, 0.45, 0.0], [0.45, 0.2, 0.45, 0.0]])
    assert arm_of().can_stand(places)
    beside = {"name": "block", "shape": "box", "at": [0.25, -0.3, 0.6], "size": [0.06, 0.06, 0.2]}
    arm = arm_of(beside)
    held = np.linspace(arm.robot.lower[RESTING], arm.robot.upper[RESTING], 40)
    found = np.concatenate(arm.solutions(np.tile(places[0], (len(held), 1)), held))
    clear = arm.clear(np.tile(places[0], (len(found), 1)), found)
    assert clear.any() and not clear.all() and arm.can_stand(places[:1])
    there = {"name": "post", "shape": "box", "at": [0.45, 0.2, 0.3], "size": [0.05, 0.05, 0.4], "clearance": 0.0}
    assert not arm_of(there).can_stand(places)
    assert not arm.can_stand(np.array([[2.0, 0.0, 0.45, 0.0]]))  # out of reach


@pytest.mark.parametrize("by_joints", [False, True])
def test_it_passes_where_the_seventh_joint_rests(by_joints: bool) -> None:
    """Two configurations of one pose, on both sides of where the self-motion turns joint 7 back."""
    arm = arm_of(by_joints=by_joints)
    pose = arm.ends[0]
    along = round_the_turn(arm, pose)
    direction = self_motion(arm.robot, along)
    track = arm.joints_at(np.tile(pose, (len(along), 1)), along, Held(direction, along @ direction))
    assert track is not None
    poses, q, there = arm.towards(pose, track[0], pose, track[-1])
    assert there
    np.testing.assert_allclose(q[-1], track[-1], atol=1e-5)
    positions, rotations = kinematics(arm.robot).poses(q, tool=arm.scene.tray.tool)
    np.testing.assert_allclose(positions, poses[:, :3], atol=1e-5)
    np.testing.assert_allclose(rotations[:, 2, 2], 1.0, atol=1e-9)
    # on the spot joint 7 turns back; along a line of the joints the tray goes out and comes back instead
    turned, away = np.diff(q[:, RESTING]), np.abs(poses - pose).max()
    assert away > 0.05 if by_joints else (away < 1e-9 and turned.min() < 0.0 < turned.max())


def test_what_is_held_is_kept_at_stated_joints() -> None:
    arm = arm_of(by_joints=False)
    q = next(some[0] for some in arm.solutions(np.tile(arm.ends[0], (len(arm.held), 1)), arm.held) if len(some))
    direction = np.eye(7)[RESTING]
    found = arm.joints_at(arm.ends[:1], q[None] + 0.01, Held(direction, np.array([q[RESTING]])))
    assert found is not None
    np.testing.assert_allclose(found[0], q, atol=1e-4)
    assert arm.joints_at(arm.ends[:1], q[None] + 1.0, Held(direction, np.array([q[RESTING]]))) is None
