"""Whether a table makes a scene, and if not: every fault with the place where it was typed.

The sentences are those of the reader of scenario files; only their place is found here.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from nospill.core.units import as_written
from nospill.errors import ModelError, ScenarioError
from nospill.scenario import scene_from_table
from nospill.scenario.cargo_entries import CARGO_TABLES
from nospill.scenario.carrier_reader import check_carrier, seated
from nospill.scenario.layout import layout_faults
from nospill.scenario.messages import cargo_place, entry_place, faults_of
from nospill.scenario.model import Scenario
from nospill.scenario.reader import read_object
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene
from nospill.studio.draft import Key

_MORE = re.compile(r" \(and \d+ more mistakes?( in [^()]*)?\)$")
_PLACE = re.compile(
    r'(?P<place>\[[a-z_.]+\]|(?:cargo|obstacle) (?:\d+|"(?:[^"\\]|\\.)*"))(?:: )(?P<text>.*)', re.DOTALL
)
_LABEL = "studio"
_MAIN_KEY = {"robot": "model", "path": "type", "tray": "mass"}
"""Where a fault of a whole table is shown."""


@dataclass(frozen=True, slots=True)
class Fault:
    """What is wrong, and where it was typed.

    Attributes:
        key: place of the value in the table, or of the table it belongs to.
        text: sentence that starts with the key.
        where: "[tray]", 'cargo "c2"', 'obstacle "column"' or "".
    """

    key: Key
    text: str
    where: str

    @property
    def sentence(self) -> str:
        """Place and text, to be read without the field beside it."""
        return f"{self.where}: {self.text}" if self.where else self.text


@dataclass(frozen=True, slots=True)
class Check:
    """A scene, or the faults that are in the way."""

    scene: Scene | None
    faults: tuple[Fault, ...]


def check(table: Mapping[str, Any]) -> Check:
    """Read a table like a scenario file.

    A draft names no other file: what it was opened from had them read in.
    """
    try:
        scenario = Scenario.model_validate(dict(table))
    except ValidationError as error:
        return Check(None, _refusals(error, table))
    try:
        return Check(scene_from_table(table, name=_LABEL), ())
    except (ScenarioError, ModelError) as error:
        first = _from_sentence(str(error), table)
    # the reader's sentence goes on with an example of what would do
    others = [fault for fault in _cargo_faults(scenario, table) if not first.sentence.startswith(fault.sentence)]
    return Check(None, (first, *others))


def _refusals(error: ValidationError, table: Mapping[str, Any]) -> tuple[Fault, ...]:
    """What pydantic found; its locations tell the place, except for the tags of unions in them."""
    details = sorted(error.errors(include_url=False), key=lambda detail: detail["type"] != "extra_forbidden")
    return tuple(
        Fault(_of_entry(_without_tags(detail["loc"], detail["type"]), text, detail["input"]), text, where)
        for detail, (where, text) in zip(details, faults_of(error, table), strict=True)
    )


def _without_tags(location: Key, kind: str) -> Key:
    tagged = kind.startswith("union_tag")
    if location[:1] == ("cargo",) and len(location) > 1:
        keys = location[3:]
        if len(keys) > 1 and keys[0] == "liquid":
            keys = ("liquid", *keys[2:])
        return (*location[:2], "shape") if tagged else (*location[:2], *keys)
    if location[:1] == ("obstacle",) and len(location) > 1:
        return (*location[:2], "shape") if tagged else (*location[:2], *location[3:])
    if location[:1] == ("path",):
        return ("path", "type") if tagged else ("path", *location[2:])
    return location


def _of_entry(key: Key, text: str, value: object) -> Key:
    """The place of the coordinate that a sentence about `at` names, for it has a field of its own."""
    if key[-1:] == ("at",) and isinstance(value, list):
        for index, entry in enumerate(value):
            if text.startswith(f"at {as_written(entry)} "):
                return (*key, index)
    return key


def _cargo_faults(scenario: Scenario, table: Mapping[str, Any]) -> list[Fault]:
    """The first fault of every object on its own, and every pair that overlaps; the reader stops at the first."""
    cargo: list[Cargo] = []
    known: dict[str, Cargo] = {}
    faults: list[Fault] = []
    entries = {entry.name: entry for entry in scenario.cargo}
    # carriers first: where the others stand depends on them
    order = sorted(enumerate(scenario.cargo), key=lambda pair: pair[1].carrier is not None)
    for index, entry in order:
        try:
            check_carrier(entry, entries)
            item = read_object(entry, scenario)
            if entry.carrier in known:
                item = seated(item, entry, known[entry.carrier])
        except (ScenarioError, ModelError) as error:
            where = cargo_place(index, table["cargo"][index])
            faults.append(Fault(_cargo_key(index, str(error), table), str(error), where))
        else:
            cargo.append(item)
            known.setdefault(entry.name, item)
    return faults + [_locate(where, text, table) for where, text in layout_faults(cargo, scenario.tray.build())]


def _from_sentence(line: str, table: Mapping[str, Any]) -> Fault:
    """The fault of a reader's line "studio: place: text (and 2 more mistakes)"."""
    line = _MORE.sub("", line.removeprefix(f"{_LABEL}: "))
    match = _PLACE.match(line)
    return _locate(match["place"], match["text"], table) if match else Fault((), line, "")


def _locate(where: str, text: str, table: Mapping[str, Any]) -> Fault:
    kind, _, called = where.partition(" ")
    if kind in ("cargo", "obstacle"):
        places = [entry_place(kind, index, entry) for index, entry in enumerate(table[kind])]
        index = places.index(where) if where in places else int(called) - 1
        if kind == "cargo":
            return Fault(_cargo_key(index, text, table), text, where)
        return Fault((kind, index, _first_key(text, list(table[kind][index])) or "at"), text, where)
    head = where.strip("[]").split(".")[0]
    model = Scenario.model_fields[head].annotation
    known: Sequence[str] = list(getattr(model, "model_fields", {})) + list(_mapping(table.get(head)))
    return Fault((head, _first_key(text, known) or _MAIN_KEY.get(head, "")), text, where)


def _cargo_key(index: int, text: str, table: Mapping[str, Any]) -> Key:
    known = list(CARGO_TABLES[table["cargo"][index]["shape"]].model_fields)
    return ("cargo", index, "at" if text.startswith("overlaps") else _first_key(text, known) or "name")


def _first_key(text: str, known: Sequence[str]) -> str | None:
    word = re.match(r"[a-z_]+", text)
    return word[0] if word and word[0] in known else None


def _mapping(value: object) -> Mapping[str, Any]:
    return value if isinstance(value, Mapping) else {}
