"""Back-off of joint ranges."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.joint_position import JointPosition, range_backoff
from nospill.robots.joint_paths.search import joint_paths
from nospill.scenario import read_scenario


def test_the_back_off_of_a_range_leaves_what_the_path_needs() -> None:
    scene = read_scenario("matrix-rigid")
    [path, *_] = joint_paths(scene.robot, scene.path, tool=scene.tray.tool)
    middle = int(np.argmax(path.q[1:-1, 2])) + 1  # the third joint comes farthest on the way
    assert path.q[middle, 2] > path.q[[0, -1], 2].max()
    upper = scene.robot.upper.copy()
    upper[2] = path.q[middle, 2] + 1e-5
    tight = replace(scene, robot=replace(scene.robot, upper=upper))
    level = replace(tight, motion=replace(tight.motion, tilt_free=False))
    key = RowId(JointPosition.name, scene.robot.joints[2])
    assert range_backoff(level, path.q)[key] == pytest.approx(1e-5 / (upper[2] - scene.robot.lower[2]))
    assert range_backoff(tight, path.q)[key] > 10 * range_backoff(level, path.q)[key]
    assert max(range_backoff(tight, path.q).values()) == JointPosition.backoff
