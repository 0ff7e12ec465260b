"""From any URDF text to the chain of an arm: base pose, locked joints and a turned tip built in, limits by evidence."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from nospill.core.arrays import read_only
from nospill.errors import ScenarioError
from nospill.robots.description.urdf_followers import Followed, followed, lock_of, some
from nospill.robots.description.urdf_limits import Reasons, UrdfLimits, as_revolute, stated_limits
from nospill.robots.description.urdf_text import write_tree
from nospill.robots.description.urdf_tip import tip_doubt, tip_of, turned_tip
from nospill.robots.description.urdf_tree import UrdfJoint, UrdfTree, read_tree, rotation_of
from nospill.robots.description.urdf_units import arm_length, require_si
from nospill.robots.kinematics.inertias import InertiaFaults, inertia_faults
from nospill.robots.robot import Doubt

MOVING_JOINTS = (6, 7)
"""How many joints an arm may move."""

NO_TURN = (0.0, 0.0, 0.0)


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
        max_acceleration: rad/s^2, or None where the file states none for every joint.
        max_jerk: rad/s^3, likewise.
        not_set: key of `[robot.limits]` -> joint -> why it is not set.
        inertia_fault: why masses and inertias cannot be real, or None.
        torque_known: (n,) whether the torque of a joint needs nothing that is in doubt.
        notes: what was assumed, one sentence each.
        doubts: what is hardly meant, or stated and not applied.
    """

    name: str
    urdf: str
    joints: tuple[str, ...]
    tip: str
    lower: np.ndarray
    upper: np.ndarray
    max_speed: np.ndarray
    max_torque: np.ndarray
    max_acceleration: np.ndarray | None
    max_jerk: np.ndarray | None
    not_set: Mapping[str, Reasons]
    inertia_fault: str | None
    torque_known: np.ndarray
    notes: tuple[str, ...]
    doubts: tuple[Doubt, ...]


_MOUNT = "world_to_base"
"""Joint that places a moved base in the world."""

NO_LOCKS: Mapping[str, object] = {}
WORLD = BasePose()


def read_arm(
    text: str,
    *,
    tip: str | None = None,
    tip_rpy: Sequence[float] = NO_TURN,
    base: BasePose = WORLD,
    locked: Mapping[str, object] = NO_LOCKS,
) -> UrdfArm:
    """Read an arm of six or seven moving joints; joints that follow one of them are carried along.

    Args:
        text: the text of a URDF file.
        tip: the flange link; when not given `tool0`, `flange` or the only link without a child.
        tip_rpy: roll, pitch and yaw of the flange against that link, about the link's x, y and z in this order, rad.
        base: pose of the root in the world.
        locked: joint -> value at which it stands still, a quantity ("30 deg", rad; "0.2 m", m for a sliding joint).

    Raises:
        ScenarioError: the text is no URDF, the tip or a locked joint is not in it, its lengths or angles are hardly in
            m and rad, or the joints on the way to the tip are not six or seven that turn and others that follow them.
    """
    tree = read_tree(text)
    notes = [f"the URDF names mesh files ({tree.meshes}); they are not used"] if tree.meshes else []
    link, tip_note = tip_of(tree, tip)
    notes += tip_note
    require_si(tree.way_to(link))
    doubt = tip_doubt(tree, link, tuple(tip_rpy))
    arm = followed(tree, link, locked)
    _check_way(arm, link, locked)
    limits = stated_limits(arm.moving, arm.following)
    names = tuple(joint.name for joint in arm.moving)
    notes += [*_still(arm), *limits.notes, *_beside(tree, arm)]
    _check_names(names)
    chain, frame = turned_tip(_arm_only(arm, link), link, tuple(tip_rpy))
    chain = _with_limits(chain, arm, limits)
    faults = _faults(arm, chain, frame, names)
    return UrdfArm(
        name=tree.name,
        urdf=write_tree(_based(chain, base)),
        joints=names,
        tip=frame,
        lower=limits.lower,
        upper=limits.upper,
        max_speed=limits.max_speed,
        max_torque=limits.max_torque,
        max_acceleration=limits.max_acceleration,
        max_jerk=limits.max_jerk,
        not_set=limits.not_set,
        inertia_fault=faults.reason,
        torque_known=np.array(faults.known),
        notes=tuple(notes),
        doubts=(*([doubt] if doubt else []), *limits.doubts),
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


def _check_way(arm: Followed, tip: str, locked: Mapping[str, object]) -> None:
    for joint in arm.moving:
        if joint.kind == "prismatic":
            raise ScenarioError(
                f"joint {joint.name!r} on the way to the tip slides (prismatic); only turning joints are planned for: "
                f"lock it, for example {lock_of(joint)}"
            )
        if joint.kind in ("floating", "planar"):
            raise ScenarioError(f"joint {joint.name!r} on the way to the tip is {joint.kind}; give a fixed arm")
    count = len(arm.moving)
    if count in MOVING_JOINTS:
        return
    names = some([joint.name for joint in arm.moving]) or "none"
    if count > MOVING_JOINTS[-1]:
        advice = f"lock some of them, for example {lock_of(arm.moving[0])}"
    else:
        on_way = [name for name in locked if name in {joint.name for joint in arm.tree.way_to(tip)}]
        behind = _behind(arm, tip)
        advice = (
            f"lock fewer joints ({some(on_way)})"
            if on_way
            else f"the tip is in the middle of a longer chain: choose one at its end, for example tip = {behind!r}"
            if behind
            else f"arms of {count} joints are not planned for: they cannot hold a tray level along a path"
        )
    raise ScenarioError(f"{count} joints move between the root and the tip ({names}), 6 or 7 are planned for; {advice}")


def _behind(arm: Followed, tip: str) -> str | None:
    """A frame behind the tip at the end of a chain of six or seven turning joints."""
    parents = {joint.parent for joint in arm.tree.joints}
    for link in arm.tree.links:
        way = arm.tree.way_to(link)
        free = [joint for joint in way if joint.kind != "fixed" and joint.mimic is None]
        turning = all(joint.kind in ("revolute", "continuous") for joint in free)
        if link not in parents and len(free) in MOVING_JOINTS and turning and tip in {joint.parent for joint in way}:
            return link
    return None


def _still(arm: Followed) -> list[str]:
    names = {joint.name for joint in (*arm.moving, *arm.following)}
    still = [joint.name for joint in arm.tree.joints if joint.kind != "fixed" and joint.name not in names]
    return [f"joints that do not move the tip stand at zero: {some(still)}"] if still else []


def _beside(tree: UrdfTree, arm: Followed) -> list[str]:
    """What else the file states about the joints and does not bind."""
    names = {joint.name for joint in (*arm.moving, *arm.following)}
    geared, narrowed = (some([name for name in own if name in names]) for own in (tree.geared, tree.narrowed))
    notes = []
    if geared:
        notes.append(f"reductions of transmissions are not read, limits count at the joint: {geared}")
    if narrowed:
        notes.append(
            f"least and greatest values of ros2_control interfaces are not read ({narrowed}); where they bind, write "
            "them under [robot.limits]"
        )
    return notes


def _arm_only(arm: Followed, tip: str) -> UrdfTree:
    """The chain and all that its moving joints carry; other joints are fixed where they are at zero."""
    tree, way = arm.tree, arm.tree.way_to(tip)
    names = {joint.name for joint in (*arm.moving, *arm.following)}
    children = tree.joints_on()
    first = next(joint for joint in way if joint.name in names)
    links, waiting = {way[0].parent, *(joint.child for joint in way)}, [first.child]
    while waiting:
        link = waiting.pop()
        links.add(link)
        waiting += [joint.child for joint in children.get(link, [])]
    joints = tuple(
        joint if joint.name in names else replace(joint, kind="fixed", mimic=None)
        for joint in tree.joints
        if joint.child in links and joint.parent in links
    )
    return UrdfTree(tree.name, {link: own for link, own in tree.links.items() if link in links}, joints)


def _faults(arm: Followed, chain: UrdfTree, tip: str, names: Sequence[str]) -> InertiaFaults:
    """What speaks against the masses, those of links beside the way that move with a joint among them."""
    faults = inertia_faults(chain, names, length=arm_length(chain, tip))
    heavy = [
        joint.name
        for joint in arm.tree.joints
        if joint.name in arm.beside and (own := arm.tree.links[joint.child]) is not None and own.mass > 0.0
    ]
    if not heavy:
        return faults
    reason = f"what {some(heavy)} carry moves with the arm beside the way to the tip, and is taken at rest"
    return InertiaFaults((False,) * len(names), "; ".join(filter(None, (faults.reason, reason))))


def _with_limits(tree: UrdfTree, arm: Followed, limits: UrdfLimits) -> UrdfTree:
    """Moving joints as revolute ones with the limits that were read, and nothing beside that."""
    ends = dict(zip((joint.name for joint in arm.moving), zip(limits.lower, limits.upper, strict=True), strict=True))
    ends |= {joint.name: (math.nan, math.nan) for joint in arm.following}
    changed = {
        joint.name: as_revolute(joint, *map(float, ends[joint.name])) for joint in tree.joints if joint.name in ends
    }
    return replace(tree, joints=tuple(changed.get(joint.name, joint) for joint in tree.joints))


_UNUSED: dict[str, Any] = {
    "max_acceleration": math.nan,
    "max_jerk": math.nan,
    "safety": None,
    "calibrated": False,
    "has_friction": False,
}
"""What a chain is written without, once its limits are read."""


def _based(tree: UrdfTree, base: BasePose) -> UrdfTree:
    """The description in the world, with the limits that its readers expect to be written."""
    joints = tuple(
        replace(
            joint,
            lower=0.0 if math.isnan(joint.lower) else joint.lower,
            upper=0.0 if math.isnan(joint.upper) else joint.upper,
            max_speed=0.0 if math.isnan(joint.max_speed) else joint.max_speed,
            max_torque=0.0 if math.isnan(joint.max_torque) else joint.max_torque,
            **_UNUSED,
        )
        if joint.kind == "revolute"
        else replace(joint, lower=math.nan, upper=math.nan, max_speed=math.nan, max_torque=math.nan, **_UNUSED)
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
