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
"""In a place: every object that has the key."""

_EXAMPLE = "for example --set motion.tilt=free or --set cargo.c1.friction=0.4"


def with_value(table: Mapping[str, Any], place: str, value: object) -> dict[str, Any]:
    """The parsed content of a scenario file with another value; the table given stays as it is.

    Args:
        table: keys and values as in the file.
        place: dotted key, as "tray.friction", "cargo.c2.mass" (by the object's name) or "cargo.*.max_slosh_height"
            (every object that has the key).
        value: as in the file.

    Raises:
        ScenarioError: the place names an object that is not on the tray, or something inside a value.
    """
    changed = copy.deepcopy(dict(table))
    first, *rest = place.split(".")
    if first != "cargo":
        _set(changed, [first, *rest], value, place)
        return changed
    if len(rest) < 2:
        raise ScenarioError(f"{place}: name the object and its key, as cargo.c1.friction")
    name, *keys = rest
    given = changed.get("cargo")
    objects = [entry for entry in given if isinstance(entry, dict)] if isinstance(given, list) else []
    meant = [entry for entry in objects if (keys[0] in entry if name == EVERY else entry.get("name") == name)]
    if not meant:
        raise ScenarioError(f"{place}: {_nobody(name, keys[0], [str(entry.get('name')) for entry in objects])}")
    for entry in meant:
        _set(entry, keys, value, place)
    return changed


def with_settings(table: Mapping[str, Any], settings: Sequence[str]) -> dict[str, Any]:
    """The table with values from text.

    Args:
        table: the parsed content of a scenario file; it stays as it is.
        settings: each a dotted key, "=" and a value as in TOML; what is no TOML value is a string, so that quotes may
            be left out.

    Raises:
        ScenarioError: as for `with_value`, or a text without a key.
    """
    changed = dict(table)
    for setting in settings:
        key, equals, value = setting.partition("=")
        if not equals or not all(part.strip() for part in key.split(".")):
            raise ScenarioError(f"--set {as_written(setting)} is not KEY=VALUE; write a dotted key, {_EXAMPLE}")
        try:
            changed = with_value(changed, ".".join(part.strip() for part in key.split(".")), _value(value.strip()))
        except ScenarioError as error:
            raise ScenarioError(f"--set {error}") from None
    return changed


def _set(table: dict[str, Any], keys: Sequence[str], value: object, place: str) -> None:
    for key in keys[:-1]:
        inner = table.setdefault(key, {})
        if not isinstance(inner, dict):
            raise ScenarioError(f"{place}: {key} is the value {as_written(inner)}, no table; replace all of it")
        table = inner
    table[keys[-1]] = value


def _nobody(name: str, key: str, names: list[str]) -> str:
    if name == EVERY:
        return f"no object on the tray has the key {key}; name one ({', '.join(names)})"
    near = nearest(name, names)
    hint = f'; did you mean "{near}"?' if near else f"; there are {listed(names, last='and')}" if names else ""
    return f'no object on the tray is called "{name}"{hint}'


def _value(text: str) -> object:
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (tomllib.TOMLDecodeError, ValueError, RecursionError):
        return text
    value = parsed["value"]
    # a line break would smuggle in other keys; dates are no values of a scenario
    return text if len(parsed) > 1 or isinstance(value, datetime.date | datetime.time) else value
