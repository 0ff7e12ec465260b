"""Capsules in closed form, beside coal."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.collisions.bodies import scene_bodies
from nospill.collisions.capsule_distances import capsule_distances
from nospill.collisions.distances import Distances
from nospill.robots.kinematics.frames import arm_chain, joint_frames


@pytest.mark.parametrize("name", ["ur5e", "franka-fr3"])
def test_distances_are_those_of_coal(changed_scene, name: str) -> None:
    """All pairs of parts of an arm at random configurations, where the axes do not cross; balls among the capsules."""
    scene = changed_scene("coffee-to-go", {"robot": {"model": name}})
    parts = [body for body in scene_bodies(scene, loaded=False) if body.of_arm]
    pairs = [(second, first) for first in parts for second in parts if first.joint < second.joint]
    q = np.random.default_rng(1).uniform(scene.robot.lower, scene.robot.upper, (20, len(scene.robot.joints)))
    frames, every = joint_frames(arm_chain(scene.robot), q), np.arange(len(q))
    found = capsule_distances(pairs, frames)
    assert found.shape == (len(pairs), len(q))
    for (first, second), own in zip(pairs, found, strict=True):
        np.testing.assert_allclose(own, Distances(first, second).at(frames, every)[0], atol=2e-6)
    assert np.min(found) < 0.0 < np.max(found)
