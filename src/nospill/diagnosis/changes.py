"""A suggested change in words, and made: from the key's place and value to a changed scenario."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from typing import Any

from nospill.errors import Change, ScenarioError, Setting
from nospill.scenario import scene_from_table
from nospill.scene.scene import Scene

EVERY = "*"
"""In a place: every object that has the key."""


def with_change(scene: Scene, change: Change) -> Scene:
    """The scene of the changed scenario.

    Raises:
        ScenarioError: there is no such place, or the changed scenario describes no possible task.
    """
    return scene_from_table(changed_table(scene.source, change), name=scene.name)


def changed_table(table: Mapping[str, Any], change: Change) -> dict[str, Any]:
    """The parsed content of a scenario file with a change made; the table given stays as it is.

    Args:
        table: keys and values as in the file.
        change: as an error suggests it.

    Raises:
        ScenarioError: the change names an object that is not on the tray.
    """
    changed = copy.deepcopy(dict(table))
    first, *rest = change.place.split(".")
    if first != "cargo":
        _set(changed, [first, *rest], change.value)
        return changed
    name, *keys = rest
    entries = [entry for entry in changed["cargo"] if _meant(entry, name, keys[-1])]
    if not entries:
        raise ScenarioError(f'{change.place}: no object on the tray is called "{name}"')
    for entry in entries:
        _set(entry, keys, change.value)
    return changed


def _meant(entry: Mapping[str, Any], name: str, key: str) -> bool:
    return key in entry if name == EVERY else entry.get("name") == name


def _set(table: dict[str, Any], keys: Sequence[str], value: Setting) -> None:
    for key in keys[:-1]:
        table = table.setdefault(key, {})
    table[keys[-1]] = value


def advice(changes: Sequence[Change], otherwise: str) -> str:
    """The last sentence of a message: the changes that were found, or what to try where none was."""
    if not changes:
        return otherwise
    return "Smallest single change found: " + "; or ".join(change.text for change in changes[:3]) + "."
