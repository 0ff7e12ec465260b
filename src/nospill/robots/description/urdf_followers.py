"""Joints that follow others (<mimic>), and joints that are locked: what moves with what, and what stands where."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from nospill.core.suggestions import nearest
from nospill.core.units import format_quantity, quantity
from nospill.errors import ScenarioError
from nospill.robots.description.urdf_limits import bounded
from nospill.robots.description.urdf_tree import Mimic, UrdfJoint, UrdfTree, about_axis, rotation_of, rpy_of

TURNING = ("revolute", "continuous")
_SHOWN = 12


@dataclass(frozen=True, slots=True)
class Followed:
    """A description in which joints on the way to the tip are free, follow a free one, or are fixed.

    Attributes:
        tree: the description; what follows another joint names the one that is free.
        moving: the free joints, base to tip.
        following: the joints on the way that follow one of them, base to tip.
        beside: joints that follow one of them and are not on the way: the arm is read with these at rest.
    """

    tree: UrdfTree
    moving: tuple[UrdfJoint, ...]
    following: tuple[UrdfJoint, ...]
    beside: tuple[str, ...]


def followed(tree: UrdfTree, tip: str, locked: Mapping[str, object]) -> Followed:
    """Lock joints, and resolve what follows what.

    A joint that follows one that stands still stands still too, where the law of its <mimic> puts it.

    Args:
        tree: the description.
        tip: the flange link.
        locked: joint -> value at which it stands, a quantity.

    Raises:
        ScenarioError: a locked joint is not in it or outside its limits, or moves with another one; a joint on the way
            to the tip follows one that slides, is not on the way, or is not there.
    """
    names = {joint.name: joint for joint in tree.joints}
    values = {name: _locked_value(names, name, value) for name, value in locked.items()}
    way = {joint.name for joint in tree.way_to(tip)}
    for name in values:
        if name in way and (law := _resolved(names, names[name])) is not None and law.joint not in values:
            raise ScenarioError(
                f"locked.{name}: joint {name!r} follows {law.joint!r} ({law.multiplier:g} times its angle), which "
                f"moves; leave {name} out of locked: it is carried along"
            )
    joints, beside = dict(names), []
    for name, joint in names.items():
        law = None if joint.kind == "fixed" else _resolved(names, joint, strict=name in way)
        if name in values:
            joints[name] = _standing(joint, values[name])
        elif law is not None:
            leader = names[law.joint]
            if law.multiplier == 0.0 or leader.kind == "fixed" or law.joint in values:
                joints[name] = _standing(joint, law.multiplier * values.get(law.joint, 0.0) + law.offset)
            elif name in way:
                _check_law(joint, leader, law, law.joint in way)
                joints[name] = replace(joint, mimic=law)
            elif law.joint in way:
                beside.append(name)
            else:
                joints[name] = _standing(joint, law.offset)
        elif joint.mimic is not None:
            joints[name] = replace(joint, mimic=None)
    tree = replace(tree, joints=tuple(joints[joint.name] for joint in tree.joints))
    on_way = [joint for joint in tree.way_to(tip) if joint.kind != "fixed"]
    return Followed(
        tree,
        tuple(joint for joint in on_way if joint.mimic is None),
        tuple(joint for joint in on_way if joint.mimic is not None),
        tuple(beside),
    )


def hint_of(name: str, known: Sequence[str]) -> str:
    """Return "; did you mean ...?" for the nearest known name, or an empty text."""
    near = nearest(name, known, likeness=0.5)
    return f"; did you mean {near!r}?" if near else ""


def some(names: Sequence[str]) -> str:
    """Return the first dozen names and how many more there are."""
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    return ", ".join(names[:_SHOWN]) + more


def _resolved(names: Mapping[str, UrdfJoint], joint: UrdfJoint, *, strict: bool = False) -> Mimic | None:
    """The law of a joint in terms of one that follows none; None where it follows none, or, not strictly, nothing sane.

    Raises:
        ScenarioError: strictly, the joint that it follows is not there, or it follows itself in the end.
    """
    if joint.mimic is None:
        return None
    factor, offset, seen, at = 1.0, 0.0, [joint.name], joint
    while at.mimic is not None:
        factor, offset = factor * at.mimic.multiplier, factor * at.mimic.offset + offset
        follows = at.mimic.joint
        if follows not in names or follows in seen:
            if not strict:
                return None
            reason = "which follows it in turn" if follows in seen else "which is not in the URDF"
            raise ScenarioError(
                f"joint {joint.name!r} on the way to the tip follows {follows!r} (<mimic>), {reason}"
                f"{'' if follows in seen else hint_of(follows, list(names))}; correct the URDF"
            )
        seen.append(follows)
        at = names[follows]
    return Mimic(at.name, factor, offset)


def _check_law(joint: UrdfJoint, leader: UrdfJoint, law: Mimic, on_way: bool) -> None:
    if joint.kind not in TURNING or leader.kind not in TURNING:
        slides = joint if joint.kind not in TURNING else leader
        raise ScenarioError(
            f"joint {joint.name!r} on the way to the tip follows {leader.name!r}, and {slides.name!r} is "
            f"{slides.kind}; only turning joints are planned for: lock {leader.name}, for example {lock_of(leader)}"
        )
    if not on_way:
        raise ScenarioError(
            f"joint {joint.name!r} on the way to the tip follows {leader.name!r}, which is not on the way; lock that "
            f"one where it stands, for example {lock_of(leader)}"
        )
    if not math.isfinite(1.0 / law.multiplier):
        raise ScenarioError(f"joint {joint.name!r} follows {leader.name!r} {law.multiplier:g} times; correct the URDF")


def lock_of(joint: UrdfJoint) -> str:
    """The key that locks a joint where it may stand, as advice writes it."""
    unit = "m" if joint.kind == "prismatic" else "deg"
    dimension = "length" if joint.kind == "prismatic" else "angle"
    return f'locked = {{ {joint.name} = "{format_quantity(_free_value(joint), dimension, unit=unit)}" }}'


def _free_value(joint: UrdfJoint) -> float:
    """Zero where that is within the limits of a joint, else their middle: rad, or m of a sliding one."""
    lower, upper = (joint.lower, joint.upper) if joint.kind == "prismatic" else bounded(joint)
    if math.isnan(lower) or math.isnan(upper) or not lower < upper or lower <= 0.0 <= upper:
        return 0.0
    return float(np.clip(0.0, lower, upper)) if not math.isfinite(upper - lower) else (lower + upper) / 2.0


def _locked_value(names: Mapping[str, UrdfJoint], name: str, value: object) -> float:
    """The value of a locked joint, rad or m, within its limits."""
    if name not in names or names[name].kind == "fixed":
        free = [joint.name for joint in names.values() if joint.kind != "fixed"]
        reason = "is fixed already" if name in names else "is not in the URDF"
        raise ScenarioError(f"locked joint {name!r} {reason} (moving joints: {some(free)}){hint_of(name, free)}")
    joint = names[name]
    if joint.kind in ("floating", "planar"):
        raise ScenarioError(f"locked joint {joint.name!r} is {joint.kind}; only turning and sliding ones can be locked")
    dimension = "length" if joint.kind == "prismatic" else "angle"
    try:
        at = quantity(value, dimension)
    except ScenarioError as error:
        raise ScenarioError(f"locked.{joint.name} {error}") from None
    if joint.kind != "continuous" and joint.lower < joint.upper and not joint.lower <= at <= joint.upper:
        bounds = [format_quantity(bound, dimension) for bound in (joint.lower, joint.upper)]
        raise ScenarioError(
            f"locked.{joint.name} {format_quantity(at, dimension)} is outside the joint's limits; "
            f"it must be from {bounds[0]} to {bounds[1]}"
        )
    return at


def _standing(joint: UrdfJoint, at: float) -> UrdfJoint:
    """The joint held at a value, rad or m: fixed, with its motion built into its origin."""
    if joint.kind == "prismatic":
        axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
        shift = np.array(joint.position) + rotation_of(joint.rpy) @ axis * at
        return replace(joint, kind="fixed", position=tuple(shift.tolist()), mimic=None)
    turn = rotation_of(joint.rpy) @ about_axis(joint.axis, at)
    return replace(joint, kind="fixed", rpy=rpy_of(turn) if at else joint.rpy, mimic=None)
