"""From a scenario with `[[leg]]` tables to a Cycle, each of whose legs is an ordinary scene."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from nospill.core.suggestions import nearest
from nospill.core.toml_text import toml_text
from nospill.core.units import as_written, format_quantity, listed
from nospill.errors import ScenarioError
from nospill.scenario.fields import FREE, LONGEST_NAME
from nospill.scenario.leg_entry import EVERYTHING, MOST_LEGS, SHORTEST, LegTable
from nospill.scenario.loading import ScenarioSource, table_of
from nospill.scenario.messages import entry_place
from nospill.scenario.scenes import scene_from_table
from nospill.scenario.sentences import details_of, key_path, report, sentence
from nospill.scenario.settings import changed_table
from nospill.scenario.tables import plain
from nospill.scene.cycle import Cycle, CycleLeg
from nospill.scene.scene import Scene

SAME_PLACE, SAME_YAW = 1e-3, math.radians(0.5)
"""m and rad: how far a leg may begin from where the one before it ends."""

_ENDS = {"line": ("start", "end"), "arc": ("start", "end"), "free": ("start", "goal")}
"""Type of a path -> its keys that may be left out, on all legs but the first and on the last one."""

_NOT_IN_A_CYCLE = {
    ("path",): "every leg has its own: write path = {...} under [[leg]]",
    ("approach",): "a cycle begins where it ends, and nothing comes before it",
    ("initial_state",): "a cycle begins at rest",
    ("motion", "hold_before"): "how long the arm stands is the dwell of a leg",
    ("motion", "hold_after"): "how long the arm stands is the dwell of a leg",
    ("motion", "speed_range"): "a swing that goes on into the next leg does not slow down with the motion",
    ("motion", "stop"): "every leg ends at the end of its path",
}
"""Key -> why it means nothing here."""


def load_cycle(scenario: ScenarioSource, *, settings: Sequence[str] = ()) -> Cycle:
    """Read a scenario with `[[leg]]` tables.

    Args:
        scenario: a TOML file, the folder of a planned cycle, a bundled example by its name, or a dictionary with the
            keys of such a file.
        settings: values to replace, each as "motion.tilt=free" or "leg.out.dwell=0.5"; see `with_settings`.

    Raises:
        ScenarioError: it has no legs, or describes no possible cycle; one line that names file, leg, key and value.
    """
    found = table_of(scenario, settings)
    if not found.table.get("leg"):
        raise report(found.label, [("", "has no [[leg]] tables: it is one motion, as load and plan take it")])
    return cycle_from_table(found.table, name=found.name, folder=found.folder, label=found.label)


def cycle_from_table(table: Mapping[str, Any], *, name: str, folder: Path = Path(), label: str) -> Cycle:
    """Build a cycle from the parsed content of a scenario file.

    Args:
        table: keys and values as in the file; it is not changed.
        name: of the cycle where the table has none.
        folder: where files that the table names are looked up.
        label: what messages call it.

    Raises:
        ScenarioError: as `load_cycle`.
    """
    legs = _leg_tables(table, label)
    _refuse_what_means_nothing(table, legs, label)
    own = str(table.get("name", name))
    known = {str(entry.get("name")): entry for entry in plain(table.get("cargo", []))}
    first_named = _first_named(legs)
    standing = [entry for key, entry in known.items() if first_named.get(key) != "load"]
    made: list[CycleLeg] = []
    for index, leg in enumerate(legs):
        place = entry_place("leg", index, {"name": leg.name})
        _refuse_free_yaw(leg, f"{label}: {place}")
        path = _closed(dict(leg.path), made, last=index == len(legs) - 1, where=f"{label}: {place}")
        rules = {**table.get("motion", {}), **leg.motion}
        dwell = None if leg.dwell == SHORTEST else float(leg.dwell)
        scene = scene_from_table(
            {
                **{key: value for key, value in table.items() if key not in ("leg", "description")},
                "name": f"{own}-{leg.name}"[:LONGEST_NAME],
                "path": path,
                "motion": {**rules, **({"hold_after": dwell} if dwell else {})},
                "cargo": standing,
            },
            name=name,
            folder=folder,
            label=f"{label}: {place}",
        )
        if made:
            _require_same_place(made[-1], leg.name, scene, f"{label}: {place}")
        standing = scene.source.get("cargo", [])
        known |= {entry["name"]: entry for entry in standing}
        _require_names(leg, [entry["name"] for entry in standing], known, made, f"{label}: {place}")
        off = [entry["name"] for entry in standing] if leg.unload == [EVERYTHING] else leg.unload
        standing = [entry for entry in standing if entry["name"] not in off] + [known[name] for name in leg.load]
        made.append(CycleLeg(leg.name, scene, dwell, tuple(off), tuple(leg.load)))
    _require_same_place(made[-1], made[0].name, made[0].scene, label)
    began = {item.name for item in made[0].scene.cargo}
    left = [entry["name"] for entry in standing if entry["name"] not in began]
    if left:
        raise report(
            label,
            [
                (
                    "",
                    f"{listed(left, last='and')} would be on the tray when the cycle begins again, and is "
                    "not when it begins; unload it on the last leg",
                )
            ],
        )
    return Cycle(own, tuple(made), _text(table, own, legs, made, known))


def changed_cycle(cycle: Cycle, changes: Mapping[str, object]) -> Cycle:
    """The cycle with other values, by dotted keys as in `changed_table`; raises ScenarioError."""
    try:
        table = changed_table(tomllib.loads(cycle.text), {place: plain(value) for place, value in changes.items()})
    except ScenarioError as error:
        raise ScenarioError(f"{cycle.name}: {error}") from None
    return cycle_from_table(table, name=cycle.name, label=cycle.name)


def with_dwells(cycle: Cycle, dwells: Sequence[float]) -> Cycle:
    """The cycle with the dwells that were found, s, in the place of words."""
    table = tomllib.loads(cycle.text)
    for entry, dwell in zip(table["leg"], dwells, strict=True):
        entry["dwell"] = dwell
    return cycle_from_table(table, name=cycle.name, label=cycle.name)


def _leg_tables(table: Mapping[str, Any], label: str) -> list[LegTable]:
    given = plain(table["leg"])
    if not isinstance(given, list) or not all(isinstance(entry, dict) for entry in given):
        raise report(label, [("", "leg is a single table or value; write [[leg]], with two brackets, for every one")])
    if not 2 <= len(given) <= MOST_LEGS:
        raise report(label, [("", f"{len(given)} [[leg]] tables; a cycle has 2 to {MOST_LEGS}, and comes back")])
    legs: list[LegTable] = []
    for index, entry in enumerate(given):
        place = entry_place("leg", index, entry)
        try:
            legs.append(LegTable.model_validate(entry))
        except ValidationError as error:
            faults = [
                (place, sentence(item, item["loc"], LegTable, subject=key_path(item["loc"])))
                for item in details_of(error)
            ]
            raise report(label, faults) from None
        if legs[-1].name in [leg.name for leg in legs[:-1]]:
            raise report(label, [(f"leg {index + 1}", f"name {as_written(legs[-1].name)} is already taken")])
    return legs


def _refuse_what_means_nothing(table: Mapping[str, Any], legs: Sequence[LegTable], label: str) -> None:
    for (head, *below), why in _NOT_IN_A_CYCLE.items():
        tables = [("", table), *((f"leg {as_written(leg.name)}", {"motion": leg.motion}) for leg in legs if below)]
        for place, one in tables:
            value = one.get(head)
            if (value is not None) if not below else (isinstance(value, Mapping) and below[0] in value):
                raise report(label, [(place, f"{'.'.join((head, *below))} in a cycle: {why}; leave it out")])
    robot = table.get("robot")
    if isinstance(robot, Mapping) and robot.get("base_yaw") == FREE:
        raise report(label, [("[robot]", 'base_yaw = "free" in a cycle: the base does not move; state an angle')])
    for entry in plain(table.get("cargo", [])):
        if isinstance(entry, Mapping) and "initial_swing" in entry:
            place = f"cargo {as_written(entry.get('name'))}"
            raise report(label, [(place, "initial_swing in a cycle: its first leg begins at rest; leave it out")])


def _refuse_free_yaw(leg: LegTable, where: str) -> None:
    if leg.path.get("type") != "free":
        return
    for end in ("start", "goal"):
        place = leg.path.get(end)
        if isinstance(place, Mapping) and place.get("yaw") == FREE:
            raise ScenarioError(
                f'{where}: path.{end}.yaw = "free" in a cycle: the place between two legs is known before they are '
                "planned; state an angle"
            )


def _first_named(legs: Sequence[LegTable]) -> dict[str, str]:
    """By object, whether it is taken off or put on first."""
    found: dict[str, str] = {}
    for leg in legs:
        for key, names in (("unload", leg.unload), ("load", leg.load)):
            for name in names:
                found.setdefault(name, key)
    return found


def _require_names(
    leg: LegTable, standing: Sequence[str], known: Mapping[str, object], before: Sequence[CycleLeg], where: str
) -> None:
    """Refuse to take off what is not on the tray, and to put on what is."""
    names = [] if leg.unload == [EVERYTHING] else leg.unload
    for key, given in (("unload", names), ("load", leg.load)):
        for index, name in enumerate(given):
            if name not in known:
                near = nearest(name, list(known))
                hint = f'; did you mean "{near}"?' if near else f"; there are {listed(list(known), last='and')}"
                raise ScenarioError(f"{where}: {key}: there is no object {as_written(name)}{hint}")
            if name in given[:index]:
                raise ScenarioError(f"{where}: {key} names {as_written(name)} twice")
    for name in names:
        if name not in standing:
            earlier = next((item.name for item in reversed(before) if name in item.unloaded), None)
            why = f"; leg {as_written(earlier)} unloads it" if earlier else ""
            raise ScenarioError(f"{where}: unload: {as_written(name)} is not on the tray then{why}")
    left = set(standing) - set(standing if leg.unload == [EVERYTHING] else names)
    for name in leg.load:
        if name in left:
            raise ScenarioError(f"{where}: load: {as_written(name)} is on the tray already; unload it before")


def _closed(path: dict[str, Any], before: Sequence[CycleLeg], *, last: bool, where: str) -> dict[str, Any]:
    """A path with the ends that were left out: where the leg before ends, where the first leg begins."""
    start, end = _ENDS.get(str(path.get("type")), ("start", "end"))
    known = str(path.get("type")) in _ENDS
    missing = [key for key, wanted in ((start, bool(before)), (end, last)) if known and wanted and key not in path]
    if not missing or not before:
        return path
    ends = {start: before[-1].scene.path.at([1.0])[0], end: before[0].scene.path.at([0.0])[0]}
    for key in missing:
        x, y, z, yaw = ends[key].tolist()
        path[key] = {"position": [x, y, z], "yaw": yaw} if path["type"] == "free" else [x, y, z]
    if path["type"] != "free" and "yaw" not in path:
        began = float(ends[start][3])
        turned = math.remainder(float(ends[end][3]) - began, math.tau) if end in missing else 0.0
        path["yaw"] = [began, began + turned]
    return path


def _as_stated(stated: Mapping[str, Any], closed: Mapping[str, Any]) -> dict[str, Any]:
    """A path as it was read in, without the ends that were left out: they follow where another leg is changed."""
    filled = {*_ENDS.get(str(closed.get("type")), ()), "yaw"}
    return {key: value for key, value in closed.items() if key in stated or key not in filled}


def _require_same_place(before: CycleLeg, name: str, scene: Scene, where: str) -> None:
    """Refuse a leg that begins elsewhere than the one before it ends."""
    ends, begins = before.scene.path.at([1.0])[0], scene.path.at([0.0])[0]
    apart = float(np.linalg.norm(ends[:3] - begins[:3]))
    turn = abs(math.remainder(float(ends[3] - begins[3]), math.tau))
    if apart > SAME_PLACE or turn > SAME_YAW:
        far, angle = format_quantity(apart, "length", digits=3), format_quantity(turn, "angle", digits=3)
        raise ScenarioError(
            f"{where}: leg {as_written(name)} begins {far} and {angle} from where leg {as_written(before.name)} ends; "
            "each leg begins where the one before it ends, and the first where the last does"
        )


def _text(
    table: Mapping[str, Any],
    name: str,
    legs: Sequence[LegTable],
    made: Sequence[CycleLeg],
    known: Mapping[str, Mapping[str, Any]],
) -> str:
    """The cycle as TOML that needs no other file: what each leg's scene has read in, in the place of names of files."""
    sources = [leg.scene.source for leg in made]
    entries = {entry["name"]: entry for source in reversed(sources) for entry in source.get("cargo", [])}
    single = [key for key, entry in known.items() if "array" not in entry]  # its members are known one by one
    content = {
        **plain({key: value for key, value in table.items() if key not in ("leg", "cargo")}),
        "name": name,
        "robot": sources[0]["robot"],
        **({"obstacle": sources[0]["obstacle"]} if "obstacle" in sources[0] else {}),
        "cargo": [entries.get(key, known[key]) for key in single],
        "leg": [
            {**plain(entry.model_dump(exclude_unset=True)), "path": _as_stated(entry.path, source["path"])}
            for entry, source in zip(legs, sources, strict=True)
        ],
    }
    return toml_text(content)
