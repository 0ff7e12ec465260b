"""Seven joints on a grid: paths on which the redundant joint has to move, and a refusal that says what was searched."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.paths.path import straight_line
from nospill.robots.description.catalog import load_robot
from nospill.robots.joint_paths.following import tray_poses, tray_rates
from nospill.robots.joint_paths.redundancy_grid import paths_on_grid
from nospill.robots.joint_paths.search import joint_paths
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.tool import Tool

ROBOT = load_robot("franka-fr3")
TRAY = Tool(np.array([0.0, 0.0, 0.108]))

LINES = {
    "across": ((0.45, -0.3, 0.35), (0.45, 0.3, 0.35), TRAY),
    "outward": ((0.35, 0.0, 0.40), (0.60, 0.0, 0.40), TRAY),
    # the redundant joint has a range of some four degrees at each place
    "at the edge": ((0.4747, 0.2888, 0.2023), (0.5445, 0.0030, 0.1971), Tool(np.array([0.0, 0.0, 0.1218]), np.pi / 4)),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", LINES)
def test_a_line_that_needs_the_redundant_joint_to_move_is_followed(name: str) -> None:
    start, end, tool = LINES[name]
    path = straight_line(start, end)
    found = joint_paths(ROBOT, path, tool=tool)
    arm = kinematics(ROBOT)
    for way in found:
        positions, rotations = tray_poses(path, way.s)
        reached, turned = arm.poses(way.q, tool=tool)
        assert np.abs(reached - positions).max() < 1e-11
        assert np.abs(turned - rotations).max() < 1e-11
        assert np.all((way.q >= ROBOT.lower) & (way.q <= ROBOT.upper))
        assert way.limit_margin >= 0
        # the derivative moves the tray along the path; continuous: it stays there between the samples, too
        moved = np.einsum("mij,mj->mi", arm.jacobians(way.q, tool=tool), way.dq_ds)
        assert np.abs(moved - tray_rates(path, way.s)).max() < 1e-6
        middle = 0.5 * (way.s[1:] + way.s[:-1])
        between, _ = arm.poses(way.at(middle), tool=tool)
        assert np.abs(between - tray_poses(path, middle)[0]).max() < 1e-4


@pytest.mark.slow
def test_paths_on_the_grid_start_apart() -> None:
    start, end, tool = LINES["across"]
    found = paths_on_grid(ROBOT, straight_line(start, end), 6, np.linspace(0.0, 1.0, 21), tool=tool)
    assert len(found) > 1
    for index, (q, _) in enumerate(found):
        for other, _ in found[:index]:
            assert np.abs(q[0] - other[0]).max() > 0.4


def test_a_refusal_says_what_was_searched() -> None:
    # reachable all along with the joint limits aside
    low = straight_line([0.30, -0.2, 0.02], [0.30, 0.2, 0.02])
    with pytest.raises(ScenarioError, match=r"searched: 241 positions of fr3_joint7 at 51 places"):
        joint_paths(ROBOT, low, tool=TRAY)
