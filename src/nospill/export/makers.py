"""Whose arm a scene has, as far as names tell: formats of one maker are refused for arms of another."""

from __future__ import annotations

import re

from nospill.scene.scene import Scene

_UR_JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
"""Of the maker's own descriptions, behind a prefix perhaps."""

MAKERS = {
    "Universal Robots": r"ur\d+e?",
    "Franka": r"franka|panda|fr3|fer",
    "KUKA": r"kuka|kr\d+|lbr|iiwa\d*",
    "ABB": r"abb|irb\d*|yumi|gofa",
    "Kinova": r"kinova|gen3|jaco|j2[ns]\d\w*",
    "UFACTORY": r"ufactory|xarm\d*|lite6",
    "Comau": r"comau",
}
"""Maker -> what a word of the arm's name is then."""


def maker_of(scene: Scene) -> str | None:
    """The maker of the scene's arm by its name or the names of its joints; None where they do not tell."""
    robot = scene.robot
    if len(robot.joints) == len(_UR_JOINTS) and all(
        name.endswith(known) for name, known in zip(robot.joints, _UR_JOINTS, strict=True)
    ):
        return "Universal Robots"
    for maker, word in MAKERS.items():
        if re.search(rf"(?:^|[^a-z0-9])(?:{word})(?:[^a-z0-9]|$)", robot.name, re.IGNORECASE):
            return maker
    return None
