"""The keys of `[approach]`: where the arm comes from, what is on the tray meanwhile, and how fast it may go."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import ConfigDict, Field

from nospill.core.arrays import read_only
from nospill.core.units import format_quantity
from nospill.errors import ROBOT, Change, Reason, ScenarioError
from nospill.robots.description.limits import within_limits
from nospill.robots.robot import Robot
from nospill.scenario.fields import JOINT_ANGLE, JointValues, Measured, WordOr
from nospill.scenario.tables import Given, OptionalQuantityOrList, Quantity, Table, Values, default
from nospill.scene.scene import ApproachRules

HOME = "home"
BUILD_UP = 0.1
"""s; in this time the full acceleration is built up where nobody states a jerk."""


def _limit(dimension: str, at_most: float) -> JointValues:
    return JointValues(entry=Measured(dimension=dimension, above=0.0, at_most=at_most))


_SCALE = Measured(dimension="ratio", at_least=0.01, at_most=1.0)


class ApproachTable(Table):
    """`[approach]`: how the arm gets from where it is to the start of the motion."""

    model_config = ConfigDict(extra="forbid", frozen=True, serialize_by_alias=True)

    start: Annotated[
        Given[str | tuple[float, ...], str | Values],
        WordOr(word=HOME, entry=JOINT_ANGLE, several=True),
        Field(alias="from", description='where the arm is: "home", or one angle for each moving joint'),
    ]
    tray: Annotated[
        Literal["empty", "loaded"], Field(description='whether the cargo is on the tray: "empty" or "loaded"')
    ]
    speed_scale: Annotated[
        Quantity, _SCALE, Field(description="part of the joint speeds that the approach is planned with")
    ] = default(0.5)
    acceleration_scale: Annotated[Quantity, _SCALE, Field(description="part of the joint accelerations, likewise")] = (
        default(0.5)
    )
    acceleration: Annotated[
        OptionalQuantityOrList,
        _limit("angular_acceleration", 1e4),
        Field(description="joint accelerations; needed where the robot's data have none"),
    ] = default(None)
    jerk: Annotated[
        OptionalQuantityOrList,
        _limit("angular_jerk", 1e7),
        Field(description="joint jerks; without any, the full acceleration is built up in 0.1 s"),
    ] = default(None)

    def build(self, robot: Robot) -> ApproachRules:
        """The rules for an arm; what the table states never goes beyond the robot's own limits.

        Raises:
            ScenarioError: a wrong number of values, a start outside the limits, no home or no acceleration known; the
                message starts with the key.
        """
        acceleration = _stated(self.acceleration, "acceleration", robot, robot.max_acceleration)
        if acceleration is None:
            raise ScenarioError(
                f"acceleration is missing: no joint accelerations are known for robot {robot.name!r}; "
                'write one for all joints, for example acceleration = "5 rad/s^2", or a list, one for each'
            )
        jerk = _stated(self.jerk, "jerk", robot, robot.max_jerk)
        return ApproachRules(
            start=read_only(self._start(robot)),
            loaded=self.tray == "loaded",
            max_speed=robot.max_speed,
            max_acceleration=read_only(acceleration),
            max_jerk=read_only(acceleration / BUILD_UP if jerk is None else jerk),
            speed_scale=self.speed_scale,
            acceleration_scale=self.acceleration_scale,
        )

    def _start(self, robot: Robot) -> np.ndarray:
        if isinstance(self.start, str):
            if robot.home is None:
                raise ScenarioError(
                    f'from is "{HOME}", but no home is known for robot {robot.name!r}; '
                    "give home under [robot], or the joint angles here"
                )
            return robot.home
        _require_count(self.start, "from", robot)
        start = self.start
        return within_limits(robot, start, "from", lambda name: _start_reason(start, robot, name))[0]


def _start_reason(start: tuple[float, ...], robot: Robot, joint: str) -> Reason:
    """The reason for a joint that starts outside its limits, and the start at home, where there is one.

    At the limit itself an arm may well be folded on itself.
    """
    index = robot.joints.index(joint)
    angle = start[index]
    excess = float(max(robot.lower[index] - angle, angle - robot.upper[index]))
    text = f'from = "{HOME}" instead of {joint} at {format_quantity(angle, "angle")}'
    home = Change(f"joint position of {joint}", "approach.from", HOME, text)
    changes = () if robot.home is None else (home,)
    return Reason(ROBOT, "joint position", joint, excess=excess, unit="rad", changes=changes)


def _stated(
    given: float | tuple[float, ...] | None, key: str, robot: Robot, known: np.ndarray | None
) -> np.ndarray | None:
    """The values (n,) of a key, none above the robot's own; the robot's where it is not given."""
    if given is None:
        return known
    if isinstance(given, tuple):
        _require_count(given, key, robot)
    values = np.broadcast_to(np.array(given, dtype=float), len(robot.joints))
    return values if known is None else np.minimum(values, known)


def _require_count(given: tuple[float, ...], key: str, robot: Robot) -> None:
    if len(given) != len(robot.joints):
        values = "1 value" if len(given) == 1 else f"{len(given)} values"
        names = ", ".join(robot.joints)
        raise ScenarioError(f"{key} has {values} where {len(robot.joints)} are needed, one for each of {names}")
