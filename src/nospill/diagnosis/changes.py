"""A suggested change in words, and made: from the key's place and value to a changed scenario."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from nospill.errors import Change
from nospill.scenario import scene_from_table
from nospill.scenario.settings import with_value
from nospill.scene.scene import Scene


def with_change(scene: Scene, change: Change) -> Scene:
    """The scene of the changed scenario.

    Raises:
        ScenarioError: there is no such place, or the changed scenario describes no possible task.
    """
    return scene_from_table(changed_table(scene.source, change), name=scene.name)


def changed_table(table: Mapping[str, Any], change: Change) -> dict[str, Any]:
    """The parsed content of a scenario file with a change made; the table given stays as it is.

    A `path_jerk_limit` takes the place of a `max_jerk`.

    Args:
        table: keys and values as in the file.
        change: as an error suggests it.

    Raises:
        ScenarioError: the change names an object that is not on the tray.
    """
    changed = with_value(table, change.place, change.value)
    if change.place == "motion.path_jerk_limit":
        changed["motion"].pop("max_jerk", None)  # in the place of which it stands
    return changed


def advice(changes: Sequence[Change], otherwise: str) -> str:
    """The last sentence of a message: the changes that were found, or what to try where none was."""
    if not changes:
        return otherwise
    return "Smallest single change found: " + "; or ".join(change.text for change in changes[:3]) + "."
