"""Frames of all joints with their velocities, against the forward kinematics and differences."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.robots.description.catalog import ROBOTS, load_robot
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.frames import arm_chain, joint_frames


@pytest.mark.parametrize("name", ROBOTS)
def test_last_frame_carries_the_flange(name: str) -> None:
    robot, random = load_robot(name), np.random.default_rng(0)
    chain = arm_chain(robot)
    q, qd = random.uniform(-2.0, 2.0, (2, 50, len(robot.joints)))
    frames, motions = joint_frames(chain, q, qd), kinematics(robot).motions(q, qd, 0.0 * q)
    arm = frames.rotation[-1] @ chain.flange_position
    np.testing.assert_allclose(frames.position[-1] + arm, motions.position, atol=1e-12)
    np.testing.assert_allclose(frames.rotation[-1] @ chain.flange_rotation, motions.rotation, atol=1e-12)
    np.testing.assert_allclose(
        frames.velocity[-1] + np.cross(frames.angular_velocity[-1], arm), motions.velocity, atol=1e-12
    )
    np.testing.assert_allclose(frames.angular_velocity[-1], motions.angular_velocity, atol=1e-12)


def test_every_frame_moves_as_it_says() -> None:
    chain, random, step = arm_chain(load_robot("franka-fr3")), np.random.default_rng(1), 1e-6
    q, qd = random.uniform(-2.0, 2.0, (2, 20, 7))
    frames, later = joint_frames(chain, q, qd), joint_frames(chain, q + step * qd, qd)
    np.testing.assert_allclose((later.position - frames.position) / step, frames.velocity, atol=1e-5)
    turned = (later.rotation - frames.rotation) / step @ np.swapaxes(frames.rotation, -1, -2)
    spin = np.stack([turned[..., 2, 1], turned[..., 0, 2], turned[..., 1, 0]], axis=-1)
    np.testing.assert_allclose(spin, frames.angular_velocity, atol=1e-5)
