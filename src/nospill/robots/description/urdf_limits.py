"""Joint limits of a URDF by evidence: what is stated and binds, what is a placeholder, what is hardly meant in SI.

Exporters fill fields that nobody knows with zero, infinity, 1e19, 9999 or the same round number on every joint. Numbers
beyond what joints do are taken for another unit. Neither binds; the reason is kept, joint by joint, and said where the
limit is missed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from nospill.core.arrays import read_only
from nospill.core.units import format_quantity
from nospill.errors import ScenarioError
from nospill.robots.description.urdf_tree import UrdfJoint
from nospill.robots.robot import Doubt

TURN = 2.0 * math.pi

PLACEHOLDER_SPEED = 10.0
"""rad/s; where every joint is written the same and at least this fast, nobody has filled the field in."""

PLACEHOLDER_EFFORT = 1000.0
"""N m; likewise for torques that are all the same."""

_NO_ANGLE, _NO_SPEED, _NO_EFFORT = 1000.0, 1000.0, 1e5
"""rad, rad/s, N m: from here on a number stands for "no limit"."""
_WIDEST, _WIDE = 50.0, 4.0 * math.pi
"""rad: the last joint of a Smart SiX turns by 47 rad, no other one of the catalogue as far; few turn more than the
second."""
_FASTEST, _FAST = 50.0, 20.0
"""rad/s: no joint of an arm is faster; few are."""

Reasons = Mapping[str, str]
"""Joint -> why a limit of it is not set, as the end of "the URDF states ..."."""


@dataclass(frozen=True, slots=True)
class UrdfLimits:
    """Joint limits as read; (n,) arrays, NaN where a limit is not set.

    Attributes:
        lower: rad.
        upper: rad.
        max_speed: rad/s.
        max_torque: N m.
        max_acceleration: rad/s^2, or None where not every joint states one.
        max_jerk: rad/s^3, likewise.
        not_set: key of `[robot.limits]` -> reasons.
        notes: what was read beside `<limit>`, one sentence each.
        doubts: what is taken and hardly usual.
    """

    lower: np.ndarray
    upper: np.ndarray
    max_speed: np.ndarray
    max_torque: np.ndarray
    max_acceleration: np.ndarray | None
    max_jerk: np.ndarray | None
    not_set: Mapping[str, Reasons]
    notes: tuple[str, ...]
    doubts: tuple[Doubt, ...]


def stated_limits(joints: Sequence[UrdfJoint], followers: Sequence[UrdfJoint] = ()) -> UrdfLimits:
    """Read the limits of moving joints, those of what follows them with them.

    Args:
        joints: base to tip.
        followers: joints that follow one of them; their limits bind the joint that turns them.

    Raises:
        ScenarioError: a speed is negative, or a joint's limits and those of what follows it leave it no range.
    """
    every = (*joints, *followers)
    positions = {joint.name: _position(joint) for joint in every}
    speeds, efforts = _speeds(every), _efforts(every)
    lower, upper, rate = (
        {joint.name: table[joint.name] for joint in joints}
        for table in (
            {name: own[0] for name, own in positions.items()},
            {name: own[1] for name, own in positions.items()},
            {name: own[0] for name, own in speeds.items()},
        )
    )
    notes = _notes(every, followers)
    for joint in followers:
        assert joint.mimic is not None
        leader, factor, offset = joint.mimic.joint, joint.mimic.multiplier, joint.mimic.offset
        low, high, _ = positions[joint.name]
        ends = sorted(((low - offset) / factor, (high - offset) / factor))
        lower[leader], upper[leader] = _narrower(lower[leader], upper[leader], ends[0], ends[1])
        rate[leader] = float(np.fmin(rate[leader], speeds[joint.name][0] / abs(factor)))
        if lower[leader] >= upper[leader]:
            raise ScenarioError(
                f"the limits of joint {joint.name!r}, which follows {leader!r} ({_law(joint)}), leave that no range: "
                f"from {format_quantity(lower[leader], 'angle')} to {format_quantity(upper[leader], 'angle')}; correct "
                "the <limit> or the <mimic> in the URDF"
            )
    reasons = {
        key: {name: own[-1] for name, own in table.items() if own[-1] and name in lower and math.isnan(value[name])}
        for key, table, value in (
            ("lower", positions, lower),
            ("upper", positions, upper),
            ("speed", speeds, rate),
            ("torque", efforts, {name: own[0] for name, own in efforts.items()}),
        )
    }
    names = [joint.name for joint in joints]
    accelerations, more = _all_or_none(every, followers, "max_acceleration", "acceleration")
    jerks, further = _all_or_none(every, followers, "max_jerk", "jerk")
    return UrdfLimits(
        lower=read_only([lower[name] for name in names]),
        upper=read_only([upper[name] for name in names]),
        max_speed=read_only([rate[name] for name in names]),
        max_torque=read_only([efforts[name][0] for name in names]),
        max_acceleration=accelerations,
        max_jerk=jerks,
        not_set=reasons,
        notes=(*notes, *more, *further),
        doubts=(
            *_wide({name: max(-lower[name], upper[name]) for name in names}),
            *_fast({name: rate[name] for name in names}),
        ),
    )


def bounded(joint: UrdfJoint) -> tuple[float, float]:
    """Lower and upper limit of a joint, rad, its soft limits included; NaN where none is set."""
    return _position(joint)[:2]


def _position(joint: UrdfJoint) -> tuple[float, float, str]:
    """Lower and upper limit, rad, and why they are not set."""
    if joint.kind == "continuous":
        lower, upper, reason = -TURN, TURN, ""
    else:
        lower, upper = joint.lower, joint.upper
        reason = _position_reason(lower, upper)
    if reason:
        lower = upper = math.nan
    soft = _soft(joint)
    if soft is not None:
        lower, upper = _narrower(lower, upper, *soft)
        if not math.isnan(lower) and not math.isnan(upper):
            reason = ""
        if lower >= upper:
            low, high = (format_quantity(value, "angle") for value in soft)
            raise ScenarioError(
                f"the soft limits of joint {joint.name!r}, from {low} to {high}, leave it no range within its own; "
                "correct its <safety_controller> in the URDF"
            )
    return lower, upper, reason


def _position_reason(lower: float, upper: float) -> str:
    if math.isnan(lower) or math.isnan(upper) or lower == upper == 0.0:
        return "none"
    largest = max(abs(lower), abs(upper))
    shown = f"{lower:.6g} to {upper:.6g} rad"
    if largest >= _NO_ANGLE or _nines(largest):
        return f"{shown}, which stands for no limit"
    if largest > _WIDEST:
        return f"{shown}, which is hardly meant in rad ({largest / TURN:.3g} turns; {largest:.4g} deg would be usual)"
    return ""


def _soft(joint: UrdfJoint) -> tuple[float, float] | None:
    """Soft limits, rad, where any are written; one that is not written is zero by the format."""
    if joint.safety is None:
        return None
    lower, upper = (0.0 if math.isnan(value) else value for value in (joint.safety.lower, joint.safety.upper))
    if lower == upper == 0.0 or max(abs(lower), abs(upper)) >= _NO_ANGLE:
        return None
    return lower, upper


def _narrower(lower: float, upper: float, other_lower: float, other_upper: float) -> tuple[float, float]:
    return float(np.fmax(lower, other_lower)), float(np.fmin(upper, other_upper))


def _speeds(joints: Sequence[UrdfJoint]) -> dict[str, tuple[float, str]]:
    """Joint -> speed limit, rad/s, and why it is not set."""
    for joint in joints:
        if joint.max_speed < 0.0:
            raise ScenarioError(
                f"the URDF gives joint {joint.name!r} a negative speed, "
                f"{format_quantity(joint.max_speed, 'angular_speed')}; a speed limit is above 0"
            )
    stated = {joint.max_speed for joint in joints}
    same = len(stated) == 1 and next(iter(stated)) >= PLACEHOLDER_SPEED
    found = {}
    for joint in joints:
        speed, reason = joint.max_speed, ""
        if not speed > 0.0:
            reason = "none" if math.isnan(speed) else "0 rad/s, which stands for none"
        elif speed >= _NO_SPEED or _nines(speed):
            reason = f"{speed:.6g} rad/s, which stands for no limit"
        elif same:
            reason = f"{speed:.6g} rad/s for every joint, which nobody has filled in"
        elif speed > _FASTEST:
            reason = f"{speed:.6g} rad/s, which is hardly meant in rad/s ({speed:.6g} deg/s would be usual)"
        found[joint.name] = (math.nan if reason else speed, reason)
    return found


def _efforts(joints: Sequence[UrdfJoint]) -> dict[str, tuple[float, str]]:
    """Joint -> torque limit, N m, and why it is not set."""
    stated = {joint.max_torque for joint in joints}
    same = len(stated) == 1 and next(iter(stated)) >= PLACEHOLDER_EFFORT
    found = {}
    for joint in joints:
        effort, reason = joint.max_torque, ""
        if not effort > 0.0:
            reason = "no effort" if math.isnan(effort) else f"an effort of {effort:.6g}, which stands for none"
        elif effort >= _NO_EFFORT or effort == PLACEHOLDER_EFFORT or _nines(effort):
            reason = f"an effort of {effort:.6g} N m, which stands for no limit"
        elif same:
            reason = f"an effort of {effort:.6g} N m for every joint, which nobody has filled in"
        found[joint.name] = (math.nan if reason else effort, reason)
    return found


def _nines(value: float) -> bool:
    """Whether it is written with three nines or more and nothing else: 999, 9999, 999.9."""
    digits = f"{value:.6g}".replace(".", "")
    return value > 99.0 and len(digits) >= 3 and set(digits) == {"9"}


def _all_or_none(
    joints: Sequence[UrdfJoint], followers: Sequence[UrdfJoint], attribute: str, key: str
) -> tuple[np.ndarray | None, list[str]]:
    """A limit that newer files state beside speed and effort: of all joints, or none with a note."""
    values = {joint.name: float(getattr(joint, attribute)) for joint in joints}
    stated = [name for name, value in values.items() if math.isfinite(value) and value > 0.0]
    if not stated:
        return None, []
    own = {name: values[name] for name in values if name not in {joint.name for joint in followers}}
    if not set(own) <= set(stated):
        missing = ", ".join(name for name in own if name not in stated)
        return None, [
            f"the URDF states limits of joint {key} for {', '.join(stated)} and none for {missing}; they do not bind, "
            f"limits.{key} under [robot] states them for all"
        ]
    for joint in followers:
        if joint.mimic is not None and joint.name in stated:
            leader = joint.mimic.joint
            own[leader] = min(own[leader], values[joint.name] / abs(joint.mimic.multiplier))
    return read_only(list(own.values())), []


def _notes(every: Sequence[UrdfJoint], followers: Sequence[UrdfJoint]) -> list[str]:
    notes = []
    endless = [joint.name for joint in every if joint.kind == "continuous"]
    if endless:
        notes.append(f"continuous joints may turn by +-360 deg: {', '.join(endless)}")
    soft = [(joint.name, own) for joint in every if (own := _soft(joint)) is not None]
    if soft:
        rows = [f"{name} {' to '.join(format_quantity(end, 'angle') for end in own)}" for name, own in soft]
        notes.append(f"soft limits of the URDF bind: {', '.join(rows)}")
    gains = [
        joint.name
        for joint in every
        if joint.safety is not None
        and any(gain > 0.0 for gain in (joint.safety.position_gain, joint.safety.speed_gain))
    ]
    if gains:
        notes.append(
            f"the gains k_position and k_velocity of safety controllers are not judged ({', '.join(gains)}): near a "
            "soft limit they may slow a joint down"
        )
    if followers:
        rows = [f"{joint.name} follows {joint.mimic.joint} ({_law(joint)})" for joint in followers if joint.mimic]
        notes.append(f"{', '.join(rows)}; limits of position and speed bind both, efforts that of the joint followed")
    calibrated = [joint.name for joint in every if joint.calibrated]
    if calibrated:
        notes.append(f"reference positions (<calibration>) are not read: {', '.join(calibrated)}")
    rubbing = [joint.name for joint in every if joint.has_friction]
    if rubbing:
        notes.append(f"friction and damping of joints (<dynamics>) are not in their torques: {', '.join(rubbing)}")
    return notes


def _law(joint: UrdfJoint) -> str:
    assert joint.mimic is not None
    offset = "" if joint.mimic.offset == 0.0 else f" and {format_quantity(joint.mimic.offset, 'angle')}"
    return f"{joint.mimic.multiplier:g} times its angle{offset}"


def _wide(ends: Mapping[str, float]) -> list[Doubt]:
    return _beyond(
        ends,
        _WIDE + 1e-3,
        "joint position",
        "limits of up to {:.6g} rad, several turns; they are taken as they stand. Where they are meant in deg, give "
        "limits.lower and limits.upper under [robot].",
    )


def _fast(rates: Mapping[str, float]) -> list[Doubt]:
    return _beyond(
        rates,
        _FAST,
        "joint speed",
        "up to {:.4g} rad/s, more than most arms do; it is taken as it stands. Where it is meant in deg/s, or is no "
        "limit of the joint, give limits.speed under [robot].",
    )


def _beyond(values: Mapping[str, float], usual: float, what: str, words: str) -> list[Doubt]:
    names = [name for name, value in values.items() if value > usual]
    greatest = max((values[name] for name in names), default=usual)
    return [Doubt(what, ", ".join(names), f"the URDF states {words.format(greatest)}")] if names else []


def as_revolute(joint: UrdfJoint, lower: float, upper: float) -> UrdfJoint:
    """A turning joint with the limits that were read, as the chain is written."""
    return replace(joint, kind="revolute", lower=lower, upper=upper)
