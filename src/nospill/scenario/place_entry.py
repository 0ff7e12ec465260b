"""Joints of the arm at an end of a path; the place at an end of a free one, by position and yaw or by joints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from typing import Annotated

import numpy as np
from pydantic import Field

from nospill.core.attitudes import angles_between
from nospill.core.units import format_quantity
from nospill.errors import ModelError, ScenarioError
from nospill.robots.description.limits import within_limits
from nospill.robots.description.urdf_tree import about_axis
from nospill.robots.robot import Robot
from nospill.robots.tool import Tool
from nospill.scenario.fields import ANGLE, FREE, JOINT_ANGLE, POINT, WordOr
from nospill.scenario.tables import Given, OptionalQuantities, Table, Values, default

MOST_LEAN = math.radians(0.5)
"""How far the tray may lean in stated joints; angles read off a screen are rounded."""
MOST_MOVED = math.radians(0.5)
"""How far each joint may be from where it holds the tray at the start of a given path, likewise."""
_SHOWN_LEAN = 1e-4
"""rad; from which on a note tells of it."""

_ROUNDING = 1e-9
"""rad; by which joints that hold the tray level may be outside their limits: the pose is off by no more than that."""


class PlaceTable(Table):
    """A place of the tray, level."""

    position: Annotated[OptionalQuantities, POINT, Field(description="of the tray's centre")] = default(None)
    yaw: Annotated[
        float | str,
        WordOr(word=FREE, entry=ANGLE),
        Field(description='of the tray; "free" leaves it to the planner, which chooses one of every 15 deg'),
    ] = 0.0
    joints: Annotated[
        Given[list[Annotated[float, JOINT_ANGLE]] | None, Values | None],
        Field(
            description="of the arm there, one angle for each moving joint, in the place of position and yaw; the tray "
            "is level in them to 0.5 deg"
        ),
    ] = default(None)

    @property
    def is_free(self) -> bool:
        """Whether the yaw is left to the planner."""
        return self.yaw == FREE

    @property
    def heading(self) -> float:
        """The yaw, rad, once it is known."""
        assert isinstance(self.yaw, float)  # as `Placed` has it
        return self.yaw

    @property
    def at(self) -> tuple[float, float, float]:
        """The position, m, once it is known."""
        assert self.position is not None  # as `Placed` has it
        x, y, z = self.position
        return x, y, z


class Placed(PlaceTable):
    """A place with its position.

    Attributes:
        lean: of the tray in stated joints, rad, which are level now.
        moved: how far the joints are from those that were stated, rad.
        measured: which of those were at a limit and a hair beyond, one sentence each.
    """

    lean: float = 0.0
    moved: float = 0.0
    measured: tuple[str, ...] = ()

    def note(self, key: str) -> tuple[str, ...]:
        """What was changed, for people."""
        if self.lean < _SHOWN_LEAN:
            return self.measured
        lean, moved = (format_quantity(value, "angle", digits=3) for value in (self.lean, self.moved))
        return (
            f"{key}: the tray leans {lean} in the stated joints; level, they are up to {moved} from them",
            *self.measured,
        )


def resolve_place(entry: PlaceTable, key: str, robot: Robot, tool: Tool) -> Placed:
    """The place with position and yaw, and with joints in which the tray is level.

    Args:
        entry: as stated; a yaw that is free is zero until it is chosen.
        key: its name in the scenario.
        robot: the arm.
        tool: frame of the tray on its flange.

    Raises:
        ScenarioError: position and joints are both given or both missing; the joints are too many, too few or outside
            their limits, or the tray leans in them. The message starts with the key.
    """
    if entry.joints is None:
        if entry.position is None:
            raise ScenarioError(f"{key}: position is missing; give it, or joints")
        return Placed(position=entry.position, yaw=0.0 if entry.is_free else entry.yaw)
    if entry.position is not None or entry.yaw:
        raise ScenarioError(f"{key}: joints stand in the place of position and yaw; give one or the other")
    # imported here: slow to import, and needed for stated joints only
    from nospill.robots.kinematics.forward import kinematics
    from nospill.robots.kinematics.newton import solve_joints

    q, measured = _within_limits(entry.joints, f"{key}.joints", robot)
    positions, rotations = kinematics(robot).poses(q[None], tool=tool)
    lean = math.acos(min(1.0, float(rotations[0, 2, 2])))
    if lean > MOST_LEAN:
        shown, most = (format_quantity(value, "angle", digits=3) for value in (lean, MOST_LEAN))
        raise ScenarioError(f"{key}.joints: the tray leans {shown} there; it must be level, to {most}")
    yaw = math.atan2(rotations[0, 1, 0], rotations[0, 0, 0])
    try:
        level = solve_joints(robot, positions, about_axis((0.0, 0.0, 1.0), yaw)[None], q[None], tool=tool)[0]
    except ModelError:
        raise ScenarioError(f"{key}.joints: no joints near them hold the tray level; the arm is straight") from None
    inside = np.clip(level, robot.lower, robot.upper)
    moved = float(np.max(np.abs(level - q)))
    if np.any(np.abs(inside - level) > _ROUNDING):
        raise ScenarioError(f"{key}.joints: level, a joint would be outside its limits; move it away from them")
    x, y, z = positions[0].tolist()
    return Placed(position=(x, y, z), yaw=yaw, joints=inside.tolist(), lean=lean, moved=moved, measured=measured)


def joints_at(joints: Sequence[float], key: str, pose: np.ndarray, robot: Robot, tool: Tool) -> list[float]:
    """The joints next to stated ones in which the arm holds the level tray at a pose, rad.

    Args:
        joints: as stated, rad.
        key: its name in the scenario.
        pose: (4,) position (m) and yaw (rad) of the tray.
        robot: the arm.
        tool: frame of the tray on its flange.

    Raises:
        ScenarioError: they are too many, too few or outside their limits, or the arm holds the tray elsewhere in them.
            The message starts with the key.
    """
    # imported here: slow to import, and needed for stated joints only
    from nospill.robots.kinematics.forward import kinematics
    from nospill.robots.kinematics.newton import solve_joints

    (q, _), level = _within_limits(joints, key, robot), about_axis((0.0, 0.0, 1.0), float(pose[3]))
    positions, rotations = kinematics(robot).poses(q[None], tool=tool)
    gap, turn = float(np.linalg.norm(positions[0] - pose[:3])), float(angles_between(level[None], rotations)[0])
    with suppress(ModelError):
        found = solve_joints(robot, pose[None, :3], level[None], q[None], tool=tool)[0]
        inside = np.clip(found, robot.lower, robot.upper)
        if np.abs(found - q).max() <= MOST_MOVED and np.abs(inside - found).max() <= _ROUNDING:
            return inside.tolist()
    far, turned, most = (
        format_quantity(*value, digits=3) for value in ((gap, "length"), (turn, "angle"), (MOST_MOVED, "angle"))
    )
    raise ScenarioError(
        f"{key}: the tray is {far} and {turned} from where the path starts in them; joints within {most} of those that "
        "hold it there are allowed, or leave the key out"
    )


def _within_limits(joints: Sequence[float], key: str, robot: Robot) -> tuple[np.ndarray, tuple[str, ...]]:
    if len(joints) != len(robot.joints):
        names = ", ".join(robot.joints)
        raise ScenarioError(f"{key} has {len(joints)} angles where {len(robot.joints)} are needed: {names}")
    return within_limits(robot, joints, key)
