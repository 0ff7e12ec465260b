"""Which key of a scenario makes room for which constraint: one table, a constraint -> the levers that widen it.

A lever grows by a share: at 0 the scenario stands as it is, at 0.2 the room is a fifth larger.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nospill.core.units import format_quantity
from nospill.diagnosis.changes import EVERY
from nospill.errors import Change, NospillError, Setting
from nospill.laws.constraints.base import liquid_names
from nospill.robots.robot import Robot
from nospill.scenario import scene_from_table
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene

MOST = 50.0
"""No budget grows by more than this many times its size."""
_MAIN = 0.7
"""A subject with this part of the pull of its constraint is tried alone."""


@dataclass(frozen=True, slots=True)
class Lever:
    """One key that makes room.

    Attributes:
        constraint: which it widens. subject: who needs it most.
        most: the largest share that the key's bounds, the robot or the rim allow.
        change: share -> the change of the scenario.
        scene: share -> the scene of the changed scenario.
    """

    constraint: str
    subject: str
    most: float
    change: Callable[[float], Change]
    scene: Callable[[float], Scene]


def levers_of(scene: Scene, constraint: str, subject: str, pulls: dict[tuple[str, int], float]) -> list[Lever]:
    """The levers for a constraint.

    Args:
        scene: the task.
        constraint: what holds it back.
        subject: who most.
        pulls: of each subject of each constraint; any positive measure.
    """
    make = _LEVERS.get(constraint)
    return [] if make is None else [lever for lever in make(scene, constraint, subject, pulls) if lever.most > 1e-3]


_Pulls = dict[tuple[str, int], float]
_Maker = Callable[[Scene, str, str, _Pulls], list[Lever]]


def _with_cargo(scene: Scene, indices: Sequence[int], changed: Callable[[Cargo], Cargo]) -> Scene:
    return replace(
        scene, cargo=tuple(changed(item) if index in indices else item for index, item in enumerate(scene.cargo))
    )


def _instead(what: str, value: float, now: float, dimension: str, whose: str = "") -> str:
    new, old = (format_quantity(number, dimension, digits=3) for number in (value, now))
    return f"{what} {new} instead of {old}" + (f" ({whose})" if whose else "")


def _entry(scene: Scene, name: str) -> dict[str, Any]:
    entries = scene.source.get("cargo")
    assert isinstance(entries, list)
    return next((entry for entry in entries if entry.get("name") == name), {})


def _is_main(index: int, constraint: str, pulls: _Pulls) -> bool:
    total = sum(max(pull, 0.0) for (name, _), pull in pulls.items() if name == constraint)
    return pulls.get((constraint, index), 0.0) >= _MAIN * total


# --- what stands on the tray ---------------------------------------------------------------------------------------


def _friction(scene: Scene, constraint: str, subject: str, pulls: _Pulls) -> list[Lever]:
    """The object's own friction if it has one, else the tray's, which is that of all without their own."""
    names = [cargo.name for cargo in scene.cargo]
    own = "friction" in _entry(scene, subject)
    now = scene.cargo[names.index(subject)].friction
    alike = [index for index, name in enumerate(names) if name == subject or not own]
    alike = [index for index in alike if own or "friction" not in _entry(scene, names[index])]
    place, whose = (f"cargo.{subject}.friction", subject) if own else ("tray.friction", "tray")

    def change(share: float) -> Change:
        value = now * (1.0 + share)
        return Change(f"{constraint} of {subject}", place, value, _instead("friction", value, now, "ratio", whose))

    def rougher(share: float) -> Scene:
        return _with_cargo(scene, alike, lambda item: replace(item, friction=now * (1.0 + share)))

    return [Lever(constraint, subject, 2.0 / now - 1.0, change, rougher)]


def _slosh_height(scene: Scene, constraint: str, subject: str, pulls: _Pulls) -> list[Lever]:
    """The cup's own limit; that of all cups where they have the same one and more than one of them needs it."""
    names = liquid_names(scene)
    filled = {cargo.name: cargo for cargo in scene.cargo if cargo.filling}
    limits = {name: cargo.filling.max_slosh_height for name, cargo in filled.items() if cargo.filling}
    index, now = names.index(subject), limits[subject]
    same = [i for i, name in enumerate(names) if math.isclose(limits[name], now)]
    given = all("max_slosh_height" in _entry(scene, names[i]) for i in same)
    sharing = len(same) == len(names) > 1 and given
    levers = []
    for chosen in ([index], same) if sharing else ([index],):
        if len(chosen) == 1 and sharing and not _is_main(index, constraint, pulls):
            continue
        rooms = [_room(filled[names[i]]) / now - 1.0 for i in chosen]
        place, whose = (subject, subject) if len(chosen) == 1 else (EVERY, "all cups")

        def change(share: float, place: str = place, whose: str = whose) -> Change:
            value = now * (1.0 + share)
            text = _instead("max_slosh_height", value, now, "length", whose)
            return Change(f"{constraint} of {subject}", f"cargo.{place}.max_slosh_height", value, text)

        def higher(share: float, whose: tuple[str, ...] = tuple(names[i] for i in chosen)) -> Scene:
            indices = [index for index, item in enumerate(scene.cargo) if item.name in whose]
            return _with_cargo(scene, indices, lambda item: _with_limit(item, now * (1.0 + share)))

        levers.append(Lever(constraint, subject, min(rooms), change, higher))
    return levers


def _with_limit(item: Cargo, max_slosh_height: float) -> Cargo:
    assert item.filling is not None
    return replace(item, filling=replace(item.filling, max_slosh_height=max_slosh_height))


def _room(cargo: Cargo) -> float:
    assert cargo.filling is not None
    return cargo.container.height - cargo.filling.liquid_height


def _centre_of_mass(scene: Scene, constraint: str, subject: str, pulls: _Pulls) -> list[Lever]:
    """A solid's centre of mass lower; for a container its footprint reserve, where there is one."""
    index = next(i for i, cargo in enumerate(scene.cargo) if cargo.name == subject)
    item = scene.cargo[index]
    if item.filling is None and "centre_of_mass" not in _entry(scene, subject):
        height = float(item.total.centre[2])

        def lowered(share: float) -> Scene:
            total = replace(item.total, centre=item.total.centre * np.array([1.0, 1.0, 1.0 / (1.0 + share)]))
            return _with_cargo(scene, [index], lambda item: replace(item, total=total, empty=total))

        def change(share: float) -> Change:
            value = height / (1.0 + share)
            text = _instead("centre_of_mass_height", value, height, "length", subject)
            return Change(f"{constraint} of {subject}", f"cargo.{subject}.centre_of_mass_height", value, text)

        return [Lever(constraint, subject, 9.0, change, lowered)]
    reserve = item.footprint_reserve

    def less(share: float) -> Change:
        value = 1.0 - (1.0 - reserve) * (1.0 + share)
        text = _instead("footprint_reserve", value, reserve, "ratio", subject)
        return Change(f"{constraint} of {subject}", f"cargo.{subject}.footprint_reserve", value, text)

    def used(share: float) -> Scene:
        value = 1.0 - (1.0 - reserve) * (1.0 + share)
        return _with_cargo(scene, [index], lambda item: replace(item, footprint_reserve=value))

    return [Lever(constraint, subject, 0.999 / (1.0 - reserve) - 1.0, less, used)]


# --- the arm -------------------------------------------------------------------------------------------------------

_JOINT_LIMITS = {
    "joint speed": ("speed", "max_speed", "angular_speed"),
    "joint acceleration": ("acceleration", "max_acceleration", "angular_acceleration"),
    "joint jerk": ("jerk", "max_jerk", "angular_jerk"),
    "joint torque": ("torque", "max_torque", "torque"),
}
"""Constraint -> key of [robot.limits], attribute of the robot, dimension."""


def own_robot(scene: Scene) -> Robot | None:
    """The arm with the limits of its own data, without those of the scenario; None where its data have none."""
    robot = scene.source.get("robot")
    assert isinstance(robot, dict)
    bare = {key: value for key, value in robot.items() if key not in ("limits", "limits_applied", "home")}
    table = {key: value for key, value in scene.source.items() if key != "approach"}
    try:
        return scene_from_table(table | {"robot": bare}, name=scene.name).robot
    except NospillError:
        return None


Raised = Callable[[float], np.ndarray]
"""Share -> the limits of all joints."""


def _joint_limit(scene: Scene, constraint: str, subject: str, pulls: _Pulls) -> list[Lever]:
    """The scenario's scale of the limit where it has one, else the limit of the joint, or of all joints that need it.

    No limit grows beyond the robot's own.
    """
    key, attribute, dimension = _JOINT_LIMITS[constraint]
    now = np.array(getattr(scene.robot, attribute))
    index = scene.robot.joints.index(subject)
    robot = own_robot(scene)
    own = None if robot is None else getattr(robot, attribute)
    room = np.full(len(now), MOST) if own is None else own / now - 1.0
    limits = _limits_table(scene)
    scale = limits.get(f"{key}_scale")
    if scale is not None:
        scale = float(np.max(now / own)) if own is not None and key not in limits else None
    if scale is not None:
        factor = scale

        def rescaled(share: float) -> Change:
            value = factor * (1.0 + share)
            text = _instead(f"limits.{key}_scale", value, factor, "ratio", subject)
            return Change(f"{constraint} of {subject}", f"robot.limits.{key}_scale", value, text)

        def loosened(share: float) -> Scene:
            return _with_limits(scene, attribute, now * (1.0 + share))

        return [Lever(constraint, subject, 1.0 / factor - 1.0, rescaled, loosened)]
    if f"{key}_scale" in limits:  # a scale of values that are given too: none of the two alone says what to write
        return []
    able = [joint for joint in range(len(now)) if room[joint] > 1e-6]
    levers = []
    for chosen in ([index], able) if _is_main(index, constraint, pulls) else (able,):

        def raised(share: float, chosen: list[int] = chosen) -> np.ndarray:
            values = now.copy()
            values[chosen] = np.minimum(now[chosen] * (1.0 + share), now[chosen] * (1.0 + room[chosen]))
            return values

        def change(share: float, raised: Raised = raised, chosen: list[int] = chosen) -> Change:
            values = raised(share)
            value: Setting = values.tolist()
            whose = subject if len(chosen) == 1 else f"{subject}, the others alike"
            text = _instead(f"limits.{key}", float(values[index]), float(now[index]), dimension, whose)
            return Change(f"{constraint} of {subject}", f"robot.limits.{key}", value, text)

        def stronger(share: float, raised: Raised = raised) -> Scene:
            return _with_limits(scene, attribute, raised(share))

        levers.append(Lever(constraint, subject, min(float(room[index]), MOST), change, stronger))
    return levers


def _with_limits(scene: Scene, attribute: str, values: np.ndarray) -> Scene:
    return replace(scene, robot=replace(scene.robot, **{attribute: values}))


def _limits_table(scene: Scene) -> dict[str, Any]:
    robot = scene.source.get("robot")
    assert isinstance(robot, dict)
    return robot.get("limits", {})


def _torque(scene: Scene, constraint: str, subject: str, pulls: _Pulls) -> list[Lever]:
    """The torque limit, or less to carry: the heaviest solid, or the tray."""
    found = _joint_limit(scene, constraint, subject, pulls)
    solids = [index for index, cargo in enumerate(scene.cargo) if cargo.filling is None]
    if not solids:
        return found
    heaviest = max(solids, key=lambda index: scene.cargo[index].total.mass)
    item = scene.cargo[heaviest]

    def lighter(share: float) -> Scene:
        part = 1.0 / (1.0 + share)
        total = replace(item.total, mass=part * item.total.mass, inertia=part * item.total.inertia)
        return _with_cargo(scene, [heaviest], lambda item: replace(item, total=total, empty=total))

    def change(share: float) -> Change:
        value = item.total.mass / (1.0 + share)
        text = _instead("mass", value, item.total.mass, "mass", item.name)
        return Change(f"{constraint} of {subject}", f"cargo.{item.name}.mass", value, text)

    return [*found, Lever(constraint, subject, MOST, change, lighter)]


# --- the rules of the motion ---------------------------------------------------------------------------------------


def _rule(key: str, dimension: str, largest: float) -> _Maker:
    def make(scene: Scene, constraint: str, subject: str, pulls: _Pulls) -> list[Lever]:
        now = float(getattr(scene.motion, key))

        def change(share: float) -> Change:
            value = now * (1.0 + share)
            return Change(f"{constraint} of {subject}", f"motion.{key}", value, _instead(key, value, now, dimension))

        def milder(share: float) -> Scene:
            return replace(scene, motion=replace(scene.motion, **{key: now * (1.0 + share)}))

        return [Lever(constraint, subject, largest / now - 1.0, change, milder)]

    return make


_LEVERS: dict[str, _Maker] = {
    "slosh height": _slosh_height,
    "residual height": _rule("residual_fraction", "ratio", 1.0),
    "slip": _friction,
    "twist": _friction,
    "tip": _centre_of_mass,
    "joint speed": _joint_limit,
    "joint acceleration": _joint_limit,
    "joint jerk": _joint_limit,
    "joint torque": _torque,
    "tilt": _rule("max_tilt", "angle", math.radians(59.9)),
    "path jerk": _rule("path_jerk_limit", "path_jerk", 1e6),
    "tilt jerk": _rule("tilt_jerk_limit", "angular_jerk", 1e6),
}
"""What is missing here (lift, apparent gravity, joint position) has no key that makes room for it alone."""
