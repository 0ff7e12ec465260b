"""A scene that was changed in Python, made from a scenario that says so: checked and saved like any other."""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from nospill.core.units import DIMENSIONS
from nospill.errors import ScenarioError
from nospill.robots.robot import Robot
from nospill.scenario.fields import FREE
from nospill.scenario.reader import is_as_read, scene_from_table
from nospill.scene.cargo import Cargo, Filling, Tolerance
from nospill.scene.controller import Controller
from nospill.scene.liquids import LIQUIDS
from nospill.scene.obstacles import Obstacle
from nospill.scene.scene import ApproachRules, MotionRules, Scene

_SAME = 1e-9
"""Relative difference that is rounding."""

_COMPARED_ELSEWHERE = frozenset({"source", "start_near"})
_IN_WORDS = frozenset({"sources", "not_known", "notes", "title"})
"""Attributes of a robot that follow from where its figures come from."""

_PARTS = ("robot", "tray", "cargo", "path", "motion", "planning")

_MOTION = {
    "max_tilt": "angle",
    "max_speed": "speed",
    "max_acceleration": "acceleration",
    "path_jerk_limit": "path_jerk",
    "tilt_jerk_limit": "angular_jerk",
    "end": None,
    "residual_fraction": "ratio",
    "max_duration": "time",
    "duration": "time",
    "hold_before": "time",
    "hold_after": "time",
    "speed_range": None,
}
_LIMITS = {
    "lower": ("lower", "angle"),
    "upper": ("upper", "angle"),
    "max_speed": ("speed", "angular_speed"),
    "max_acceleration": ("acceleration", "angular_acceleration"),
    "max_jerk": ("jerk", "angular_jerk"),
    "max_torque": ("torque", "torque"),
}
_CONTROLLER = {"delay": "time", "lag": "time", "compensate": None, "tracking_tolerance": "angle"}
_PLACEMENT = {"yaw": "angle", "friction": "ratio", "friction_reserve": "ratio", "footprint_reserve": "ratio"}
_LIQUID = {"liquid_height": "length", "max_slosh_height": "length", "freeboard_reserve": "ratio"}


def described(scene: Scene) -> Scene:
    """The scene of the scenario that describes it; itself where its `source` does.

    What was changed with `dataclasses.replace` is written into the scenario's table and read again, so that it passes
    the reader's checks and a plan keeps what was planned.

    Raises:
        ScenarioError: the changed scenario describes no possible task, or no scenario describes the scene (another
            path, masses that contradict the sizes); names what.
    """
    if is_as_read(scene):
        return scene
    original = scene_from_table(scene.source, name=scene.name)
    _require_kinds(scene, original)
    if difference(original, scene) is None and _same(original.start_near, scene.start_near):
        return scene
    read = scene_from_table(_table(scene, original), name=scene.name)
    place = difference(read, scene)
    if place is None and not _same(scene.start_near, original.start_near):
        place = None if _same(scene.start_near, read.start_near) else "start_near"
    if place is not None:
        raise ScenarioError(
            f"{scene.name}: {place} of the scene was changed after it was read to what no scenario file says, or to "
            "what contradicts the rest; change the scenario instead, as in ns.load({**scene.source, ...})"
        )
    return read


def _require_kinds(scene: Scene, original: Scene) -> None:
    """Refuse a part of another kind, which has none of the attributes that are read below."""
    parts = [(name, getattr(scene, name), type(getattr(original, name))) for name in _PARTS]
    parts += [("cargo", item, Cargo) for item in scene.cargo]
    parts += [("obstacles", item, Obstacle) for item in scene.obstacles]
    parts += [("approach", scene.approach, ApproachRules)] if scene.approach is not None else []
    parts += [("controller", scene.controller, Controller)] if scene.controller is not None else []
    wrong = [(name, part) for name, part, wanted in parts if not isinstance(part, wanted)]
    if wrong:
        name, part = wrong[0]
        raise ScenarioError(
            f"{original.name}: {name} of the scene is of type {type(part).__name__}, no part of a scene"
        )


def difference(first: Any, second: Any, place: str = "") -> str | None:
    """The first attribute in which two records differ by more than rounding, as "cargo.c1.friction"; None if none."""
    if dataclasses.is_dataclass(first) and type(first) is type(second):
        left_out = _COMPARED_ELSEWHERE | (_IN_WORDS if isinstance(first, Robot) else frozenset())
        left_out |= _of_carriers(first) if isinstance(first, Cargo) else frozenset()
        pairs = [(f.name, getattr(first, f.name), getattr(second, f.name)) for f in dataclasses.fields(first)]
        pairs = [pair for pair in pairs if pair[0] not in left_out]
    elif isinstance(first, tuple) and isinstance(second, tuple):
        if len(first) != len(second):
            return place
        named = [item.name if isinstance(item, Cargo | Obstacle) else str(index) for index, item in enumerate(second)]
        pairs = list(zip(named, first, second, strict=True))
    else:
        return None if _same(first, second) else place
    for name, ours, theirs in pairs:
        found = difference(ours, theirs, f"{place}.{name}" if place else name)
        if found is not None:
            return found
    return None


def _of_carriers(item: Cargo) -> frozenset[str]:
    """What an object has from its carrier, or a carrier from what stands in it."""
    friction = {"friction", "friction_reserve", "footprint_reserve"} if item.carrier else set()
    return frozenset(friction | ({"total", "empty", "carried"} if item.carried is not None else set()))


def _same(first: Any, second: Any) -> bool:
    if isinstance(first, np.ndarray) or isinstance(second, np.ndarray):
        if np.shape(first) != np.shape(second) or first is None or second is None:
            return False
        return np.array_equal(first, second) or bool(np.allclose(first, second, rtol=_SAME, atol=_SAME * 1e-3))
    if isinstance(first, float) and isinstance(second, int | float):
        return math.isclose(first, second, rel_tol=_SAME)
    return type(first) is type(second) and bool(first == second)


def _table(scene: Scene, original: Scene) -> dict[str, Any]:
    """The scenario's table with what was changed, wherever there is a key for it."""
    table: dict[str, Any] = copy.deepcopy(scene.source)
    table["name"], table["fidelity"] = scene.name, scene.fidelity
    rules = _changed(scene.motion, original.motion, _MOTION)
    if "path_jerk_limit" in rules:
        rules["max_jerk"] = None
    if scene.motion.tilt_free != original.motion.tilt_free:
        rules["tilt"] = "free" if scene.motion.tilt_free else "fixed"
    _join(table, "motion", rules)
    _join(table, "path", _freedom(scene.motion, original.motion, table["path"]))
    options = {f.name: None for f in dataclasses.fields(scene.planning)}
    _join(table, "planning", _changed(scene.planning, original.planning, options))
    _join(table, "planning", _changed(scene, original, {"slosh_modes": None}))
    if scene.output_rate != original.output_rate:
        _join(table, "output", {"rate": scene.output_rate})
    tray = _changed(scene.tray, original.tray, {"size": "length", "mass": "mass"})
    tool = _changed(scene.tray.tool, original.tray.tool, {"position": "length", "yaw": "angle"})
    keys = {"position": "offset", "yaw": "yaw_on_flange"}
    _join(table, "tray", tray | {keys[name]: value for name, value in tool.items()})
    limits = _changed(scene.robot, original.robot, {name: dimension for name, (_, dimension) in _LIMITS.items()})
    stated = {_LIMITS[name][0]: value for name, value in limits.items() if value is not None}  # none: no key says so
    _join(table["robot"], "limits", stated)
    _join(table, "robot", _changed(scene.robot, original.robot, {"home": "angle"}))
    if scene.approach is None:
        table.pop("approach", None)
    else:
        _join(table, "approach", _approach(scene.approach, original.approach))
    if scene.controller is None:
        table.pop("controller", None)
    else:
        _join(table, "controller", _changed(scene.controller, original.controller, _CONTROLLER))
    known = {cargo.name: cargo for cargo in original.cargo}
    entries = {entry["name"]: entry for entry in table["cargo"]}
    _place_obstacles(table, scene.obstacles, original.obstacles)
    table["cargo"] = [_entry(item, known.get(item.name), entries.get(item.name, {})) for item in scene.cargo]
    return table


def _join(table: dict[str, Any], key: str, values: Mapping[str, Any]) -> None:
    """Write values into one of its tables; a key whose value is None is left out."""
    if values:
        joined = {**table.get(key, {}), **values}
        table[key] = {name: value for name, value in joined.items() if value is not None}


def _changed(record: Any, original: Any, names: Mapping[str, str | None]) -> dict[str, Any]:
    """What a record has otherwise than the original (all of it where there is none), as a scenario writes it."""
    pairs = {name: (getattr(record, name), getattr(original, name, None)) for name in names}
    return {name: _written(ours, names[name]) for name, (ours, theirs) in pairs.items() if not _same(ours, theirs)}


def _written(value: Any, dimension: str | None) -> Any:
    """A quantity in its SI unit, or any other value as it is; None where no limit was left."""
    if isinstance(value, tuple):
        return list(value)
    if isinstance(value, np.ndarray):
        return [_written(entry, dimension) for entry in value.tolist()]
    unit = "" if dimension is None else next(iter(DIMENSIONS[dimension].units))
    return f"{float(value)!r} {unit}" if unit and value is not None else value


def _freedom(rules: MotionRules, original: MotionRules, path: Mapping[str, Any]) -> dict[str, Any]:
    """The keys of `[path]` about how far the tray may leave it; a free yaw keeps the ends of the stated one."""
    values = _changed(rules, original, {"corridor": "length"})
    if rules.corridor is not None and (values or rules.corridor_shares != original.corridor_shares):
        shares = rules.corridor_shares
        values["corridor"] = _written(rules.corridor * np.array(shares) if shares else rules.corridor, "length")
    if rules.yaw_free != original.yaw_free and "yaw_at_points" in path:
        values["yaw"] = FREE if rules.yaw_free else None
    elif rules.yaw_free != original.yaw_free:
        given = path.get("yaw", FREE)
        ends = [0.0, 0.0] if given == FREE else [given[0], given[-1]]
        values["yaw"] = [ends[0], FREE, ends[1]] if rules.yaw_free else ends
    return values


def _approach(rules: ApproachRules, original: ApproachRules | None) -> dict[str, Any]:
    names = {"max_acceleration": "angular_acceleration", "max_jerk": "angular_jerk"}
    keys = {"max_acceleration": "acceleration", "max_jerk": "jerk"}
    limits = {keys[name]: value for name, value in _changed(rules, original, names).items()}
    values = _changed(rules, original, {"speed_scale": None, "acceleration_scale": None}) | limits
    if original is None or rules.loaded != original.loaded:
        values["tray"] = "loaded" if rules.loaded else "empty"
    start = _changed(rules, original, {"start": "angle"})
    return values | ({"from": start["start"]} if start else {})


def _entry(item: Cargo, original: Cargo | None, entry: Mapping[str, Any]) -> dict[str, Any]:
    """The keys of one object; of a new one all that its numbers say."""
    values = {"name": item.name, **({} if item.carrier else _changed(item, original, _PLACEMENT))}
    values |= {"label": item.label} if item.label != (original.label if original else "") else {}
    place = {} if item.carrier else _changed(item, original, {"position": "length"})
    values |= {"at": place["position"]} if place else {}
    container = item.container
    if original is None or container != original.container:
        sizes = [field.name for field in dataclasses.fields(container) if field.init]  # type: ignore[arg-type]
        values |= {"shape": item.shape} | {name: _written(getattr(container, name), "length") for name in sizes}
    values |= {} if item.filling is None else _filling(item.filling, original.filling if original else None)
    kept = dict(entry)
    if item.carried is not None:
        return kept | values
    if item.filling is None and original is not None and original.filling is not None:
        kept = {key: kept[key] for key in kept if key not in ("liquid", "damping", *_LIQUID)}
    if original is None or difference(item.total, original.total):
        values["mass"] = _written(item.total.mass, "mass")
        kept.pop("empty_mass", None)
    weightless = item.filling is not None and item.empty.mass == 0.0
    if not weightless and (original is None or not _same(item.total.centre, original.total.centre)):
        kept = {name: kept[name] for name in kept if not name.startswith("centre_of_mass")}
        if item.filling is None:
            values["centre_of_mass"] = _written(item.total.centre, "length")
        else:
            values["centre_of_mass_height"] = _written(float(item.total.centre[2]), "length")
    if item.tolerance != (original.tolerance if original else None):
        values["tolerance"] = _tolerance(item, item.tolerance or Tolerance())
    return kept | values


_SIZES = {"box": ("size",), "cylinder": ("radius", "height"), "sphere": ("radius",), "capsule": ("radius", "height")}
"""Shape of an obstacle -> the keys of its sizes; the sides of a box are one list."""


def _place_obstacles(table: dict[str, Any], obstacles: tuple[Obstacle, ...], original: tuple[Obstacle, ...]) -> None:
    """Write the entries of the obstacles into a table; one that is as it was keeps its own."""
    known = {item.name: (item, entry) for item, entry in zip(original, table.get("obstacle", []), strict=True)}
    entries = []
    for item in obstacles:
        before, entry = known.get(item.name, (None, {}))
        if before is not None and difference(item, before) is None:
            entries.append(entry)
            continue
        sizes = [_written(size, "length") for size in item.shape.sizes]
        keys = _SIZES.get(item.shape.kind, ())
        kind = "mesh" if item.shape.kind == "hull" else item.shape.kind
        values = {"name": item.name, "shape": kind, "at": _written(item.position, "length")}
        values |= {"points": item.shape.points.tolist()} if kind == "mesh" else {}
        values |= {keys[0]: sizes} if keys == ("size",) else dict(zip(keys, sizes, strict=True))
        values |= dict(zip(("roll", "pitch", "yaw"), _written(item.rpy, "angle"), strict=True))
        entries.append(values | {"clearance": _written(item.clearance, "length")})
    table.pop("obstacle", None)
    table.update({"obstacle": entries} if entries else {})


def _filling(filling: Filling, original: Filling | None) -> dict[str, Any]:
    values = _changed(filling, original, _LIQUID)
    liquid = filling.liquid
    if original is None or liquid != original.liquid:
        own = {
            "density": _written(liquid.density, "density"),
            "kinematic_viscosity": _written(liquid.kinematic_viscosity, "kinematic_viscosity"),
            "surface_tension": _written(liquid.surface_tension, "surface_tension"),
        }
        values["liquid"] = liquid.name if LIQUIDS.get(liquid.name) == liquid else own
    damping, before = (
        None if item is None else min(item.modes.oscillators, key=lambda mode: mode.frequency).damping
        for item in (filling, original)
    )
    values |= {} if _same(damping, before) else {"damping": damping}
    swing = filling.initial_swing
    if swing != (original.initial_swing if original else None):
        parts = {"displacement": "length", "velocity": "speed"}
        values["initial_swing"] = swing and {
            name: [_written(np.array(row), unit) for row in getattr(swing, name)] for name, unit in parts.items()
        }
    line, angle = filling.contact_line, filling.contact_angle
    values |= {"contact_line": line} if line and line != (original.contact_line if original else "") else {}
    if angle is not None and not _same(angle, original.contact_angle if original else None):
        values["contact_angle"] = _written(angle, "angle")
    return values


def _tolerance(item: Cargo, tolerance: Tolerance) -> dict[str, Any]:
    values: dict[str, Any] = {"friction": tolerance.friction, "position": _written(tolerance.position, "length")}
    if item.filling is not None:
        values |= {"liquid_height": _written(tolerance.liquid_height, "length"), "damping": list(tolerance.damping)}
    values |= {"pinned": True} if tolerance.pinned else {}
    if tolerance.contact_angle:
        values["contact_angle"] = _written(tolerance.contact_angle, "angle")
    return values | ({"mass": tolerance.mass} if item.empty.mass > 0.0 else {})
