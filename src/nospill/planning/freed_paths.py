"""A path of the joints as the way about which a free path is looked for."""

from __future__ import annotations

from typing import Any

import numpy as np

from nospill.core.units import format_quantity
from nospill.errors import ScenarioError
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.redundancy import redundant_joint
from nospill.scenario.place_entry import MOST_LEAN
from nospill.scene.scene import Scene

_POINTS = 61
"""Of the way, at even parameters of the path of the joints."""


def free_path_table(scene: Scene, corridor: float | str) -> dict[str, Any]:
    """The table `[path]` of a free path along the tray's way of a path of the joints.

    Its ends are the joints of the path's ends; between them the tray's centre may be beside the way by the corridor,
    and is turned, and leans where the scenario lets it, as is fastest.

    Args:
        scene: with a path of the joints.
        corridor: m, or a text with its unit.

    Raises:
        ScenarioError: the tray leans on the path: the free one begins with a level one.
    """
    curve, robot = scene.path.joint_curve, scene.robot
    assert curve is not None  # the caller's path is one of the joints
    q = curve.joints(np.linspace(0.0, 1.0, _POINTS))
    position, rotation = kinematics(robot).poses(q, tool=scene.tray.tool)
    lean = np.arccos(np.clip(rotation[:, 2, 2], -1.0, 1.0))
    worst = int(np.argmax(lean))
    if lean[worst] > MOST_LEAN:  # as at the ends: what leans more is not where the level way has it
        shown = format_quantity(float(lean[worst]), "angle", digits=3)
        raise ScenarioError(
            f"path: the tray leans {shown} at s = {worst / (_POINTS - 1):.2f} of the given joints; a free path is "
            'looked for about a level way (motion.tilt = "free" lets it lean from there). Leave freedom out to keep '
            "the joints as given"
        )
    table: dict[str, Any] = {
        "type": "free",
        "start": {"joints": q[0].tolist()},
        "goal": {"joints": q[-1].tolist()},
        "way": position.tolist(),
        "way_yaw": np.unwrap(np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0])).tolist(),
        "corridor": corridor,
    }
    return table | ({} if redundant_joint(robot) is None else {"way_joints": q.tolist()})
