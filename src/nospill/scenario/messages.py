"""From what pydantic found to sentences that name the place in the file, the value and what is allowed."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from nospill.core.suggestions import nearest
from nospill.core.units import as_written, listed
from nospill.errors import Reason, ScenarioError
from nospill.scenario.cargo_entries import CARGO_TABLES, LiquidTable
from nospill.scenario.fields import SENTENCE
from nospill.scenario.model import Scenario
from nospill.scenario.obstacle_entries import OBSTACLE_TABLES
from nospill.scenario.other_names import meant
from nospill.scenario.path_entries import PATH_TABLES
from nospill.scenario.tolerance_entry import ToleranceTable

Fault = tuple[str, str]
"""Place in the file ("[tray]", 'cargo "c2"' or "" for the top level), and what is wrong there."""

Location = tuple[int | str, ...]
"""Where pydantic found an error: keys, indices and, behind a union, the tag of its member."""


def report(label: str, faults: Sequence[Fault], reason: Reason | None = None) -> ScenarioError:
    """The error for a scenario called `label` (its file as the user named it): the first fault, and how many more.

    With a reason, which is the first fault's, the message names the smallest change that helps.
    """
    place, text = faults[0]
    if reason is not None and reason.changes:
        text += f", for example {reason.changes[0].text}"
    line = ": ".join(part for part in (label, place, text) if part) + _more(faults[1:])
    return ScenarioError(" ".join(line.splitlines()), reason)


def _more(others: Sequence[Fault]) -> str:
    """How many more mistakes there are, and where."""
    if not others:
        return ""
    where = list(dict.fromkeys(place for place, _ in others if place))
    count = f"{len(others)} more mistake{'s' if len(others) > 1 else ''}"
    return f" (and {count} in {listed(where, last='and')})" if where else f" (and {count})"


def cargo_place(index: int, entry: object) -> str:
    """How messages call the cargo entry at `index`."""
    return entry_place("cargo", index, entry)


def entry_place(key: str, index: int, entry: object) -> str:
    """How messages call the entry at `index` of `[[key]]`: by its name, or by its number (from 1) while it has none."""
    name = entry.get("name") if isinstance(entry, dict) else None
    return f"{key} {as_written(name)}" if isinstance(name, str) and name else f"{key} {index + 1}"


def faults_of(error: ValidationError, table: Mapping[str, Any], *, unknown_only: bool = False) -> list[Fault]:
    """Every error of a scenario `table`; unknown keys first: a misspelt key is also missing under its right name."""
    details = sorted(error.errors(include_url=False), key=lambda detail: detail["type"] != "extra_forbidden")
    details = [detail for detail in details if detail["type"] == "extra_forbidden" or not unknown_only]
    return [_fault(detail["type"], detail["loc"], detail["input"], detail.get("ctx", {}), table) for detail in details]


def _fault(kind: str, location: Location, value: object, context: Mapping[str, Any], table: Mapping[str, Any]) -> Fault:
    place, keys, model = _resolve(location, table)
    subject = _key_path(keys) or place
    if not place and (keys == ("path",) or _table_model(str(keys[0]))):
        subject = f"[{subject}]"
    place = place if keys else ""
    shown = as_written(value)
    if kind == "missing":
        return place, f"{subject} is missing: {_description(model, keys)}"
    if kind == "extra_forbidden":
        return place, _unknown_key(keys, model)
    if kind == SENTENCE:
        return place, f"{subject} {context['sentence']}"
    if kind == "list_type" and location in (("cargo",), ("obstacle",)) and isinstance(value, dict):
        return place, f"{subject} is a single table; write [[{location[0]}]], with two brackets, for every one"
    if kind in ("model_type", "model_attributes_type"):
        inner = _model_of(model, str(keys[-1])) if model is not None and keys else None
        keys_of_it = (
            f"{{ {', '.join(f'{key} = ...' for key in _fields(inner))} }}" if inner is not None else "in braces"
        )
        return place, f"{subject} is not a table but {shown}; write its keys {keys_of_it} or under their own heading"
    if kind in _SENTENCES:
        return place, f"{subject} {_SENTENCES[kind](shown, {**context, 'head': location[0]})}"
    return place, f"{subject} {shown} is not accepted here ({kind})"


def _one_of(choices: str) -> str:
    """`'a', 'b' or 'c'` as pydantic lists them, in the quotes of TOML."""
    return choices.replace("'", '"')


def _not_one_of(shown: str, choices: str) -> str:
    expected = _one_of(choices)
    near = nearest(shown, re.findall(r'"[^"]*"', expected), likeness=0.7)
    return f"{shown} is not one of {expected}" + (f"; did you mean {near}?" if near else "")


def _entries(context: Mapping[str, Any]) -> str:
    least, given = context["min_length"], context["actual_length"]
    needed = "1 is needed" if least == 1 else f"{least} are needed"
    return f"has {given or 'no'} {'entry' if given == 1 else 'entries'}; at least {needed}"


def _too_many(context: Mapping[str, Any]) -> str:
    return f"has more than {context['max_length']} entries; at most {context['max_length']} are planned for"


def _tag(shown: str, context: Mapping[str, Any]) -> str:
    key, choices = _choices(context)
    near = nearest(str(context["tag"]), choices)
    hint = f'; did you mean "{near}"?' if near else ""
    expected = listed([as_written(choice) for choice in choices])
    return f"has the unknown {key} {as_written(context['tag'])}; choose one of {expected}{hint}"


def _no_tag(shown: str, context: Mapping[str, Any]) -> str:
    key, choices = _choices(context)
    return f"has no {key}; choose one of {listed([as_written(choice) for choice in choices])}"


def _choices(context: Mapping[str, Any]) -> tuple[str, list[str]]:
    """The key that tells the members of a union apart, and its values."""
    key = context["discriminator"].strip("'")
    return key, list(_UNIONS[str(context["head"])])


_UNIONS: dict[str, Mapping[str, type[BaseModel]]] = {
    "cargo": CARGO_TABLES,
    "obstacle": OBSTACLE_TABLES,
    "path": PATH_TABLES,
}
"""Key at the top level -> tag of each member of its union and the member's keys."""

_SENTENCES: dict[str, Callable[[str, Mapping[str, Any]], str]] = {
    "literal_error": lambda shown, context: _not_one_of(shown, context["expected"]),
    "string_type": lambda shown, context: f"{shown} is not text; put it in quotes",
    "bool_type": lambda shown, context: f"{shown} is neither true nor false; write one of them without quotes",
    "int_type": lambda shown, context: f"{shown} is not a whole number; write one without quotes or decimal point",
    "greater_than_equal": lambda shown, context: f"{shown} is out of range: it must be at least {context['ge']}",
    "less_than_equal": lambda shown, context: f"{shown} is out of range: it must be at most {context['le']}",
    "dict_type": lambda shown, context: f"{shown} is not a table; write {{ name = value }}",
    "list_type": lambda shown, context: f"{shown} is not a list; put the values in brackets",
    "too_short": lambda shown, context: _entries(context),
    "too_long": lambda shown, context: _too_many(context),
    "union_tag_invalid": _tag,
    "union_tag_not_found": _no_tag,
}
"""Pydantic's error type -> what follows the key in the message."""


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
            return place, keys, ToleranceTable
        return place, keys, model
    if head == "obstacle" and len(location) > 1 and isinstance(location[1], int):
        model = OBSTACLE_TABLES.get(str(location[2])) if len(location) > 2 else None
        return entry_place("obstacle", location[1], table["obstacle"][location[1]]), location[3:], model
    if head == "path":
        model = PATH_TABLES.get(str(location[1])) if len(location) > 1 else None
        keys = location[2:]
        part, *below = keys or ("",)
        inner = _model_of(model, str(part)) if model is not None and below else None
        if inner is not None:
            return f"[path.{part}]", tuple(below), inner
        return ("[path]", keys, model) if len(location) > 1 else ("", location, Scenario)
    if len(location) == 1:
        return "", location, Scenario
    model = _table_model(str(head))
    if model is not None and len(location) > 2:
        inner = _model_of(model, str(location[1]))
        if inner is not None:
            return f"[{head}.{location[1]}]", location[2:], inner
    return f"[{head}]", location[1:], model


def _table_model(key: str) -> type[BaseModel] | None:
    return _model_of(Scenario, key)


def _model_of(model: type[BaseModel], key: str) -> type[BaseModel] | None:
    annotation = model.model_fields[key].annotation if key in model.model_fields else None
    # an optional table is a union of it and None
    choices = get_args(annotation) or (annotation,)
    return next((item for item in choices if isinstance(item, type) and issubclass(item, BaseModel)), None)


def _fields(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """The keys of a table as they stand in the file."""
    return {info.alias or name: info for name, info in model.model_fields.items()}


def _key_path(keys: Location) -> str:
    text = ""
    for key in keys:
        text += f" entry {key + 1}" if isinstance(key, int) else f".{key}" if text else key
    return text


def _description(model: type[BaseModel] | None, keys: Location) -> str:
    field = None if model is None else _fields(model).get(str(keys[-1]))
    return (field.description if field else None) or "it has to be given"


def _unknown_key(keys: Location, model: type[BaseModel] | None) -> str:
    key = str(keys[-1])
    allowed = list(_fields(model)) if model else []
    text = f"unknown key {as_written(key)}" + (f" in {_key_path(keys[:-1])}" if len(keys) > 1 else "")
    other = meant(key, allowed)
    if other:
        return f"{text}; {other}"
    near = nearest(key, allowed, likeness=0.7)
    if near:
        return f'{text}; did you mean "{near}"?'
    here = _table_model("path") if model in PATH_TABLES.values() else model
    owner = next((name for name in Scenario.model_fields if _owns(name, key) and _table_model(name) is not here), None)
    hint = f"; it belongs to [{owner}]" if owner else ""
    return f"{text}{hint}; allowed here: {', '.join(allowed)}"


def _owns(name: str, key: str) -> bool:
    model = _table_model(name)
    return model is not None and key in _fields(model)
