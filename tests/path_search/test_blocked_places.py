"""Places that no configuration passes: random tilts and positions of the seventh joint find none either."""

from __future__ import annotations

import math

import numpy as np
import pytest

from nospill.collisions.along_path import freest_of_arm
from nospill.core.attitudes import matrices, tray_quaternions
from nospill.errors import ROBOT, NoSolutionError
from nospill.path_search.blocked_places import blocked_place
from nospill.path_search.level_arm import LEVER, LevelArm
from nospill.path_search.standing import advised_free_paths
from nospill.scenario import load
from nospill.scene.scene import Scene
from tests.builders import joint_paths_of

MIDDLE = 0.5


def near_the_base(model: str, z: float, *, x: float = 0.2, tilt: str = "", corridor: str = "") -> Scene:
    """A wide tray that passes beside the arm's own base."""
    leans = {"tilt": "free", "max_tilt": tilt} if tilt else {}
    cup = {"name": "cup", "at": [0.02, 0.0], "shape": "cylinder", "radius": "40 mm", "height": "95 mm", "mass": 0.3}
    line: dict[str, object] = {"type": "line", "start": [x, -0.35, z], "end": [x, 0.35, z], "yaw": ["0 deg", "60 deg"]}
    if corridor:
        line["corridor"] = corridor
    return load(
        {
            "name": "near",
            "robot": {"model": model},
            "tray": {"size": ["500 mm", "500 mm"], "friction": 0.4, "mass": "0.5 kg", "offset": "50 mm"},
            "path": line,
            "motion": {"end": "residual", **leans},
            "cargo": [cup],
        }
    )


@pytest.mark.parametrize(
    ("model", "z", "tilt"), [("ur10e", 0.15, "10 deg"), ("franka-fr3", 0.25, ""), ("franka-fr3", 0.25, "10 deg")]
)
def test_no_random_tilt_or_self_motion_is_clear_where_none_is_said_to_be(model: str, z: float, tilt: str) -> None:
    scene = near_the_base(model, z, tilt=tilt)
    found = blocked_place(scene, [MIDDLE])
    assert found is not None and found.s == MIDDLE and found.slack < -0.02
    random, arm, count = np.random.default_rng(5), LevelArm(scene), 400
    greatest = scene.motion.max_tilt if tilt else 0.0
    theta_x, theta_y = random.uniform(-greatest, greatest, (2, count))
    x, y, height, yaw = scene.path.at(np.array([MIDDLE]))[0]
    rotations = matrices(tray_quaternions(np.full(count, yaw), theta_y, theta_x))
    held = random.choice(arm.held[::6], count)
    q = np.concatenate(arm.solutions_at(np.tile([x, y, height], (count, 1)), rotations, held))
    freest = freest_of_arm(scene, q, MIDDLE)
    assert len(q) > count // 2 and freest is not None
    assert freest.slack < 0.0 and freest.slack <= found.slack + 0.5 * LEVER * math.radians(7.5)


def test_what_a_tilt_may_cure_is_left_to_the_search() -> None:
    """23 mm are missing of the level tray, and less than half a step of the tilt of one that leans."""
    level = near_the_base("ur10e", 0.25, x=0.25)
    found = blocked_place(level, [0.495])
    assert found is not None and -0.03 < found.slack < -0.02
    assert blocked_place(near_the_base("ur10e", 0.25, x=0.25, tilt="10 deg"), [0.495]) is None
    assert blocked_place(near_the_base("ur10e", 0.25, x=0.25, corridor="50 mm"), [0.495]) is None


def test_the_refusal_says_where_and_what_was_tried_in_vain() -> None:
    scene = near_the_base("ur10e", 0.15, tilt="10 deg")
    with pytest.raises(NoSolutionError) as caught:
        advised_free_paths(scene, joint_paths_of(scene))
    text, reason = str(caught.value), caught.value.reason
    assert text.startswith("No way found for the arm: in the freest of all configurations and tilts of the tray ")
    assert " at s = 0.5" in text and "(x, y, z = 200, " in text
    assert reason is not None and reason.kind == ROBOT and reason.unit == "m"
    for change in reason.changes:
        assert advised_free_paths(scene.changed(change.values), joint_paths_of(scene.changed(change.values)))
    assert reason.changes or "move the path, or keep " in text
