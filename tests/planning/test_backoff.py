"""Back-off: what is kept from the optimiser at first, when a judged row falls short, and how much is added."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nospill.judge.verdict import Row
from nospill.laws.constraints import CONSTRAINTS
from nospill.planning.backoff import falls_short, first_backoff, further_backoff, range_backoff
from nospill.robots.joint_paths.search import joint_paths
from nospill.scenario import read_scenario


def row(constraint: str, limit: float, margin: float, unit: str = "1") -> Row:
    return Row(constraint, "c1", unit, limit, limit - margin, margin, 0.5, margin >= 0.0)


def test_the_first_back_off_is_the_constraint_s_own() -> None:
    assert all(first_backoff(constraint.name) == constraint.backoff > 0.0 for constraint in CONSTRAINTS)
    assert first_backoff("slip") > first_backoff("joint speed")


@pytest.mark.parametrize(
    ("case", "short"),
    [
        (row("slip", 1.0, 1.4e-3), True),
        (row("slip", 1.0, 1.6e-3), False),
        (row("residual height", 1e-3, 3e-7, "m"), True),  # 0.2e-6 of integration and a share of the limit
        (row("residual height", 1e-3, 5e-7, "m"), False),
        (row("joint speed", 3.0, 1e-9), False),  # nothing between the instants
        (row("joint speed", 3.0, -1e-9), True),
        (row("lift", 0.0, 1e-9), False),
        (row("path position", 1e-4, 1e-9), False),  # about the record
    ],
)
def test_a_finer_grid_finds_nothing_broken(case: Row, short: bool) -> None:
    assert falls_short(case) is short


def test_further_back_off_makes_up_for_what_is_missing() -> None:
    for margin in (1e-3, 0.0, -0.01):
        missing = 1.5e-3 - margin
        assert missing < further_backoff(row("slip", 1.0, margin)) < 1.5 * missing + 1e-3
    assert further_backoff(row("slip", 1.0, -5.0)) == 0.1


def test_the_back_off_of_a_range_leaves_what_the_path_needs() -> None:
    scene = read_scenario("matrix-rigid")
    [path, *_] = joint_paths(
        scene.robot, scene.path, tool_position=scene.tray.offset, tool_yaw=scene.tray.yaw_on_flange
    )
    middle = int(np.argmax(path.q[1:-1, 2])) + 1  # the third joint comes farthest on the way
    assert path.q[middle, 2] > path.q[[0, -1], 2].max()
    upper = scene.robot.upper.copy()
    upper[2] = path.q[middle, 2] + 1e-5
    tight = replace(scene, robot=replace(scene.robot, upper=upper))
    level = replace(tight, motion=replace(tight.motion, tilt_free=False))
    key = ("joint position", scene.robot.joints[2])
    assert range_backoff(level, path.q)[key] == pytest.approx(1e-5 / (upper[2] - scene.robot.lower[2]))  # pyright: ignore[reportArgumentType]
    assert range_backoff(tight, path.q)[key] > 10 * range_backoff(level, path.q)[key]  # pyright: ignore[reportArgumentType]
    assert max(range_backoff(tight, path.q).values()) == first_backoff("joint position")
