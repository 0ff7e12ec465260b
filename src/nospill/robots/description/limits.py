"""Limits of an arm changed by the scenario: given instead of the data's, scaled, left out; whether they can be true."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from nospill.core.arrays import read_only
from nospill.core.units import format_quantity
from nospill.errors import ScenarioError
from nospill.robots.robot import Robot

PerJoint = float | tuple[float, ...] | None
"""A value for each joint, one for all, or none given."""

_EXAMPLES = {"speed": "140 deg/s", "lower": "-170 deg", "upper": "170 deg"}
_DIMENSIONS = {
    "lower": "angle",
    "upper": "angle",
    "speed": "angular_speed",
    "acceleration": "angular_acceleration",
    "jerk": "angular_jerk",
    "torque": "torque",
}
_FIELDS = {
    "lower": "lower",
    "upper": "upper",
    "speed": "max_speed",
    "acceleration": "max_acceleration",
    "jerk": "max_jerk",
    "torque": "max_torque",
}


@dataclass(frozen=True, slots=True)
class LimitChanges:
    """What a scenario says about limits; None where it says nothing.

    Attributes:
        lower, upper: rad. speed: rad/s. acceleration: rad/s^2. jerk: rad/s^3. torque: N m.
        speed_scale, acceleration_scale, jerk_scale, torque_scale: factor on the limit, above 0 and at most 1.
    """

    lower: PerJoint = None
    upper: PerJoint = None
    speed: PerJoint = None
    acceleration: PerJoint = None
    jerk: PerJoint = None
    torque: PerJoint = None
    speed_scale: float | None = None
    acceleration_scale: float | None = None
    jerk_scale: float | None = None
    torque_scale: float | None = None


def changed_limits(robot: Robot, changes: LimitChanges, *, inertia_fault: str | None = None) -> Robot:
    """Return the arm with other limits.

    Args:
        robot: the arm; NaN in `lower`, `upper` or `max_speed` means that its data set none.
        changes: values and scales.
        inertia_fault: why its inertias cannot be real, for the message.

    Raises:
        ScenarioError: a wrong number of values, a scale for a limit that is not set, a torque limit without real
            inertias, a limit nobody sets, or limits that contradict each other. The message starts with the key.
    """
    values: dict[str, np.ndarray | None] = {}
    sources = dict(robot.sources)
    not_known = list(robot.not_known)
    for key, field in _FIELDS.items():
        data = getattr(robot, field)
        given = getattr(changes, key)
        scale = getattr(changes, f"{key}_scale", None)
        value = data if given is None else _per_joint(given, key, robot)
        kind = "position" if key in ("lower", "upper") else key
        if given is not None:
            sources[kind] = "given in the scenario"
            not_known = [entry for entry in not_known if entry != f"joint {kind}"]
        if scale is not None:
            if value is None or np.isnan(value).any():
                raise ScenarioError(
                    f"limits.{key}_scale is given, but no {key} limit is known for robot {robot.name!r}; "
                    f"give limits.{key} too"
                )
            if scale != 1.0:
                value = value * scale
                sources[kind] = f"{sources.get(kind, 'the data of the robot')}; scaled to {100.0 * scale:.6g} %"
        values[key] = value
    if values["torque"] is not None and not robot.inertias_known:
        reason = inertia_fault or "nobody states them"
        raise ScenarioError(
            f"limits.torque is given, but the masses and inertias of robot {robot.name!r} are not known ({reason}), "
            "so torques cannot be computed; leave it out or give a URDF with real inertias"
        )
    _check(robot, values)
    return replace(
        robot,
        **{field: None if (value := values[key]) is None else read_only(value) for key, field in _FIELDS.items()},
        sources=sources,
        not_known=tuple(not_known),
    )


def position_and_speed_only(robot: Robot) -> Robot:
    """Return the arm without limits of acceleration, jerk and torque: limits as published for some experiments."""
    return replace(robot, max_acceleration=None, max_jerk=None, max_torque=None)


def with_home(robot: Robot, home: Sequence[float] | None) -> Robot:
    """Return the arm with the start configuration of the scenario, or its own one if that is within the limits.

    Args:
        robot: the arm.
        home: (n,) rad, or None.

    Raises:
        ScenarioError: a wrong number of values, or one outside the limits; the message starts with the key.
    """
    if home is None:
        if robot.home is None or ((robot.home >= robot.lower) & (robot.home <= robot.upper)).all():
            return robot
        note = "the catalogue's home is outside the limits given and is left out"
        return replace(robot, home=None, notes=(*robot.notes, note))
    joints = robot.joints
    if len(home) != len(joints):
        raise ScenarioError(_count("home", len(home), joints))
    for name, value, lower, upper in zip(joints, home, robot.lower, robot.upper, strict=True):
        if not lower <= value <= upper:
            raise ScenarioError(
                f"home has {name} at {format_quantity(value, 'angle')}, outside its limits; it must be from "
                f"{format_quantity(lower, 'angle')} to {format_quantity(upper, 'angle')}"
            )
    return replace(robot, home=read_only(np.array(home)))


def _per_joint(given: float | tuple[float, ...], key: str, robot: Robot) -> np.ndarray:
    count = len(robot.joints)
    if isinstance(given, tuple):
        if len(given) != count:
            raise ScenarioError(_count(f"limits.{key}", len(given), robot.joints))
        return np.array(given)
    return np.full(count, given)


def _count(key: str, given: int, joints: Sequence[str]) -> str:
    values = "1 value" if given == 1 else f"{given} values"
    return f"{key} has {values} where {len(joints)} are needed, one for each of {', '.join(joints)}"


def _check(robot: Robot, values: dict[str, np.ndarray | None]) -> None:
    for key in ("lower", "upper", "speed"):
        value = values[key]
        assert value is not None  # never optional in a Robot
        missing = [name for name, entry in zip(robot.joints, value, strict=True) if np.isnan(entry)]
        if missing:
            raise ScenarioError(
                f"limits.{key} is missing: the URDF sets none for {', '.join(missing)} (placeholders do not count); "
                f'write it under [robot.limits], for example {key} = "{_EXAMPLES[key]}", or a list, one for each joint'
            )
    lower, upper = values["lower"], values["upper"]
    assert lower is not None and upper is not None
    for name, low, high in zip(robot.joints, lower, upper, strict=True):
        if not low < high:
            raise ScenarioError(
                f"limits of {name} contradict each other: lower {format_quantity(low, 'angle')} is not below "
                f"upper {format_quantity(high, 'angle')}"
            )
    for key in ("speed", "acceleration", "jerk", "torque"):
        value = values[key]
        if value is not None and not (value > 0.0).all():
            joint = int(np.argmin(value))
            shown = format_quantity(float(value[joint]), _DIMENSIONS[key])
            raise ScenarioError(f"limits.{key} of {robot.joints[joint]} is {shown}; it must be above 0")
