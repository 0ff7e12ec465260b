"""From what pydantic found in a scenario to sentences that name the place in the file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from nospill.core.units import as_written, listed
from nospill.scenario.cargo_entries import CARGO_TABLES, LiquidTable
from nospill.scenario.model import Scenario
from nospill.scenario.obstacle_entries import OBSTACLE_TABLES
from nospill.scenario.path_entries import PATH_TABLES
from nospill.scenario.sentences import Fault, Location, details_of, key_path, keys_of, model_of, sentence
from nospill.scenario.tolerance_entry import CargoToleranceTable


def cargo_place(index: int, entry: object) -> str:
    """How messages call the cargo entry at `index`."""
    return entry_place("cargo", index, entry)


def entry_place(key: str, index: int, entry: object) -> str:
    """How messages call the entry at `index` of `[[key]]`: by its name, or by its number (from 1) while it has none."""
    name = entry.get("name") if isinstance(entry, dict) else None
    return f"{key} {as_written(name)}" if isinstance(name, str) and name else f"{key} {index + 1}"


def faults_of(error: ValidationError, table: Mapping[str, Any], *, unknown_only: bool = False) -> list[Fault]:
    """Every error of a scenario `table`, or only its unknown keys, which come first."""
    details = [item for item in details_of(error) if item["type"] == "extra_forbidden" or not unknown_only]
    return [_fault(detail, table) for detail in details]


def _fault(detail: ErrorDetails, table: Mapping[str, Any]) -> Fault:
    location = detail["loc"]
    place, keys, model = _resolve(location, table)
    subject = key_path(keys) or place
    if not place and (keys == ("path",) or _table_model(str(keys[0]))):
        subject = f"[{subject}]"
    place = place if keys else ""
    if detail["type"] == "list_type" and location in (("cargo",), ("obstacle",)) and isinstance(detail["input"], dict):
        return place, f"{subject} is a single table; write [[{location[0]}]], with two brackets, for every one"
    if detail["type"] == "union_tag_not_found":
        key, tables = ("type", PATH_TABLES) if location[0] == "path" else ("shape", _ENTRIES[str(location[0])])
        return place, f"{subject} has no {key}; choose one of {listed([as_written(tag) for tag in tables])}"
    table_model = _table_model("path") if model in PATH_TABLES.values() else model

    def owner(key: str) -> str | None:
        # the table around it comes first: whoever writes below [tolerance.tracking] means a tolerance
        around = str(location[0])
        tables = ((name, _table_model(name)) for name in (around, *Scenario.model_fields))
        return next(
            (name for name, other in tables if other not in (None, table_model) and key in keys_of(other)), None
        )

    return place, sentence(detail, keys, model, subject=subject, owner=owner)


_ENTRIES: dict[str, Mapping[str, type[BaseModel]]] = {"cargo": CARGO_TABLES, "obstacle": OBSTACLE_TABLES}


def _resolve(location: Location, table: Mapping[str, Any]) -> tuple[str, Location, type[BaseModel] | None]:
    """Place, the keys below it without the unions' tags, and the model whose keys are allowed there."""
    head = location[0]
    if head == "cargo" and len(location) > 1 and isinstance(location[1], int):
        place = cargo_place(location[1], table["cargo"][location[1]])
        model = CARGO_TABLES.get(str(location[2])) if len(location) > 2 else None
        keys = location[3:]
        if len(keys) > 1 and keys[0] == "liquid":
            return place, ("liquid", *keys[2:]), LiquidTable
        if len(keys) > 1 and keys[0] == "tolerance":
            return place, keys, CargoToleranceTable
        return place, keys, model
    if head == "obstacle" and len(location) > 1 and isinstance(location[1], int):
        model = OBSTACLE_TABLES.get(str(location[2])) if len(location) > 2 else None
        return entry_place("obstacle", location[1], table["obstacle"][location[1]]), location[3:], model
    if head == "path":
        model = PATH_TABLES.get(str(location[1])) if len(location) > 1 else None
        keys = location[2:]
        part, *below = keys or ("",)
        inner = model_of(model, str(part)) if model is not None and below else None
        if inner is not None:
            return f"[path.{part}]", tuple(below), inner
        return ("[path]", keys, model) if len(location) > 1 else ("", location, Scenario)
    if len(location) == 1:
        return "", location, Scenario
    model = _table_model(str(head))
    if model is not None and len(location) > 2:
        inner = model_of(model, str(location[1]))
        if inner is not None:
            return f"[{head}.{location[1]}]", location[2:], inner
    return f"[{head}]", location[1:], model


def _table_model(key: str) -> type[BaseModel] | None:
    return model_of(Scenario, key)
