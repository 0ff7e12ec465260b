"""From the table of a scenario file to a Scene, and back to a file that needs no other."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path as FilePath
from typing import Any, TypeVar

import numpy as np
from pydantic import ValidationError

from nospill.core.units import as_written, format_quantity
from nospill.errors import ModelError, Reason, ScenarioError
from nospill.paths.path import Path
from nospill.robots.interfaces import SAME_RATE, Interface, limited_by
from nospill.robots.robot import Robot
from nospill.scenario.arrays import MOST_OBJECTS, check_array, members, spread_table
from nospill.scenario.cargo_entries import CargoTable
from nospill.scenario.cargo_reader import read_cargo
from nospill.scenario.carrier_reader import check_carrier, loaded, seated
from nospill.scenario.conflicts import (
    check_ends,
    check_height,
    check_motion,
    check_still_end,
    height_order,
    residual_order,
)
from nospill.scenario.fields import FREE
from nospill.scenario.in_motion import require_may_begin_in_motion
from nospill.scenario.layout import layout_faults
from nospill.scenario.messages import cargo_place, entry_place, faults_of
from nospill.scenario.model import DEFAULT_JERK, MotionTable, Scenario
from nospill.scenario.obstacle_reader import read_obstacles
from nospill.scenario.rest_reasons import layout_reason, payload_reason
from nospill.scenario.sentences import Fault, report
from nospill.scenario.tables import Table, plain
from nospill.scene.cargo import Cargo
from nospill.scene.controller import Controller
from nospill.scene.places import Via
from nospill.scene.scene import FULL_MODES, ApproachRules, MotionRules, Origin, PlanningOptions, Scene, path_length_of
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from nospill.scene.tolerances import greatest_mass
from nospill.scene.tray import Tray
from nospill.scene.turning import turning, turns

_Record = TypeVar("_Record", bound=MotionRules | PlanningOptions)
_NOT_IN_NAMES = re.compile(r"[^A-Za-z0-9_-]+", re.ASCII)


@contextmanager
def _at(label: str, place: str) -> Iterator[None]:
    """Name the place in the messages of the parts, which do not know it."""
    try:
        yield
    except (ScenarioError, ModelError) as error:
        raise report(label, [(place, str(error))], error.reason) from None


def read_scene(
    table: Mapping[str, Any], *, label: str, name: str, folder: FilePath, origin: Callable[[dict[str, Any]], Origin]
) -> Scene:
    """Build a scene.

    Args:
        table: keys and values as in the file; it is not changed.
        label: what messages call it.
        name: the scene's name where the table has none.
        folder: where files that the table names are looked up.
        origin: what the scene keeps of the table that needs no other file.

    Raises:
        ScenarioError: the table describes no possible task.
    """
    try:
        scenario = Scenario.model_validate(dict(table))
    except ValidationError as error:
        raise report(label, faults_of(error, table)) from None
    with _at(label, "[robot]"):
        bodies = bool(scenario.obstacle) or scenario.robot.self_collision == "on"
        described = scenario.robot.standalone(folder, capsules=bodies)
        robot = scenario.robot.model_copy(update=described).build()
    with _at(label, "[controller]"):
        controller = None if scenario.controller is None else scenario.controller.build(robot)
    interface = None if controller is None else controller.interface
    if interface is not None:
        robot = limited_by(robot, interface)
    with _at(label, "[approach]"):
        approach = None if scenario.approach is None else scenario.approach.build(robot)
    with _at(label, "[tolerance]"):
        stated = scenario.tolerance and scenario.tolerance.tracking
        tracking = None if stated is None else stated.build(robot)
    tray = scenario.tray.build()
    with _at(label, "[path]"):
        read_in, base_is_free = scenario.path.standalone(folder, robot), scenario.robot.base_yaw == FREE
        path_table = scenario.path.model_copy(update=read_in).placed(robot, tray.tool, base_is_free=base_is_free)
        scenario = scenario.model_copy(update={"path": path_table})
        path = path_table.build()
        passed = path_table.places_passed(path)
    scenario, cargo_tables = _every_object(scenario, table, folder, label)
    cargo = _cargo(scenario, label)
    _check_payload(robot, tray, cargo, scenario, label)
    with _at(label, "[motion]"):
        check_motion(scenario)
        check_height(scenario, cargo)
        check_still_end(scenario)
    with _at(label, "[path]"):
        check_ends(path, cargo)
    faults = layout_faults(cargo, tray)
    if faults:
        raise report(label, faults, layout_reason(cargo, tray))
    described_obstacles = _standalone_obstacles(scenario, folder, label)
    around = [entry.model_copy(update=new) for entry, new in zip(scenario.obstacle, described_obstacles, strict=True)]
    regions = path_table.regions
    obstacles = read_obstacles(around, robot=robot, cargo=cargo, path=path, passed=passed, regions=regions, label=label)
    scene_name = scenario.name or _NOT_IN_NAMES.sub("-", name)[:64] or "scenario"
    source = {
        **table,
        "name": scene_name,
        "robot": {**table["robot"], **described},
        "path": {**table["path"], **read_in},
        "cargo": cargo_tables,
    }
    if described_obstacles:
        source["obstacle"] = [
            {**entry, **update} for entry, update in zip(table["obstacle"], described_obstacles, strict=True)
        ]
    motion = _motion(scenario, path, tray, cargo, passed, interface)
    with _at(label, "[output]"):
        output_rate = _output_rate(scenario, controller)
    with _at(label, "[initial_state]"):
        require_may_begin_in_motion(scenario)
        state = scenario.initial_state
        initial_state = None if state is None else state.build(robot, tray.tool, path, motion)
    if scenario.fidelity == "full" and turns(path, motion):
        cargo = tuple(turning(item) for item in cargo)
    return Scene(
        name=scene_name,
        fidelity=scenario.fidelity,
        robot=robot,
        tray=tray,
        cargo=cargo,
        path=path,
        motion=motion,
        planning=_record_of(PlanningOptions, scenario.planning, {}),
        output_rate=output_rate,
        gravity=STANDARD_GRAVITY,
        slosh_modes=_slosh_modes(scenario),
        origin=origin(plain(_stated(source))),
        approach=approach,
        controller=controller,
        tracking=tracking,
        start_near=_start_near(scenario, robot, approach),
        obstacles=obstacles,
        regions=regions,
        initial_state=initial_state,
    ).marked_as_read()


def _output_rate(scenario: Scenario, controller: Controller | None) -> float:
    """The rate that is stated, Hz; else that of the interface, for which the samples then are.

    Raises:
        ScenarioError: the interface reads fewer positions a second; starts with the key.
    """
    stated = scenario.output.rate
    if controller is None or controller.interface is None:
        return stated
    if "rate" not in scenario.output.model_fields_set:
        return controller.update_rate
    if stated > controller.update_rate * (1.0 + SAME_RATE):
        raise ScenarioError(
            f"rate is {stated:g} Hz; {controller.interface.name} reads {controller.update_rate:.6g} positions a "
            "second; leave rate out"
        )
    return stated


def _stated(source: Mapping[str, Any]) -> dict[str, Any]:
    """The scenario without empty tables and lists that say no more than their absence."""
    defaults = {key: field.default for key, field in Scenario.model_fields.items()}
    empty = {key for key, value in source.items() if value in ({}, []) and isinstance(defaults[key], Table | list)}
    return {key: value for key, value in source.items() if key not in empty}


def _start_near(scenario: Scenario, robot: Robot, approach: ApproachRules | None) -> np.ndarray | None:
    """What the scenario itself says of where the arm comes from; a catalogue's home is no wish of the user's."""
    if approach is not None:
        return approach.start
    return robot.home if scenario.robot.home is not None else None


def read_object(entry: CargoTable, scenario: Scenario) -> Cargo:
    """`read_cargo` with what the scenario says of all objects."""
    return read_cargo(
        entry,
        friction=scenario.tray.friction,
        friction_reserve=scenario.tray.friction_reserve,
        footprint_reserve=scenario.tray.footprint_reserve,
        fidelity=scenario.fidelity,
        slosh_modes=_slosh_modes(scenario),
        tolerance=scenario.tolerance,
    )


def _slosh_modes(scenario: Scenario) -> int:
    """As stated, else so many at full fidelity that one more changes nothing, and the published one otherwise."""
    return scenario.planning.slosh_modes or (FULL_MODES if scenario.fidelity == "full" else 1)


def _every_object(
    scenario: Scenario, table: Mapping[str, Any], folder: FilePath, label: str
) -> tuple[Scenario, list[dict[str, Any]]]:
    """The scenario with an entry for every object, none of which needs a file, and their tables."""
    entries: list[CargoTable] = []
    tables: list[dict[str, Any]] = []
    for index, (entry, given) in enumerate(zip(scenario.cargo, table.get("cargo", []), strict=True)):
        with _at(label, cargo_place(index, {"name": entry.name})):
            update = entry.standalone(folder)
            own = entry.model_copy(update=update)
            changes: list[dict[str, Any]] = [{}]
            if own.array is not None:
                check_array(own.name, own.array, own.container())
                changes = members(own.name, own.at, own.yaw, own.array)
        entries += [own.model_copy(update={**change, "array": None}) for change in changes]
        tables += spread_table({**given, **update}, changes)
    if len(entries) > MOST_OBJECTS:
        raise report(label, [("", f"{len(entries)} objects stand on the tray; at most {MOST_OBJECTS} may")])
    return scenario.model_copy(update={"cargo": entries}), tables


def _standalone_obstacles(scenario: Scenario, folder: FilePath, label: str) -> list[dict[str, object]]:
    """What each obstacle needs in place of the files that it names."""
    found: list[dict[str, object]] = []
    for index, entry in enumerate(scenario.obstacle):
        with _at(label, entry_place("obstacle", index, {"name": entry.name})):
            found.append(entry.standalone(folder))
    return found


def _cargo(scenario: Scenario, label: str) -> tuple[Cargo, ...]:
    cargo: dict[str, Cargo] = {}
    faults: list[Fault] = []
    reason: Reason | None = None
    owners: dict[str, int] = {}
    entries = {entry.name: entry for entry in scenario.cargo}
    for index, entry in enumerate(scenario.cargo):
        place = cargo_place(index, {"name": entry.name})
        if entry.name in owners:
            first = owners[entry.name] + 1
            text = f"name {as_written(entry.name)} is already taken by cargo {first}; give every object its own"
            faults.append((f"cargo {index + 1}", text))
        owners.setdefault(entry.name, index)
        try:
            check_carrier(entry, entries)
            cargo[entry.name] = read_object(entry, scenario)
        except (ScenarioError, ModelError) as error:
            reason = reason if faults else error.reason
            faults.append((place, str(error)))
    if faults:
        raise report(label, faults, reason)
    return _in_carriers(scenario, cargo, label)


def _in_carriers(scenario: Scenario, cargo: dict[str, Cargo], label: str) -> tuple[Cargo, ...]:
    """The objects, those in carriers at their places, and the carriers with them."""
    content: dict[str, list[Cargo]] = {}
    for index, entry in enumerate(scenario.cargo):
        if entry.carrier is not None:
            with _at(label, cargo_place(index, {"name": entry.name})):
                cargo[entry.name] = seated(cargo[entry.name], entry, cargo[entry.carrier])
            content.setdefault(entry.carrier, []).append(cargo[entry.name])
    for name, items in content.items():
        with _at(label, f"cargo {as_written(name)}"):
            cargo[name] = loaded(cargo[name], items)
    return tuple(cargo.values())


def _check_payload(robot: Robot, tray: Tray, cargo: tuple[Cargo, ...], scenario: Scenario, label: str) -> None:
    load = sum(greatest_mass(item, fidelity=scenario.fidelity) for item in cargo if not item.carrier)
    at_most = "at most " if any(item.tolerance for item in cargo) else ""
    if robot.payload is not None and tray.mass + load > robot.payload * (1.0 + 1e-9):  # rounding of the sum
        raise report(
            label,
            [
                (
                    "[tray]",
                    f"tray and cargo weigh {at_most}{format_quantity(tray.mass + load, 'mass', digits=4)} (tray "
                    f"{format_quantity(tray.mass, 'mass', digits=4)}, cargo with its liquid "
                    f"{format_quantity(load, 'mass', digits=4)}), more than the "
                    f"{format_quantity(robot.payload, 'mass', digits=4)} that robot {robot.name!r} may carry; "
                    "take something off or choose a stronger arm",
                )
            ],
            payload_reason(robot, tray, cargo, tray.mass + load - robot.payload),
        )


def _path_jerk_limit(rules: MotionTable, path: Path, tray: Tray) -> float:
    """Bound on the third derivative of s, 1/s^3: as stated, or of a jerk along the way."""
    if rules.path_jerk_limit is not None:
        return rules.path_jerk_limit
    return (rules.max_jerk or DEFAULT_JERK) / path_length_of(path, tray)


def _motion(
    scenario: Scenario,
    path: Path,
    tray: Tray,
    cargo: tuple[Cargo, ...],
    passed: tuple[Via, ...],
    interface: Interface | None,
) -> MotionRules:
    rules, range_ = scenario.motion, scenario.motion.speed_range
    order, reason = height_order(scenario, cargo)
    residual, residual_reason = residual_order(scenario, cargo)
    speeds = [rules.max_speed, interface.checks.hand_speed if interface and interface.checks else None]
    own = {
        "max_speed": min((speed for speed in speeds if speed is not None), default=None),
        "tilt_free": rules.tilt == "free",
        "path_jerk_limit": _path_jerk_limit(rules, path, tray),
        "speed_range": None if range_ is None else (range_[0], range_[1]),
        "corridor": scenario.path.width,
        "corridor_shares": scenario.path.width_shares,
        "yaw_free": scenario.path.yaw_free,
        "via": passed,
        "slosh_height": order,
        "linear_since": reason,
        "residual_height": residual,
        "residual_linear_since": residual_reason,
    }
    return _record_of(MotionRules, rules, own)


def _record_of(record: type[_Record], table: Table, own: Mapping[str, Any]) -> _Record:
    """A record with its own values, and the others from the keys of the same names."""
    names = [item.name for item in fields(record)]
    return record(**{name: own[name] if name in own else getattr(table, name) for name in names})
