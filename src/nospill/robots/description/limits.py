"""Joint limits: the arm's own, changed by the scenario (replaced, scaled, left out), and checked to be complete."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from nospill.core.arrays import read_only
from nospill.core.units import format_quantity
from nospill.errors import Reason, ScenarioError
from nospill.robots.robot import Robot

PerJoint = float | tuple[float, ...] | None
"""A value for each joint, one for all, or none given."""

MEASURED = 1e-4
"""rad; by which positions that a controller reports may be outside the limits: as far as a start may be missed."""

_EXAMPLES = {"speed": "140 deg/s", "lower": "-170 deg", "upper": "170 deg"}
_DIMENSIONS = {
    "lower": "angle",
    "upper": "angle",
    "speed": "angular_speed",
    "acceleration": "angular_acceleration",
    "jerk": "angular_jerk",
    "torque": "torque",
}
_KEYS = {
    "lower": "lower",
    "upper": "upper",
    "max_speed": "speed",
    "max_acceleration": "acceleration",
    "max_jerk": "jerk",
    "max_torque": "torque",
}
"""Attribute of a limit -> its key under [robot.limits]."""


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Joint limits of an arm and where each comes from; a `Robot` is built once they are complete.

    Attributes:
        lower: (n,) rad; NaN for a joint whose data set none.
        upper: likewise.
        max_speed: (n,) rad/s, likewise.
        max_acceleration: (n,) rad/s^2, or None where it is not limited.
        max_jerk: (n,) rad/s^3, or None.
        max_torque: (n,) N m, or None.
        sources: quantity -> where the figure comes from.
        not_known: quantities nobody states for the arm, in words.
    """

    lower: np.ndarray
    upper: np.ndarray
    max_speed: np.ndarray
    max_acceleration: np.ndarray | None
    max_jerk: np.ndarray | None
    max_torque: np.ndarray | None
    sources: Mapping[str, str]
    not_known: tuple[str, ...]

    def fields(self) -> dict[str, Any]:
        """The same as the fields of a `Robot`."""
        values: dict[str, np.ndarray | None] = {name: getattr(self, name) for name in _KEYS}
        arrays = {name: None if value is None else read_only(value) for name, value in values.items()}
        return {**arrays, "sources": dict(self.sources), "not_known": self.not_known}


@dataclass(frozen=True, slots=True)
class LimitChanges:
    """Joint limits in a scenario, in place of the arm's own or scaling them; None where it states nothing.

    Attributes:
        lower: rad.
        upper: rad.
        max_speed: rad/s.
        max_acceleration: rad/s^2.
        max_jerk: rad/s^3.
        max_torque: N m.
        scales: attribute -> factor on the limit, above 0 and at most 1.
    """

    lower: PerJoint = None
    upper: PerJoint = None
    max_speed: PerJoint = None
    max_acceleration: PerJoint = None
    max_jerk: PerJoint = None
    max_torque: PerJoint = None
    scales: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class LimitedArm:
    """The arm that limits belong to, as far as they and their messages need it.

    Attributes:
        name: of the robot.
        joints: names of its moving joints.
        inertias_known: whether joint torques can be computed.
        inertia_fault: why its inertias cannot be real, or None.
        not_set: key of a limit -> joint -> why its description sets none, as the end of "the URDF states ...".
    """

    name: str
    joints: tuple[str, ...]
    inertias_known: bool
    inertia_fault: str | None = None
    not_set: Mapping[str, Mapping[str, str]] = field(default_factory=dict)


def limits_of(robot: Robot) -> JointLimits:
    """Return the joint limits of a robot."""
    return JointLimits(**{name: getattr(robot, name) for name in (*_KEYS, "sources", "not_known")})


def changed_limits(limits: JointLimits, changes: LimitChanges, arm: LimitedArm) -> JointLimits:
    """Return limits as changed, complete: no NaN is left.

    Args:
        limits: the arm's own.
        changes: values and scales.
        arm: the arm.

    Raises:
        ScenarioError: a wrong number of values, a scale for a limit that is not set, a torque limit without real
            inertias, a limit nobody sets, or limits that contradict each other. The message starts with the key.
    """
    values: dict[str, np.ndarray | None] = {}
    sources = dict(limits.sources)
    not_known = list(limits.not_known)
    for name, key in _KEYS.items():
        data = getattr(limits, name)
        given = getattr(changes, name)
        scale = changes.scales.get(name)
        value = data if given is None else _per_joint(given, key, arm.joints)
        kind = "position" if key in ("lower", "upper") else key
        if given is not None:
            sources[kind] = "given in the scenario"
            not_known = [entry for entry in not_known if entry != f"joint {kind}"]
        if scale is not None:
            if value is None or np.isnan(value).any():
                raise ScenarioError(
                    f"limits.{key}_scale is given, but no {key} limit is known for robot {arm.name!r}; "
                    f"give limits.{key} too"
                )
            if scale != 1.0:
                value = value * scale
                sources[kind] = f"{sources.get(kind, 'the data of the robot')}; scaled to {100.0 * scale:.6g} %"
        values[key] = value
    if changes.max_torque is not None and not arm.inertias_known:
        reason = arm.inertia_fault or "nobody states them"
        raise ScenarioError(
            f"limits.torque is given, but the masses and inertias of robot {arm.name!r} are not known ({reason}), "
            "so torques cannot be computed; leave it out or give a URDF with real inertias"
        )
    _check(arm, values)
    changed: dict[str, Any] = {name: values[key] for name, key in _KEYS.items()}
    return JointLimits(**changed, sources=sources, not_known=tuple(not_known))


def unlimited(robot: Robot) -> tuple[str, ...]:
    """What of its joints has no limit because nobody states one: "acceleration", "jerk", "torque"."""
    of_joints = {"acceleration": robot.max_acceleration, "jerk": robot.max_jerk, "torque": robot.max_torque}
    return tuple(kind for kind, own in of_joints.items() if own is None and f"joint {kind}" in robot.not_known)


def position_and_speed_only(limits: JointLimits) -> JointLimits:
    """Return limits without those of acceleration, jerk and torque, as published for some experiments."""
    return replace(limits, max_acceleration=None, max_jerk=None, max_torque=None)


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
    inside, notes = within_limits(robot, home, "home")
    return replace(robot, home=inside, notes=(*robot.notes, *notes))


def within_limits(
    robot: Robot, q: Sequence[float] | np.ndarray, key: str, reason: Callable[[str], Reason] | None = None
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Joint positions as a controller reports them, within the limits: at one where they are a hair beyond.

    Args:
        robot: the arm.
        q: (n,) rad.
        key: what the positions are called in the scenario.
        reason: of a refusal, for programs, from the name of the joint.

    Returns:
        (n,) rad, read-only, and a sentence where a joint was moved to its limit.

    Raises:
        ScenarioError: a joint is farther than `MEASURED` outside its limits; the message starts with the key.
    """
    notes = []
    for name, value, lower, upper in zip(robot.joints, q, robot.lower, robot.upper, strict=True):
        beyond = max(float(lower - value), float(value - upper))
        if beyond > MEASURED:
            raise ScenarioError(
                f"{key} has {name} at {format_quantity(float(value), 'angle')}, outside its limits by "
                f"{format_quantity(beyond, 'angle', digits=3)}; it must be from "
                f"{format_quantity(float(lower), 'angle')} to {format_quantity(float(upper), 'angle')}",
                None if reason is None else reason(name),
            )
        if beyond > 0.0:
            notes.append(
                f"{key} has {name} {beyond:.2g} rad beyond its limit; up to {MEASURED:g} rad counts as measured, and "
                "it is taken at the limit"
            )
    return read_only(np.clip(np.array(q, dtype=float), robot.lower, robot.upper)), tuple(notes)


def _per_joint(given: float | tuple[float, ...], key: str, joints: Sequence[str]) -> np.ndarray:
    count = len(joints)
    if isinstance(given, tuple):
        if len(given) != count:
            raise ScenarioError(_count(f"limits.{key}", len(given), joints))
        return np.array(given)
    return np.full(count, given)


def _count(key: str, given: int, joints: Sequence[str]) -> str:
    values = "1 value" if given == 1 else f"{given} values"
    return f"{key} has {values} where {len(joints)} are needed, one for each of {', '.join(joints)}"


def _stated(joints: Sequence[str], reasons: Mapping[str, str]) -> str:
    """What a URDF states in the place of limits: each reason with its joints."""
    found: dict[str, list[str]] = {}
    for name in joints:
        found.setdefault(reasons.get(name, "none"), []).append(name)
    return ", and ".join(f"{reason} (joint {', '.join(own)})" for reason, own in found.items())


def _check(arm: LimitedArm, values: dict[str, np.ndarray | None]) -> None:
    joints = arm.joints
    for key in ("lower", "upper", "speed"):
        value = values[key]
        assert value is not None
        missing = [name for name, entry in zip(joints, value, strict=True) if np.isnan(entry)]
        if missing:
            raise ScenarioError(
                f"limits.{key} is missing: the URDF states {_stated(missing, arm.not_set.get(key, {}))}; "
                f'write it under [robot.limits], for example {key} = "{_EXAMPLES[key]}", or a list, one for each joint'
            )
    lower, upper = values["lower"], values["upper"]
    assert lower is not None and upper is not None
    for name, low, high in zip(joints, lower, upper, strict=True):
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
            raise ScenarioError(f"limits.{key} of {joints[joint]} is {shown}; it must be above 0")
