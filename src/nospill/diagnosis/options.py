"""What can be changed so that an arm follows its path: where it stands, the tray on its flange, the turn, a limit."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nospill.core.units import format_quantity, quantity
from nospill.diagnosis.joint_relaxations import own_robot
from nospill.errors import Change, Reason
from nospill.laws.constraints.joint_position import JointPosition
from nospill.paths.path import Path
from nospill.robots.robot import Robot
from nospill.robots.tool import Tool
from nospill.scenario.fields import FREE
from nospill.scene.scene import Scene

_LEAST_SHIFT, _GROWTH, _LARGEST_SHIFT = 0.01, 1.5, 1.5
_SPARE_PART, _SPARE_LENGTH, _SPARE_ANGLE = 1.05, 0.005, math.radians(1.0)
"""What a suggestion goes beyond the least that was found enough: at the very edge of its reach an arm is slow."""
_TURN_STEP = math.radians(15.0)
_TURNS = 12


@dataclass(frozen=True, slots=True)
class Option:
    """One kind of change: how much of it, from nothing on.

    Attributes:
        amounts: increasing, to be tried one after the other.
        size: of one unit of it, for comparing kinds.
        moved: amount -> the task with this much of the change.
        change: amount -> the same for the scenario.
        spare: amount -> the amount that is suggested.
    """

    amounts: tuple[float, ...]
    size: float
    moved: Callable[[float], Task]
    change: Callable[[float], Change]
    spare: Callable[[float], float]


@dataclass(frozen=True, slots=True)
class Task:
    """What a joint path depends on."""

    robot: Robot
    path: Path
    tool: Tool


def option_groups(scene: Scene, reason: Reason) -> Iterator[list[Option]]:
    """Kinds of changes; the options of one kind are tried together, the one that needs least is taken."""
    if reason.constraint == JointPosition.name:
        yield _wider_limit(scene, reason)
    yield smaller_turn(scene)
    yield _lower_tray(scene)
    yield _shifts(scene, reason)
    yield _tray_directions(scene)
    if reason.constraint != "reach":
        yield _base_directions(scene)


def _task(scene: Scene) -> Task:
    return Task(scene.robot, scene.path, scene.tray.tool)


def _robot_table(scene: Scene) -> dict[str, Any]:
    table = scene.source["robot"]
    assert isinstance(table, dict)  # the reader saw to it
    return table


def _tray_table(scene: Scene) -> dict[str, Any]:
    table = scene.source["tray"]
    assert isinstance(table, dict)  # the reader saw to it
    return table


def _base_position(scene: Scene) -> np.ndarray:
    entries = _robot_table(scene).get("base_position", (0.0, 0.0, 0.0))
    return np.array([quantity(entry, "length") for entry in entries])


def _reach(scene: Scene) -> float:
    return scene.robot.reach or 1.0


def _shifts(scene: Scene, reason: Reason) -> list[Option]:
    """The base moved: along the axes, and towards where the path is farthest; upright, a lower tray is the same."""
    task, base = _task(scene), _base_position(scene)
    directions = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]
    ends = [scene.path.at(at)[0, :3] for at in (reason.at_s or 0.0, 0.5, 1.0)]
    for place in ends:
        towards = (place - base) * np.array([1.0, 1.0, 0.0])
        if np.linalg.norm(towards) > 1e-3:
            directions.append(towards / np.linalg.norm(towards))
    least = max(_LEAST_SHIFT, (reason.excess or 0.0) if reason.constraint == "reach" else 0.0)
    count = math.ceil(math.log(max(_LARGEST_SHIFT / least, 1.0)) / math.log(_GROWTH))
    amounts = tuple(least * _GROWTH**step for step in range(count + 1))
    options = []
    for direction in directions:
        offset = np.array([*direction, 0.0])

        def moved(amount: float, offset: np.ndarray = offset) -> Task:
            coefficients = task.path.coefficients.copy()
            coefficients[-1] -= amount * offset
            return replace(task, path=Path(task.path.breaks, coefficients))

        def change(amount: float, direction: np.ndarray = direction) -> Change:
            place = np.round(base + amount * direction, 4)
            shown = ", ".join(f"{1e3 * value:.4g}" for value in place)
            now = ", ".join(f"{1e3 * value:.4g}" for value in base)
            text = f"base {1e3 * amount:.3g} mm elsewhere (base_position {shown} mm instead of {now} mm)"
            return Change("reach of the arm", "robot.base_position", place.tolist(), text)

        options.append(Option(amounts, 1.0 / _reach(scene), moved, change, _longer))
    return options


def _longer(amount: float) -> float:
    return _SPARE_PART * amount + _SPARE_LENGTH


def _lower_tray(scene: Scene) -> list[Option]:
    """The tray nearer to the flange."""
    task, offset = _task(scene), np.asarray(scene.tray.tool.position)
    height = float(offset[2])
    if abs(height) < _LEAST_SHIFT:
        return []

    def nearer(amount: float) -> np.ndarray:
        return offset - np.array([0.0, 0.0, math.copysign(min(amount, abs(height)), height)])

    def moved(amount: float) -> Task:
        return replace(task, tool=replace(task.tool, position=nearer(amount)))

    def change(amount: float) -> Change:
        value = np.round(nearer(amount), 4)
        new, old = (format_quantity(float(z), "length", digits=4) for z in (value[2], height))
        return Change("reach of the arm", "tray.offset", value.tolist(), f"tray.offset {new} instead of {old}")

    amounts = tuple(abs(height) * part / 16.0 for part in range(1, 17))
    return [Option(amounts, 1.0 / _reach(scene), moved, change, _longer)]


def smaller_turn(scene: Scene) -> list[Option]:
    """The yaw along the path, less of it about its start."""
    task, table = _task(scene), scene.source["path"]
    assert isinstance(table, dict)
    if scene.path.joint_curve is not None:
        return []
    given = table.get("yaw", FREE)
    values = np.array([quantity(entry, "angle") for entry in given if entry != FREE] if given != FREE else (0.0, 0.0))
    turn = float(np.max(np.abs(values - values[0])))
    if turn < 1e-6:
        return []

    def moved(amount: float) -> Task:
        part = max(1.0 - amount / turn, 0.0)
        coefficients = task.path.coefficients.copy()
        coefficients[:, :, 3] *= part
        coefficients[-1, :, 3] += (1.0 - part) * values[0]
        return replace(task, path=Path(task.path.breaks, coefficients))

    def change(amount: float) -> Change:
        kept = values[0] + max(1.0 - amount / turn, 0.0) * (values - values[0])
        value: list[float] | list[str] = np.round(kept, 5).tolist()
        if scene.motion.yaw_free:
            value = [f"{kept[0]:.5g} rad", FREE, f"{kept[-1]:.5g} rad"]
        new = format_quantity(float(np.max(np.abs(kept - values[0]))), "angle", digits=4)
        text = f"yaw change at most {new} instead of {format_quantity(turn, 'angle', digits=4)}"
        return Change("turn of the tray", "path.yaw", value, text)

    amounts = tuple(turn * part / 16.0 for part in range(1, 17))
    return [Option(amounts, 1.0 / math.pi, moved, change, lambda amount: min(amount + _SPARE_ANGLE, turn))]


def _tray_directions(scene: Scene) -> list[Option]:
    """The tray mounted in another direction."""
    task = _task(scene)
    return _both_ways(
        quantity(_tray_table(scene).get("yaw_on_flange", 0.0), "angle"),
        "turn of the tray",
        "tray.yaw_on_flange",
        lambda angle: replace(task, tool=replace(task.tool, yaw=task.tool.yaw + angle)),
    )


def _base_directions(scene: Scene) -> list[Option]:
    """The base turned about the world's vertical, which is the path turned the other way about it."""
    given = _robot_table(scene).get("base_yaw", 0.0)
    if given == "free":
        return []
    task, base = _task(scene), _base_position(scene)

    def moved(angle: float) -> Task:
        cosine, sine = math.cos(angle), -math.sin(angle)
        coefficients = task.path.coefficients.copy()
        coefficients[-1, :, :3] -= base
        x, y = coefficients[:, :, 0].copy(), coefficients[:, :, 1].copy()
        coefficients[:, :, 0], coefficients[:, :, 1] = cosine * x - sine * y, sine * x + cosine * y
        coefficients[-1, :, :3] += base
        coefficients[-1, :, 3] -= angle
        return replace(task, path=Path(task.path.breaks, coefficients))

    return _both_ways(quantity(given, "angle"), "turn of the base", "robot.base_yaw", moved)


def _both_ways(now: float, what: str, place: str, moved: Callable[[float], Task]) -> list[Option]:
    """An angle of the scenario larger and smaller, by up to half a turn.

    Args:
        now: its value, rad.
        what: as in `Change`.
        place: likewise.
        moved: angle added -> task.
    """
    amounts = tuple(_TURN_STEP * step for step in range(1, _TURNS + 1))
    options = []
    for sign in (1.0, -1.0):

        def change(amount: float, sign: float = sign) -> Change:
            value = now + sign * amount
            new, old = (format_quantity(angle, "angle", digits=4) for angle in (value, now))
            return Change(what, place, value, f"{place.removeprefix('robot.')} {new} instead of {old}")

        options.append(
            Option(
                amounts,
                1.0 / math.pi,
                lambda amount, sign=sign: moved(sign * amount),
                change,
                lambda amount: amount + _SPARE_ANGLE,
            )
        )
    return options


def _wider_limit(scene: Scene, reason: Reason) -> list[Option]:
    """The limit that is passed, where the scenario and not the robot has set it."""
    robot, described = scene.robot, own_robot(scene)
    joint, excess = robot.joints.index(reason.subject), reason.excess or 0.0
    task = _task(scene)
    options = []
    for key, limits, sign in (("upper", robot.upper, 1.0), ("lower", robot.lower, -1.0)):
        spare = math.inf if described is None else float(sign * (getattr(described, key) - limits)[joint])
        if spare < 1e-6:
            continue
        most = min(spare, 4.0 * excess + math.radians(5.0))

        def moved(amount: float, key: str = key, limits: np.ndarray = limits, sign: float = sign) -> Task:
            values = limits.copy()
            values[joint] += sign * amount
            return replace(task, robot=replace(robot, **{key: values}))

        def change(amount: float, key: str = key, limits: np.ndarray = limits, sign: float = sign) -> Change:
            values = limits.copy()
            values[joint] += sign * amount
            new, old = (format_quantity(float(angle[joint]), "angle", digits=4) for angle in (values, limits))
            text = f"limits.{key} {new} instead of {old} ({reason.subject})"
            return Change.of_limit(JointPosition.name, reason.subject, f"robot.limits.{key}", values.tolist(), text)

        amounts = tuple(most * part / 8.0 for part in range(1, 9))
        options.append(
            Option(amounts, 1.0 / math.pi, moved, change, lambda amount, spare=spare: min(amount + _SPARE_ANGLE, spare))
        )
    return options
