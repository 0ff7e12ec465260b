"""`start_joints` of a given path: the branch that begins in them, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.robots.joint_paths.search import joint_paths, try_joint_paths
from nospill.robots.kinematics.forward import kinematics
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene

LINE: dict[str, Any] = {"type": "line", "start": [0.75, -0.3, 0.45], "end": [0.75, 0.3, 0.45]}
PATHS: list[dict[str, Any]] = [
    LINE,
    {"type": "arc", "start": [0.75, -0.3, 0.45], "through": [0.85, 0.0, 0.5], "end": [0.75, 0.3, 0.45]},
    {"type": "waypoints", "points": [[0.75, -0.3, 0.45], [0.8, 0.0, 0.5], [0.75, 0.3, 0.45]]},
]


def along(path: dict[str, Any], example: str = "cups-around-a-column", **robot: object) -> Scene:
    table: dict[str, Any] = {key: value for key, value in read_scenario(example).source.items() if key != "obstacle"}
    return scene_from_table({**table, "robot": {**table["robot"], **robot}, "path": path}, name="line")


@pytest.mark.parametrize("path", PATHS, ids=lambda path: path["type"])
def test_every_branch_can_be_asked_for(path: dict[str, Any]) -> None:
    free = along(path)
    branches = joint_paths(free.robot, free.path, tool=free.tray.tool)
    assert len(branches) > 2
    for branch in branches[:6]:
        # as a screen shows them
        stated = [f"{angle:.1f} deg" for angle in np.degrees(branch.q[0])]
        scene = along({**path, "start_joints": stated})
        found = try_joint_paths(scene.robot, scene.path, tool=scene.tray.tool).paths
        assert len(found) == 1
        np.testing.assert_allclose(found[0].q, branch.q, atol=1e-6)
        np.testing.assert_allclose(scene.path.ends[0], branch.q[0], atol=1e-7)  # type: ignore[arg-type]
        assert scene.source["path"]["start_joints"] == stated  # type: ignore[index,call-overload]


def test_a_seventh_joint_begins_where_it_is_stated() -> None:
    ends = [read_scenario("shelf-to-table").path.at(s)[0, :3].tolist() for s in (0.0, 1.0)]
    line = {"type": "line", "start": ends[0], "end": ends[1]}
    free = along(line, "shelf-to-table")
    q = joint_paths(free.robot, free.path, tool=free.tray.tool)[-1].q[0]
    scene = along({**line, "start_joints": q.tolist()}, "shelf-to-table")
    found = joint_paths(scene.robot, scene.path, tool=scene.tray.tool)[0]
    np.testing.assert_allclose(found.q[0], q, atol=1e-6)
    positions, _ = kinematics(scene.robot).poses(found.q, tool=scene.tray.tool)
    np.testing.assert_allclose(positions, scene.path.at(found.s)[:, :3], atol=1e-6)


def test_a_joint_that_would_pass_its_limit_is_named() -> None:
    """The base joint has turned nearly all the way: this line needs 44 deg more."""
    free = along(LINE)
    q = joint_paths(free.robot, free.path, tool=free.tray.tool)[0].q[0].copy()
    q[0] += 2 * np.pi if q[0] < 0 else -2 * np.pi
    narrow = (q[0] - 0.05, q[0] + 0.05)
    names = free.robot.joints
    lower, upper = free.robot.lower.copy(), free.robot.upper.copy()
    lower[0], upper[0] = min(narrow[0], q[0] - 2 * np.pi - 2.0), narrow[1]
    limits = {"lower": lower.tolist(), "upper": upper.tolist()}
    scene = along({**LINE, "start_joints": q.tolist()}, limits=limits)
    with pytest.raises(ScenarioError, match=rf"{names[0]} at .* would pass its limits on the way, at .* it would not"):
        joint_paths(scene.robot, scene.path, tool=scene.tray.tool)


@pytest.mark.parametrize(
    ("joints", "robot", "message"),
    [
        ([0.0] * 3, {}, "start_joints has 3 angles where 6 are needed: shoulder_pan_joint, "),
        (
            [0.1] * 6,
            {},
            r"start_joints: the tray is .* m.* and .* deg from where the path starts in them; joints within",
        ),
        (["400 deg", 0, 0, 0, 0, 0], {}, "shoulder_pan_joint at 400 deg, outside its limits by 40 deg; it must be"),
        ("home", {}, r'start_joints "home" is not a list'),
        ([0.1] * 6, {"base_yaw": "free"}, "start_joints: where the tray is then depends on base_yaw"),
    ],
)
def test_refused_joints(joints: object, robot: dict[str, object], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        along({**LINE, "start_joints": joints}, **robot)  # type: ignore[arg-type]
