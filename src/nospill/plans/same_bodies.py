"""Arm, base, tray and objects of one name, which a motion shares with the one that it goes on from."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from nospill.core.attitudes import angles_between
from nospill.core.units import as_written, format_quantity
from nospill.errors import ScenarioError
from nospill.robots.description.urdf import base_pose, without_place
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.robot import Robot
from nospill.scene.cargo import Cargo, Filling
from nospill.scene.scene import Scene

_SAME = 1e-6
"""m and rad, and of every other number the part: what is nearer is the same."""
_LOOKS = np.array([[0.0], [0.7], [-1.1]])
"""rad; angles of all joints in which two arms are compared."""


def require_same_bodies(scene: Scene, before: Scene) -> None:
    """Refuse a motion that goes on from another one with another arm, tray or object under the same name.

    Limits of the joints, masses and friction may be others. Objects that one of the two does not have are not compared.

    Args:
        scene: of the motion.
        before: of the one before it.

    Raises:
        ScenarioError: with the key and both values.
    """
    _require_same_arm(scene, before)
    _require_same_tray(scene, before)
    known = {cargo.name: cargo for cargo in before.cargo}
    for cargo in scene.cargo:
        if cargo.name in known:
            _require_same_object(cargo, known[cargo.name], before.name)


def _require_same_arm(scene: Scene, before: Scene) -> None:
    ours, theirs = scene.robot, before.robot
    if ours.joints != theirs.joints:
        raise _another("robot", " ".join(ours.joints), " ".join(theirs.joints), before.name, "use the same arm")
    if not _move_alike(ours, theirs):
        raise _another("robot", ours.name, theirs.name, before.name, "its flange is elsewhere in the same joints")
    if _robot_key(scene, "base_yaw") == "free":
        now = as_written(_robot_key(before, "base_yaw") or 0.0)
        raise ScenarioError(
            f"robot.base_yaw is free, and the arm stands where {before.name} had it: state base_yaw = {now}"
        )
    (place, turn), (was, turned) = base_pose(ours.urdf), base_pose(theirs.urdf)
    if np.abs(place - was).max() > _SAME:
        raise _another("robot.base_position", _mm(place), _mm(was), before.name, "the base does not move")
    if angles_between(turn[None], turned[None])[0] > _SAME:
        keys = ("base_yaw", "base_pitch", "base_roll")
        our_base, other = (
            ", ".join(f"{key} = {as_written(_robot_key(of, key) or 0.0)}" for key in keys) for of in (scene, before)
        )
        raise _another("robot", our_base, other, before.name, "the base does not move")


def _robot_key(scene: Scene, key: str) -> object:
    return scene.source["robot"].get(key)


def _move_alike(first: Robot, second: Robot) -> bool:
    """Whether two arms with the same joints have their flange at the same place in them, from their bases."""
    if without_place(first.urdf)[0] == without_place(second.urdf)[0] and first.tip == second.tip:
        return True
    q = np.tile(_LOOKS, len(first.joints))
    poses = []
    for robot in (first, second):
        origin, turn = base_pose(robot.urdf)
        positions, rotations = kinematics(robot).poses(q)
        poses.append(((positions - origin) @ turn, turn.T @ rotations))
    (here, our_axes), (there, theirs) = poses
    return bool(np.abs(here - there).max() < _SAME and angles_between(our_axes, theirs).max() < _SAME)


def _require_same_tray(scene: Scene, before: Scene) -> None:
    ours, theirs, cure = scene.tray, before.tray, "the flange carries the same tray"
    for key, own, other in (
        ("tray.size", ours.size, theirs.size),
        ("tray.offset", ours.tool.position, theirs.tool.position),
    ):
        if np.abs(np.asarray(own) - np.asarray(other)).max() > _SAME:
            raise _another(key, _mm(own), _mm(other), before.name, cure)
    if angles_between(ours.tool.rotation[None], theirs.tool.rotation[None])[0] > _SAME:
        if ours.tool.upright and theirs.tool.upright:
            raise _another("tray.yaw_on_flange", _deg(ours.tool.yaw), _deg(theirs.tool.yaw), before.name, cure)
        here, there = (", ".join(map(_deg, (tool.roll, tool.pitch, tool.yaw))) for tool in (ours.tool, theirs.tool))
        raise _another("tray.rotation", here, there, before.name, cure)


def _require_same_object(cargo: Cargo, before: Cargo, name: str) -> None:
    key, cure = f"cargo.{cargo.name}", "give what was changed or moved in between another name"
    if np.abs(cargo.place - before.place).max() > _SAME:
        raise _another(f"{key}.at", _mm(cargo.place), _mm(before.place), name, cure)
    if abs(cargo.yaw - before.yaw) > _SAME:
        raise _another(f"{key}.yaw", _deg(cargo.yaw), _deg(before.yaw), name, cure)
    if cargo.container != before.container:
        raise _another(f"{key}.shape", _shape(cargo), _shape(before), name, cure)
    ours, theirs = cargo.filling, before.filling
    if (ours is None) != (theirs is None):
        now, was = ("no liquid" if of is None else of.liquid.name for of in (ours, theirs))
        raise _another(f"{key}.liquid", now, was, name, cure)
    if ours is not None and theirs is not None:
        for (ours_name, now), (_, was) in zip(_of_liquid(ours), _of_liquid(theirs), strict=True):
            if now != was:
                raise _another(f"{key}.{ours_name}", now, was, name, cure)


def _shape(cargo: Cargo) -> str:
    sides = " x ".join(map(_length, (*cargo.container.footprint.sides, cargo.container.height)))
    return f"{cargo.shape} ({sides})"


def _of_liquid(filling: Filling) -> Iterator[tuple[str, str]]:
    """What its liquid swings by: keys of the scenario and their values."""
    yield "liquid", f"{filling.liquid.name} ({filling.liquid.density:.6g} kg/m^3)"
    yield "liquid_height", _length(filling.liquid_height)
    yield "contact_line", filling.contact_line or "none"
    yield "contact_angle", "none" if filling.contact_angle is None else _deg(filling.contact_angle)
    yield "damping", f"{filling.modes.slowest.damping:.6g}"


def _another(key: str, now: str, was: str, name: str, cure: str) -> ScenarioError:
    return ScenarioError(f"{key} is {now} here and {was} in {name}, the motion before; {cure}")


def _length(value: float) -> str:
    return format_quantity(value, "length")


def _deg(value: float) -> str:
    return format_quantity(value, "angle")


def _mm(values: Sequence[float] | np.ndarray) -> str:
    return f"({', '.join(f'{1e3 * value:.6g}' for value in np.asarray(values).tolist())}) mm"
