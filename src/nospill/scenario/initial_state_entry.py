"""`[initial_state]`: how arm and tray move when the motion begins, where it goes on from another one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import numpy as np
from pydantic import Field

from nospill.core.attitudes import angles_between
from nospill.core.units import format_quantity
from nospill.errors import ScenarioError
from nospill.paths.path import Path
from nospill.robots.robot import Robot
from nospill.robots.tool import Tool
from nospill.scenario.fields import ANGLE, JOINT_ANGLE, Measured, Vector
from nospill.scenario.tables import Given, Quantities, Quantity, Table, Values, default
from nospill.scene.initial_state import InitialState

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
        Quantity,
        Measured(dimension="number", at_least=0.0, below=1.0),
        Field(description="path parameter, 0 at the start of the path and 1 at its end"),
    ]
    s_rate: Annotated[
        Quantity, Measured(dimension="number", at_least=0.0, at_most=1e3), Field(description="its rate, 1/s")
    ]
    s_acceleration: Annotated[Quantity, _NUMBER, Field(description="its second derivative, 1/s^2")]
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

    def build(self, robot: Robot, tool: Tool, path: Path) -> InitialState:
        """The state of an arm and its tray on a path.

        Raises:
            ScenarioError: not a value for every joint, a joint that is faster than it may be or out of its range, or
                joints that do not carry the tray as its path says; starts with the key.
        """
        for key in ("joint_position", "joint_speed", "joint_acceleration"):
            values = getattr(self, key)
            if len(values) != len(robot.joints):
                raise ScenarioError(
                    f"{key} has {len(values)} values where {len(robot.joints)} are needed, one for each of "
                    f"{', '.join(robot.joints)}"
                )
        state = InitialState(
            s=self.s,
            s_rate=self.s_rate,
            s_acceleration=self.s_acceleration,
            tilt=_pair(self.tilt),
            tilt_rate=_pair(self.tilt_rate),
            tilt_acceleration=_pair(self.tilt_acceleration),
            joint_position=tuple(self.joint_position),
            joint_speed=tuple(self.joint_speed),
            joint_acceleration=tuple(self.joint_acceleration),
        )
        _require_limits(state, robot)
        _require_on_path(state, robot, tool, path)
        return state


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


def _require_on_path(state: InitialState, robot: Robot, tool: Tool, path: Path) -> None:
    """Refuse joints that do not carry the tray as path and tilt say, with its velocity and acceleration."""
    from nospill.robots.kinematics.forward import kinematics  # CasADi: a scenario that begins at rest needs none of it

    tray = kinematics(robot).motions(*(part[None] for part in state.joints), tool=tool)
    if path.joint_curve is not None:
        value, first, second, _ = path.joint_curve.rates(np.array([state.s]))
        wanted = (
            value[0],
            first[0] * state.s_rate,
            second[0] * state.s_rate**2 + first[0] * state.s_acceleration,
        )
        gaps = [float(np.max(np.abs(own - along))) for own, along in zip(state.joints, wanted, strict=True)]
        _refuse_gaps(gaps, ("rad", "rad/s", "rad/s^2"), state.s)
        return
    pose, first, second = (path.derivative([state.s], order)[0] for order in range(3))
    rate, change = first * state.s_rate, second * state.s_rate**2 + first * state.s_acceleration
    turn = float(angles_between(tray.rotation, state.attitude(float(pose[3]))[None])[0])
    omega, alpha = _turning((pose[3], rate[3], change[3]), state.chains[2], state.chains[1])
    gaps = [
        max(float(np.linalg.norm(tray.position[0] - pose[:3])), turn),
        max(
            float(np.linalg.norm(tray.velocity[0] - rate[:3])),
            float(np.linalg.norm(tray.rotation[0].T @ tray.angular_velocity[0] - omega)),
        ),
        max(
            float(np.linalg.norm(tray.acceleration[0] - change[:3])),
            float(np.linalg.norm(tray.rotation[0].T @ tray.angular_acceleration[0] - alpha)),
        ),
    ]
    _refuse_gaps(gaps, ("m or rad", "m/s or rad/s", "m/s^2 or rad/s^2"), state.s)


def _turning(*angles: Sequence[float] | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angular velocity and acceleration (3,) in tray axes, from yaw, theta_y and theta_x, each with its rates."""
    import casadi as ca

    from nospill.core.frames import SX, tray_rates

    yaw, theta_y, theta_x = ((SX(float(a)), SX(float(b)), SX(float(c))) for a, b, c in angles)
    omega, alpha = (np.array(ca.evalf(part)).ravel() for part in tray_rates(yaw, theta_y, theta_x))
    return omega, alpha


def _refuse_gaps(gaps: list[float], units: tuple[str, str, str], s: float) -> None:
    most = (OFF_PATH, OFF_PATH_SPEED, OFF_PATH_ACCELERATION)
    keys = ("joint_position", "joint_speed", "joint_acceleration")
    for key, gap, allowed, unit in zip(keys, gaps, most, units, strict=True):
        if not gap <= allowed:
            raise ScenarioError(
                f"{key}: the joints carry the tray {gap:.3g} {unit} off its path at s = {s:.6g}; at most {allowed:g} "
                "is allowed: take the state from a plan on this path, with plan.state_at(t)"
            )
