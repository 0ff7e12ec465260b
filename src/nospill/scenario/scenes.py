"""Scenes from tables, and the tables that scenes were read from: changed, and written as TOML."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from nospill.core.toml_text import toml_text
from nospill.errors import ScenarioError
from nospill.scenario.messages import faults_of
from nospill.scenario.model import Scenario
from nospill.scenario.reader import read_scene
from nospill.scenario.sentences import report
from nospill.scenario.settings import present, with_places
from nospill.scenario.tables import plain
from nospill.scene.scene import Scene

_A_CYCLE = (
    "has [[leg]] tables: it is a cycle, for nospill plan, check, sweep and largest and for ns.load_cycle; elsewhere "
    "name the folder of one of its legs once it is planned"
)


def scene_from_table(
    table: Mapping[str, Any], *, name: str, folder: str | os.PathLike[str] = ".", label: str | None = None
) -> Scene:
    """Build a scene from the parsed content of a scenario file.

    Args:
        table: keys and values as in the file; it is not changed.
        name: the scene's name where the table has none.
        folder: where files that the table names are looked up.
        label: what messages call it; the name when left out.

    Raises:
        ScenarioError: as for `read_scenario`.
    """
    label = name if label is None else label
    if table.get("leg"):
        raise report(label, [("", _A_CYCLE)])
    return read_scene(table, label=label, name=name, folder=Path(folder), origin=StandaloneScenario)


def scenario_schema() -> dict[str, Any]:
    """JSON schema (draft 2020-12) of a scenario file: of a motion, which has a path, or of a cycle, which has legs."""
    schema = Scenario.model_json_schema()
    schema["required"] = [key for key in schema["required"] if key != "path"]
    either = [{"required": ["path"]}, {"required": ["leg"]}]
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "anyOf": either}


@dataclass(frozen=True, slots=True)
class StandaloneScenario:
    """A scenario that needs no other file: the `Origin` of a scene.

    Attributes:
        content: keys and values as in a file; never handed out.
    """

    content: dict[str, Any] = field(repr=False)

    @property
    def table(self) -> dict[str, Any]:
        """See `Origin`."""
        return present(self.content)

    def changed(self, changes: Mapping[str, object]) -> Scene:
        """See `Scene.changed`."""
        name = str(self.content["name"])
        if not isinstance(changes, Mapping):
            raise ScenarioError(
                f"{name}: changes are a dictionary of keys and values, not a value of type {type(changes).__name__}; "
                'write scene.changed({"motion.tilt": "free"})'
            )
        wrong = next((key for key in changes if not isinstance(key, str)), None)
        if wrong is not None:
            raise ScenarioError(f"{name}: key {wrong!r} is not text; write a dotted key, as in cargo.c1.friction")
        try:
            table = with_places(self.content, {place: plain(value) for place, value in changes.items()})
        except ScenarioError as error:
            raise ScenarioError(f"{name}: {error}") from None
        if any(value is None for value in changes.values()):
            _require_known_keys(table, name)
        try:
            return scene_from_table(present(table), name=name)
        except ScenarioError as error:
            hint = _whole_tables(self.content, changes)
            if not hint:
                raise
            raise ScenarioError(f"{error}; {hint}", reason=error.reason) from None

    def text(self) -> str:
        """See `Origin`."""
        # the text of a URDF is for people to read too; line ends that would not survive it (CR LF) stay escaped
        return toml_text(self.content)


def _whole_tables(content: Mapping[str, Any], changes: Mapping[str, object]) -> str:
    """That a table of fewer keys takes the place of the one before as a whole; empty where none does."""
    for place, value in changes.items():
        before = content.get(place)
        if isinstance(value, Mapping) and isinstance(before, Mapping) and value and set(value) < set(before):
            key = next(iter(value))
            return f'the table given takes the place of all of [{place}]; for one key of it write "{place}.{key}"'
    return ""


def _require_known_keys(table: Mapping[str, Any], label: str) -> None:
    """Refuse keys that no table has, also those that are to take their default."""
    kept = {
        key: [item for item in value if item is not None] if isinstance(value, list) else value
        for key, value in table.items()
    }
    try:
        Scenario.model_validate(kept)
    except ValidationError as error:
        faults = faults_of(error, kept, unknown_only=True)
        if faults:
            raise report(label, faults) from None
