"""From any URDF text to the chain of an arm: base pose and locked joints built in, placeholder limits left out."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from nospill.core.arrays import read_only
from nospill.core.suggestions import nearest
from nospill.core.units import format_quantity, quantity
from nospill.errors import ScenarioError
from nospill.robots.description.urdf_tree import (
    UrdfJoint,
    UrdfTree,
    about_axis,
    read_tree,
    rotation_of,
    rpy_of,
    write_tree,
)
from nospill.robots.kinematics.bodies import inertia_fault

USUAL_TIPS = ("tool0", "flange")
"""Frames taken as the tip when none is named, the first that exists: names of the ROS-Industrial convention."""

MOVING_JOINTS = (6, 7)
"""How many joints an arm may move."""

PLACEHOLDER_SPEED = 10.0
"""rad/s; where every joint is written at least this fast, nobody has filled the field in."""

PLACEHOLDER_EFFORT = 1000.0
"""N m; likewise for torques that are all the same."""

TURN = 2.0 * math.pi
_SHOWN = 12


@dataclass(frozen=True, slots=True)
class BasePose:
    """Pose of the arm's root in the world: position (3,), m, and roll, pitch and yaw (3,), rad."""

    position: tuple[float, ...] = (0.0, 0.0, 0.0)
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)

    def moved(self) -> bool:
        """Whether it is another pose than the world's."""
        return any((*self.position, *self.rpy))


@dataclass(frozen=True, slots=True)
class UrdfArm:
    """An arm as its URDF describes it; (n,) arrays, NaN where a limit is not set.

    Attributes:
        name: the robot's name in the file.
        urdf: text without meshes; base pose and locked joints are built in, all else stands still.
        joints: moving joints, base to tip.
        tip: the flange link.
        lower: rad.
        upper: rad.
        max_speed: rad/s.
        max_torque: N m.
        inertia_fault: why the inertias cannot be real, or None.
        notes: what was assumed, one sentence each.
    """

    name: str
    urdf: str
    joints: tuple[str, ...]
    tip: str
    lower: np.ndarray
    upper: np.ndarray
    max_speed: np.ndarray
    max_torque: np.ndarray
    inertia_fault: str | None
    notes: tuple[str, ...]


_MOUNT = "world_to_base"
"""Joint that places a moved base in the world."""

NO_LOCKS: Mapping[str, object] = {}
WORLD = BasePose()


def read_arm(
    text: str, *, tip: str | None = None, base: BasePose = WORLD, locked: Mapping[str, object] = NO_LOCKS
) -> UrdfArm:
    """Read an arm of six or seven moving joints.

    Args:
        text: the text of a URDF file.
        tip: the flange link; when not given `tool0`, `flange` or the only link without a child.
        base: pose of the root in the world.
        locked: joint -> value at which it stands still, a quantity ("30 deg", rad; "0.2 m", m for a sliding joint).

    Raises:
        ScenarioError: the text is no URDF, the tip or a locked joint is not in it, or the joints on the way to the tip
            are not six or seven that turn.
    """
    tree = read_tree(text)
    notes = [f"the URDF names mesh files ({tree.meshes}); they are not used"] if tree.meshes else []
    tip, tip_note = _tip(tree, tip)
    notes += tip_note
    tree = _locked(tree, locked)
    way = tree.way_to(tip)
    moving = [joint for joint in way if joint.kind != "fixed"]
    _check_way(moving)
    notes += _still(tree, moving)
    tree = _arm_only(tree, way, moving)
    endless = [joint.name for joint in moving if joint.kind == "continuous"]
    if endless:
        notes.append(f"continuous joints may turn by +-360 deg: {', '.join(endless)}")
    tree, moving = _as_revolute(tree, moving)
    names = tuple(joint.name for joint in moving)
    _check_names(names)
    fault = inertia_fault(tree, names)
    return UrdfArm(
        name=tree.name,
        urdf=write_tree(_based(tree, base)),
        joints=names,
        tip=tip,
        lower=read_only([joint.lower for joint in moving]),
        upper=read_only([joint.upper for joint in moving]),
        max_speed=read_only(_speeds(moving)),
        max_torque=read_only(_torques(moving)),
        inertia_fault=fault,
        notes=tuple(notes),
    )


def standalone_urdf(text: str, *, name: str) -> str:
    """Return the description without meshes and whatever else is not used; reading it gives the same arm.

    Args:
        text: the text of a URDF file.
        name: the robot's name where the file gives none.

    Raises:
        ScenarioError: the text is no URDF.
    """
    tree = read_tree(text)
    return write_tree(replace(tree, name=name) if tree.name == "robot" else tree)


def hint_of(name: str, known: Sequence[str]) -> str:
    """Return "; did you mean ...?" for the nearest known name, or an empty text."""
    near = nearest(name, known, likeness=0.5)
    return f"; did you mean {near!r}?" if near else ""


def _check_names(names: Sequence[str]) -> None:
    """Refuse names of joints that no column of a file can have.

    Raises:
        ScenarioError: naming the joint.
    """
    for name in names:
        if name != name.strip() or any(letter in ',;"' or not letter.isprintable() for letter in name):
            raise ScenarioError(
                f"joint {name!r}: a name may not hold a comma, semicolon, quotation mark or control character, nor "
                "begin or end with a space, since names head the columns of files; rename the joint in the URDF"
            )


def some(names: Sequence[str]) -> str:
    """Return the first dozen names and how many more there are."""
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    return ", ".join(names[:_SHOWN]) + more


def _tip(tree: UrdfTree, tip: str | None) -> tuple[str, list[str]]:
    links = list(tree.links)
    if tip is not None:
        if tip not in tree.links:
            raise ScenarioError(f"tip {tip!r} is not in the URDF (frames: {some(links)}){hint_of(tip, links)}")
        return tip, []
    parents = {joint.parent for joint in tree.joints}
    ends = [link for link in links if link not in parents]
    usual = [link for link in USUAL_TIPS if link in tree.links]
    if not usual and len(ends) > 1:
        raise ScenarioError(f"tip is missing and the URDF has several ends ({some(ends)}); name the flange's frame")
    chosen = usual[0] if usual else ends[0]
    return chosen, [f"the tip is the frame {chosen!r}; the tray stands along its z axis"]


def _locked(tree: UrdfTree, locked: Mapping[str, object]) -> UrdfTree:
    joints = {joint.name: joint for joint in tree.joints}
    for name, value in locked.items():
        if name not in joints or joints[name].kind == "fixed":
            free = [joint.name for joint in tree.joints if joint.kind != "fixed"]
            reason = "is fixed already" if name in joints else "is not in the URDF"
            raise ScenarioError(f"locked joint {name!r} {reason} (moving joints: {some(free)}){hint_of(name, free)}")
        joints[name] = _standing(joints[name], value)
    return replace(tree, joints=tuple(joints[joint.name] for joint in tree.joints))


def _standing(joint: UrdfJoint, value: object) -> UrdfJoint:
    """The joint held at a value: fixed, with its motion built into its origin."""
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
    if joint.kind == "prismatic":
        axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
        shift = np.array(joint.position) + rotation_of(joint.rpy) @ axis * at
        return replace(joint, kind="fixed", position=tuple(shift.tolist()), mimic=False)
    turn = rotation_of(joint.rpy) @ about_axis(joint.axis, at)
    return replace(joint, kind="fixed", rpy=rpy_of(turn), mimic=False)


def _check_way(moving: Sequence[UrdfJoint]) -> None:
    for joint in moving:
        if joint.kind == "prismatic":
            raise ScenarioError(
                f"joint {joint.name!r} on the way to the tip slides (prismatic); only turning joints are planned for: "
                f'lock it, for example locked = {{ {joint.name} = "0 m" }}'
            )
        if joint.kind in ("floating", "planar"):
            raise ScenarioError(f"joint {joint.name!r} on the way to the tip is {joint.kind}; give a fixed arm")
        if joint.mimic:
            raise ScenarioError(
                f"joint {joint.name!r} on the way to the tip mimics another joint; joints are planned one by one: "
                f'lock it, for example locked = {{ {joint.name} = "0 deg" }}'
            )
    if len(moving) not in MOVING_JOINTS:
        names = some([joint.name for joint in moving]) or "none"
        advice = "lock some of them" if len(moving) > MOVING_JOINTS[-1] else "choose another tip"
        raise ScenarioError(
            f"{len(moving)} joints move between the root and the tip ({names}), 6 or 7 are planned for; {advice}"
        )


def _still(tree: UrdfTree, moving: Sequence[UrdfJoint]) -> list[str]:
    names = {joint.name for joint in moving}
    still = [joint.name for joint in tree.joints if joint.kind != "fixed" and joint.name not in names]
    return [f"joints that do not move the tip stand at zero: {some(still)}"] if still else []


def _arm_only(tree: UrdfTree, way: Sequence[UrdfJoint], moving: Sequence[UrdfJoint]) -> UrdfTree:
    """The chain and all that its moving joints carry; other joints are fixed where they are at zero."""
    names = {joint.name for joint in moving}
    children = tree.joints_on()
    links, waiting = {way[0].parent, *(joint.child for joint in way)}, [moving[0].child]
    while waiting:
        link = waiting.pop()
        links.add(link)
        waiting += [joint.child for joint in children.get(link, [])]
    joints = tuple(
        joint if joint.name in names else replace(joint, kind="fixed", mimic=False)
        for joint in tree.joints
        if joint.child in links and joint.parent in links
    )
    return UrdfTree(tree.name, {link: own for link, own in tree.links.items() if link in links}, joints)


def _as_revolute(tree: UrdfTree, moving: Sequence[UrdfJoint]) -> tuple[UrdfTree, list[UrdfJoint]]:
    """Continuous joints with limits of a turn; position limits that nobody has filled in as not set."""
    changed: dict[str, UrdfJoint] = {}
    for joint in moving:
        lower, upper = joint.lower, joint.upper
        if joint.kind == "continuous":
            lower, upper = -TURN, TURN
        elif lower == upper == 0.0 or math.isnan(lower) or math.isnan(upper):
            lower = upper = math.nan
        changed[joint.name] = replace(joint, kind="revolute", lower=lower, upper=upper)
    return (
        replace(tree, joints=tuple(changed.get(joint.name, joint) for joint in tree.joints)),
        [changed[joint.name] for joint in moving],
    )


def _speeds(moving: Sequence[UrdfJoint]) -> list[float]:
    speeds = [joint.max_speed for joint in moving]
    for joint in moving:
        if joint.max_speed < 0.0:
            raise ScenarioError(
                f"the URDF gives joint {joint.name!r} a negative speed, "
                f"{format_quantity(joint.max_speed, 'angular_speed')}; a speed limit is above 0"
            )
    if all(speed >= PLACEHOLDER_SPEED for speed in speeds):
        return [math.nan] * len(speeds)
    return [speed if speed > 0.0 else math.nan for speed in speeds]


def _torques(moving: Sequence[UrdfJoint]) -> list[float]:
    torques = [joint.max_torque for joint in moving]
    same = len(set(torques)) == 1 and torques[0] >= PLACEHOLDER_EFFORT
    return [effort if effort > 0.0 and effort != PLACEHOLDER_EFFORT and not same else math.nan for effort in torques]


def _based(tree: UrdfTree, base: BasePose) -> UrdfTree:
    """The description in the world, with the limits that its readers expect to be written."""
    joints = tuple(
        replace(
            joint,
            lower=0.0 if math.isnan(joint.lower) else joint.lower,
            upper=0.0 if math.isnan(joint.upper) else joint.upper,
            max_speed=0.0 if math.isnan(joint.max_speed) else joint.max_speed,
            max_torque=0.0 if math.isnan(joint.max_torque) else joint.max_torque,
        )
        if joint.kind == "revolute"
        else replace(joint, lower=math.nan, upper=math.nan, max_speed=math.nan, max_torque=math.nan)
        for joint in tree.joints
    )
    if not base.moved():
        return replace(tree, joints=joints)
    world, mount = _free("world", tree.links), _free(_MOUNT, [joint.name for joint in joints])
    placed = UrdfJoint(mount, "fixed", world, tree.root(), position=base.position, rpy=base.rpy)
    return UrdfTree(tree.name, {world: None, **tree.links}, (placed, *joints))


@lru_cache(maxsize=32)
def base_pose(urdf: str) -> tuple[np.ndarray, np.ndarray]:
    """Position (3,), m, and rotation (3, 3) of an arm's base in the world of path and gravity.

    Args:
        urdf: text as `read_arm` returns it; the world's own pose where its base was not moved.

    Returns:
        Read-only, since both are kept.
    """
    tree = read_tree(urdf)
    mount = next((joint for joint in tree.joints if _is_mount(tree, joint)), None)
    if mount is None:
        return read_only(np.zeros(3)), read_only(np.eye(3))
    return read_only(mount.position), read_only(rotation_of(mount.rpy))


@lru_cache(maxsize=32)
def without_place(urdf: str) -> tuple[str, np.ndarray]:
    """An arm whose base stands in the origin with yaw 0, and where it does stand.

    Gravity and the equations of the arm are the same there: arms that differ in the place differ in numbers alone.

    Args:
        urdf: text as `read_arm` returns it.

    Returns:
        Text, the same for all places; (4,) x, y, z in m and yaw in rad of the base in the world of path and gravity,
        read-only.
    """
    tree = read_tree(urdf)
    mount = next((joint for joint in tree.joints if _is_mount(tree, joint)), None)
    if mount is None:
        return write_tree(tree), read_only(np.zeros(4))
    roll, pitch, yaw = mount.rpy
    others = tuple(joint for joint in tree.joints if joint is not mount)
    if roll == pitch == 0.0:
        links = {name: own for name, own in tree.links.items() if name != mount.parent}
        stood = UrdfTree(tree.name, links, others)
    else:
        stood = replace(tree, joints=(replace(mount, position=(0.0, 0.0, 0.0), rpy=(roll, pitch, 0.0)), *others))
    return write_tree(stood), read_only((*mount.position, yaw))


def _is_mount(tree: UrdfTree, joint: UrdfJoint) -> bool:
    return joint.parent == tree.root() and joint.name.startswith(_MOUNT)


def _free(name: str, taken: Mapping[str, object] | Sequence[str]) -> str:
    while name in taken:
        name += "_"
    return name
