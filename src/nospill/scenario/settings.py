"""Other values for keys of a scenario: by place in its table, and as text from the command line."""

from __future__ import annotations

import copy
import datetime
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

from nospill.core.suggestions import nearest
from nospill.core.units import as_written, listed
from nospill.errors import ScenarioError

EVERY = "*"
"""In a place: every entry of a list that has the key after it."""

Place = str | tuple[str | int, ...]
"""Of a value: "tray.friction", or its parts, ("cargo", 0, "friction"), of which a whole number counts in a list."""

_LISTS = frozenset({"cargo", "obstacle", "path.via", "path.region"})
"""Keys that hold a list of entries with names."""

_NO_KEY = "name the object and its key, as cargo.c1.friction"
_EXAMPLE = "for example --set motion.tilt=free or --set cargo.c1.friction=0.4"


def changed_table(table: Mapping[str, Any], changes: Mapping[Any, object]) -> dict[str, Any]:
    """The parsed content of a scenario file with other values; the table given stays as it is.

    Args:
        table: keys and values as in the file.
        changes: place (`Place`) -> value as in the file, or None: the key takes its default, the entry of a list is
            removed. An entry of a list goes by its name, else by its number from 0: "cargo.c2.mass", "cargo.1.mass";
            "cargo.*.max_slosh_height" is every object that states the key, or every object where
            none does. A table under a new name is a new entry.

    Raises:
        ScenarioError: a place names an entry that is not there, or something inside a value.
    """
    return present(with_places(table, changes))


def with_places(table: Mapping[str, Any], changes: Mapping[Any, object]) -> dict[str, Any]:
    """`changed_table` with None where something is removed."""
    changed = copy.deepcopy(dict(table))
    for place, value in changes.items():
        keys = tuple(place.split(".")) if isinstance(place, str) else tuple(place)
        shown = ".".join(map(str, keys))
        if not all(str(key).strip() for key in keys) or not keys:
            raise ScenarioError(f"{as_written(shown)} is no place; write a dotted key, as in cargo.c1.friction")
        _put(changed, keys, copy.deepcopy(value), shown)
    return changed


def present(value: Any) -> Any:
    """A deep copy of tables and lists without what is None."""
    if isinstance(value, Mapping):
        return {key: present(entry) for key, entry in value.items() if entry is not None}
    if isinstance(value, list | tuple):
        return [present(entry) for entry in value if entry is not None]
    return value


def stated_value(table: Mapping[str, Any], key: str) -> Any:
    """What a scenario states under a dotted key; of every object, the first one's.

    Raises:
        ScenarioError: it states nothing there.
    """
    found: Any = table
    for part in key.split("."):
        above = found
        if isinstance(found, list):
            entries = [item for item in found if isinstance(item, dict)]
            rest = key.rpartition(".")[2]
            meant = (
                [item for item in entries if rest in item]
                if part == EVERY
                else [item for number, item in enumerate(entries) if part in (item.get("name"), str(number))]
            )
            found = meant[0] if meant else None
        else:
            found = found.get(part) if isinstance(found, Mapping) else None
        if found is None:
            near = nearest(part, map(str, above)) if isinstance(above, Mapping) else None
            hint = f'did you mean "{near}"? Else ' if near else ""
            raise ScenarioError(
                f"{key}: the scenario states no value there to start from; {hint}give two values to search between"
            )
    return found


def with_settings(table: Mapping[str, Any], settings: Sequence[str]) -> dict[str, Any]:
    """The table with values from text.

    Args:
        table: the parsed content of a scenario file; it stays as it is.
        settings: each a dotted key, "=" and a value as in TOML; what is no TOML value is a string, so that quotes may
            be left out.

    Raises:
        ScenarioError: as for `changed_table`, or a text without a key.
    """
    changed = dict(table)
    for setting in settings:
        key, equals, value = setting.partition("=")
        if not equals or not all(part.strip() for part in key.split(".")):
            raise ScenarioError(f"--set {as_written(setting)} is not KEY=VALUE; write a dotted key, {_EXAMPLE}")
        place = tuple(part.strip() for part in key.split("."))
        try:
            changed = with_places(changed, {place: value_from_text(value.strip())})
        except ScenarioError as error:
            raise ScenarioError(f"--set {error}") from None
    return changed


def _put(table: dict[str, Any], keys: Sequence[str | int], value: object, place: str, above: str = "") -> None:
    """Put a value into a table, making the tables and lists on its way."""
    key, *rest = keys
    name = str(key)
    here = f"{above}.{name}" if above else name
    if not rest:
        table[name] = value
        return
    if table.get(name) is None:
        table[name] = [] if here in _LISTS else {}
    inner = table[name]
    if isinstance(inner, dict):
        _put(inner, rest, value, place, here)
    elif isinstance(inner, list):
        _put_into_list(inner, rest, value, place, here)
    else:
        raise ScenarioError(f"{place}: {name} is the value {as_written(inner)}, no table; replace all of it")


def _put_into_list(entries: list[Any], keys: Sequence[str | int], value: object, place: str, above: str) -> None:
    first, *rest = keys
    named = {str(entry["name"]): index for index, entry in enumerate(entries) if _is_named(entry)}
    if first == EVERY and not rest and value is None:
        raise ScenarioError(f'{place}: "{above}": None leaves out all of them, "{above}.NAME": None one')
    if first == EVERY and rest:
        tables = [entry for entry in entries if isinstance(entry, dict)]
        # where nobody states it, everybody is meant, and the reader names those that have no such key
        meant = [entry for entry in tables if rest[0] in entry] or tables
        if not meant:
            raise ScenarioError(f"{place}: {_nobody(EVERY, str(rest[0]), list(named), above)}")
        for entry in meant:
            _put(entry, rest, value, place, f"{above}.{first}")
        return
    index = _index(entries, named, first)
    if index is None and not rest and isinstance(value, dict) and above in _LISTS and not str(first).isdecimal():
        entries.append(_entry_by_name(value, str(first), place))
    elif index is None:
        if entries and not any(isinstance(entry, dict) for entry in entries):
            last = len(entries) - 1
            raise ScenarioError(f"{place}: {above} has values 0 to {last}, and no {first}; give one of those numbers")
        wants_key = not rest and value is not None
        raise ScenarioError(f"{place}: {_NO_KEY if wants_key else _nobody(str(first), '', list(named), above)}")
    elif not rest:
        entries[index] = _replace(entries[index], value, place)
    elif isinstance(entries[index], dict):
        _put(entries[index], rest, value, place, f"{above}.{first}")
    else:
        raise ScenarioError(
            f"{place}: entry {first} of {above} is the value {as_written(entries[index])}, no table; replace all of it"
        )


def _replace(entry: object, value: object, place: str) -> object:
    """What stands in the place of an entry: a table under its name, nothing, or another value in a list of values."""
    if not isinstance(entry, dict) or value is None:
        return value
    if not isinstance(value, dict):
        raise ScenarioError(f"{place}: {_NO_KEY}")
    return _entry_by_name(value, entry["name"], place) if _is_named(entry) else value


def _is_named(entry: object) -> bool:
    return isinstance(entry, dict) and isinstance(entry.get("name"), str)


def _entry_by_name(entry: Any, name: str, place: str) -> dict[str, Any]:
    """An entry under the name by which its place calls it."""
    given = entry.get("name", name)
    if given != name:
        raise ScenarioError(f"{place}: its name is given as {as_written(given)}; give {as_written(name)} there too")
    return {"name": name, **entry}


def _index(entries: Sequence[Any], named: Mapping[str, int], key: str | int) -> int | None:
    """Where the entry of a list is: by its name, else by its number."""
    if isinstance(key, str) and key in named:
        return named[key]
    if isinstance(key, int) or key.isdecimal():
        index = int(key)
        return index if 0 <= index < len(entries) else None
    return None


def _nobody(name: str, key: str, names: list[str], above: str) -> str:
    where = {"cargo": "object on the tray", "obstacle": "obstacle"}.get(above, f"entry of {above}")
    if name == EVERY:
        return f"there is no {where} to have the key {key}"
    near = nearest(name, names)
    hint = f'; did you mean "{near}"?' if near else f"; there are {listed(names, last='and')}" if names else ""
    return f'no {where} is called "{name}"{hint}'


def value_from_text(text: str) -> object:
    """A value as in TOML; what is none is a string."""
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (tomllib.TOMLDecodeError, ValueError, RecursionError):
        return text
    value = parsed["value"]
    # a line break would smuggle in other keys; dates are no values of a scenario
    return text if len(parsed) > 1 or isinstance(value, datetime.date | datetime.time) else value
