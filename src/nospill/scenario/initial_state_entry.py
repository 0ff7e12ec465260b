"""`[initial_state]`: how arm and tray move when the motion begins, where it goes on from another one."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from pydantic import Field

from nospill.core.units import format_quantity
from nospill.errors import ScenarioError
from nospill.paths.path import Path
from nospill.robots.robot import Robot
from nospill.robots.tool import Tool
from nospill.scenario.fields import ANGLE, JOINT_ANGLE, Measured, Vector
from nospill.scenario.tables import Given, Quantities, Table, Values, default
from nospill.scene.initial_state import InitialState
from nospill.scene.scene import MotionRules

OFF_PATH, OFF_PATH_SPEED, OFF_PATH_ACCELERATION = 1e-6, 1e-4, 1e-2
"""m and rad, and per s and s^2: what the joints make of the tray may be so far from what its path says."""
_NUMBER = Measured(dimension="number", at_least=-1e6, at_most=1e6)
_RATE = Measured(dimension="angular_speed", kind="rate in motion", at_least=-1e3, at_most=1e3)
_CHANGE = Measured(dimension="angular_acceleration", kind="acceleration in motion", at_least=-1e6, at_most=1e6)
_TILT_AXES = ("theta_x", "theta_y")
_OVER = 1e-3
"""Part of a joint speed limit by which a state may be over it: as the judge finds between samples of the motion."""


class InitialStateTable(Table):
    """`[initial_state]`: how arm and tray move when the motion begins; without it, they stand still.

    `plan.state_at(t)` gives one, with the swing of every liquid.
    """

    s: Annotated[
        Annotated[float, Measured(dimension="number", at_least=0.0, below=1.0)] | None,
        Field(
            description="path parameter, 0 at the start of the path and 1 at its end; where the tray may leave its "
            "path, the place nearest to the tray when not given"
        ),
    ] = default(None)
    s_rate: Annotated[
        Annotated[float, Measured(dimension="number", at_least=0.0, at_most=1e3)] | None,
        Field(description="its rate, 1/s; stated with s"),
    ] = default(None)
    s_acceleration: Annotated[
        Annotated[float, _NUMBER] | None, Field(description="its second derivative, 1/s^2; stated with s")
    ] = default(None)
    tilt: Annotated[Quantities, Vector(entry=ANGLE, axes=_TILT_AXES), Field(description="the two tilt angles")] = (
        default((0.0, 0.0))
    )
    tilt_rate: Annotated[Quantities, Vector(entry=_RATE, axes=_TILT_AXES), Field(description="their rates")] = default(
        (0.0, 0.0)
    )
    tilt_acceleration: Annotated[
        Quantities, Vector(entry=_CHANGE, axes=_TILT_AXES), Field(description="their accelerations")
    ] = default((0.0, 0.0))
    joint_position: Annotated[
        Given[list[Annotated[float, JOINT_ANGLE]], Values],
        Field(description="one angle for each moving joint", max_length=16),
    ]
    joint_speed: Annotated[
        Given[list[Annotated[float, _RATE]], Values], Field(description="their speeds", max_length=16)
    ]
    joint_acceleration: Annotated[
        Given[list[Annotated[float, _CHANGE]], Values], Field(description="their accelerations", max_length=16)
    ]

    def build(self, robot: Robot, tool: Tool, path: Path, rules: MotionRules) -> InitialState:
        """The state of an arm and its tray about a path.

        Args:
            robot: whose joints they are.
            tool: the tray in the flange's frame.
            path: of the motion.
            rules: whether the tray may leave it, and how far.

        Raises:
            ScenarioError: not a value for every joint, a joint that is faster than it may be or out of its range, no
                place on a path that the tray keeps to, joints that do not carry the tray as its path says or carry it
                outside of the corridor; starts with the key.
        """
        for key in ("joint_position", "joint_speed", "joint_acceleration"):
            values = getattr(self, key)
            if len(values) != len(robot.joints):
                raise ScenarioError(
                    f"{key} has {len(values)} values where {len(robot.joints)} are needed, one for each of "
                    f"{', '.join(robot.joints)}"
                )
        along = self._along(required=not rules.leaves_path)
        state = InitialState(
            *(along or (0.0, 0.0, 0.0)),
            tilt=_pair(self.tilt),
            tilt_rate=_pair(self.tilt_rate),
            tilt_acceleration=_pair(self.tilt_acceleration),
            joint_position=tuple(self.joint_position),
            joint_speed=tuple(self.joint_speed),
            joint_acceleration=tuple(self.joint_acceleration),
        )
        _require_limits(state, robot)
        if path.joint_curve is not None:
            _refuse_gaps(_joint_curve_gaps(state, path), ("rad", "rad/s", "rad/s^2"), state.s)
            return state
        # CasADi: a scenario that begins at rest needs none of it
        from nospill.scenario.about_the_path import gaps_of_attitude, state_about

        state, beside = state_about(state, along is not None, robot, tool, path, rules)
        lean = gaps_of_attitude(state, robot, tool)
        gaps = [max(pair) for pair in zip(beside, lean, strict=True)]
        _refuse_gaps(gaps, ("m or rad", "m/s or rad/s", "m/s^2 or rad/s^2"), state.s)
        _require_in_corridor(state, rules)
        return state

    def _along(self, *, required: bool) -> tuple[float, float, float] | None:
        """The place on the path with its rates, None where it is to be found."""
        keys = ("s", "s_rate", "s_acceleration")
        values = (self.s, self.s_rate, self.s_acceleration)
        missing = [key for key, value in zip(keys, values, strict=True) if value is None]
        if not missing:
            s, rate, change = (float(value or 0.0) for value in values)
            return s, rate, change
        if required or len(missing) < len(keys):
            raise ScenarioError(
                f"{missing[0]} is missing; all of {', '.join(keys)} say where the tray is on its path, as "
                "plan.state_at(t) does; they may be left out together where the tray may leave its path"
            )
        return None


def _pair(values: tuple[float, ...]) -> tuple[float, float]:
    first, second = values
    return first, second


def _require_limits(state: InitialState, robot: Robot) -> None:
    q, speed, _ = state.joints
    out = np.maximum(robot.lower - q, q - robot.upper)
    if np.max(out) > OFF_PATH:
        joint = int(np.argmax(out))
        angle, least, most = (
            format_quantity(float(value), "angle", digits=5)
            for value in (q[joint], robot.lower[joint], robot.upper[joint])
        )
        raise ScenarioError(f"joint_position: {robot.joints[joint]} at {angle} is out of its range, {least} to {most}")
    use = np.abs(speed) / robot.max_speed
    if np.max(use) > 1.0 + _OVER:
        joint = int(np.argmax(use))
        shown, most = (
            format_quantity(float(value), "angular_speed", digits=5) for value in (speed[joint], robot.max_speed[joint])
        )
        raise ScenarioError(
            f"joint_speed: {robot.joints[joint]} moves at {shown}, above its limit {most}; no motion goes on from there"
        )


def _require_in_corridor(state: InitialState, rules: MotionRules) -> None:
    away = math.dist(state.offset[0], (0.0, 0.0, 0.0))
    if rules.corridor is not None and away > rules.corridor + OFF_PATH:
        shown, width = (format_quantity(length, "length", digits=3) for length in (away, rules.corridor))
        raise ScenarioError(
            f"joint_position: the joints carry the tray {shown} beside its path at s = {state.s:.3g}, and "
            f"path.corridor is {width}; make it wider, or give a path that begins nearer"
        )


def _joint_curve_gaps(state: InitialState, path: Path) -> list[float]:
    """How far the joints, their speeds and accelerations are from those on a path of theirs."""
    assert path.joint_curve is not None  # the caller's is one
    value, first, second, _ = path.joint_curve.rates(np.array([state.s]))
    wanted = (value[0], first[0] * state.s_rate, second[0] * state.s_rate**2 + first[0] * state.s_acceleration)
    return [float(np.max(np.abs(own - along))) for own, along in zip(state.joints, wanted, strict=True)]


def _refuse_gaps(gaps: list[float], units: tuple[str, str, str], s: float) -> None:
    most = (OFF_PATH, OFF_PATH_SPEED, OFF_PATH_ACCELERATION)
    keys = ("joint_position", "joint_speed", "joint_acceleration")
    for key, gap, allowed, unit in zip(keys, gaps, most, units, strict=True):
        if not gap <= allowed:
            raise ScenarioError(
                f"{key}: the joints carry the tray {gap:.3g} {unit} off its path at s = {s:.6g}; at most {allowed:g} "
                "is allowed: take the state from a plan on this path, with plan.state_at(t), or let the tray leave it: "
                "path.corridor, and a path.yaw that is free"
            )
