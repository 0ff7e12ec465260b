"""What commands say of a scene before they plan it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nospill.cli.reporting import one_line
from nospill.cli.tables import say

if TYPE_CHECKING:  # for annotations only: at run time these would load numpy and CasADi before the help text
    from nospill.scene.scene import Scene


def say_notes(scene: Scene) -> None:
    """Say what was noted and doubted of the arm's description, which limits are not known, and notes on the path."""
    from nospill.core.units import listed
    from nospill.robots.description.limits import unlimited

    robot = scene.robot
    for note in robot.notes:
        say(f"{robot.name}: {one_line(note)}")
    for doubt in robot.doubts:
        say(f"{robot.name}, {doubt.about}: {one_line(doubt.text)}")
    if "urdf" in scene.source["robot"] and (kinds := unlimited(robot)):
        keys = listed([f"limits.{kind}" for kind in kinds], last="and")
        say(
            f"{robot.name}: no limit of joint {listed(kinds, last='and')} is known, and none is kept; {keys} under "
            "[robot] state them"
        )
    for note in scene.path.notes:
        say(f"path: {one_line(note)}")
