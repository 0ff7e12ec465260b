"""Scenarios from wherever they are: a file, a bundled example, a plan folder, a dictionary."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nospill.core.files import UnreadableError, bounded_text
from nospill.core.suggestions import nearest
from nospill.core.units import as_written
from nospill.errors import ScenarioError
from nospill.scenario.examples import CYCLES, EXAMPLES, example_path
from nospill.scenario.model import Scenario
from nospill.scenario.scenes import scene_from_table
from nospill.scenario.sentences import report
from nospill.scenario.settings import with_settings
from nospill.scenario.tables import Table, plain
from nospill.scene.scene import Scene

ScenarioSource = str | os.PathLike[str] | Mapping[str, Any] | Scenario
"""What names or is a scenario."""

KEPT_SCENARIO = "scenario.toml"
"""Name of the scenario in a plan folder."""

_LARGEST_FILE = 10_000_000
_KNOWN_EXAMPLES = f"give a TOML file or a bundled example ({', '.join(EXAMPLES)})"


def load(scenario: ScenarioSource, *, settings: Sequence[str] = ()) -> Scene:
    """Read a scenario.

    Args:
        scenario: a TOML file, a plan folder, a bundled example by its name, a `Scenario`, or a dictionary with the keys
            of a scenario file (files that these name are looked up in the working folder).
        settings: values to replace, each as "motion.tilt=free", see `with_settings`.

    Raises:
        ScenarioError: it cannot be read, or describes no possible task; one line that names the file ("scenario" for a
            dictionary), the place in it, the value and what is allowed.
    """
    found = table_of(scenario, settings)
    return scene_from_table(found.table, name=found.name, folder=found.folder, label=found.label)


@dataclass(frozen=True, slots=True)
class Found:
    """A scenario before its keys are looked at.

    Attributes:
        table: its parsed content.
        name: of what it describes, where the table has none.
        folder: where files that it names are looked up.
        label: what messages call it.
    """

    table: dict[str, Any]
    name: str
    folder: Path
    label: str


def table_of(scenario: ScenarioSource, settings: Sequence[str] = ()) -> Found:
    """The content of a scenario from wherever it is; arguments and errors as for `load`."""
    if isinstance(scenario, Mapping | Scenario):
        table = plain(scenario)
        _require_text_keys(table)
        return Found(with_settings(table, settings), "scenario", Path(), _label("scenario", settings))
    if isinstance(scenario, str | os.PathLike):
        label = os.fsdecode(scenario)
        file = _locate(label)
        table = with_settings(_parse(file, label), settings)
        return Found(table, file.stem, file.parent, _label(label, settings))
    raise ScenarioError(
        f"a scenario is a TOML file, a plan folder, the name of a bundled example, a Scenario or a dictionary, "
        f"not a value of type {scenario.title() if isinstance(scenario, Table) else type(scenario).__name__}"
    )


def read_scenario(path: str | os.PathLike[str], *, settings: Sequence[str] = ()) -> Scene:
    """Read a scenario file, the one in a plan folder, or a bundled example by its name.

    Args:
        path: a TOML file, a plan folder, or a key of `nospill.scenario.examples.EXAMPLES` (a file of that very name
            wins).
        settings: values to replace, see `with_settings`.

    Raises:
        ScenarioError: the file cannot be read, is not TOML, or describes no possible task; one line that names the
            file, the place in it, the value and what is allowed.
    """
    return load(path, settings=settings)


def has_legs(scenario: ScenarioSource) -> bool:
    """Whether a scenario is a cycle: it has `[[leg]]` tables; raises as `load` where it cannot be read."""
    return bool(table_of(scenario).table.get("leg"))


def _require_text_keys(value: Any) -> None:
    """Refuse what no file can hold, before it is taken for one."""
    if isinstance(value, Mapping):
        for key, entry in value.items():
            if not isinstance(key, str):
                raise report("scenario", [("", f"key {key!r} is not text; keys are those of a scenario file")])
            _require_text_keys(entry)
    elif isinstance(value, list | tuple):
        for entry in value:
            _require_text_keys(entry)


def _label(name: str, settings: Sequence[str]) -> str:
    return " ".join([name, *(f"--set {setting}" for setting in settings)])


def _locate(label: str) -> Path:
    if not label.strip():
        raise report(as_written(label), [("", f"names no scenario; {_KNOWN_EXAMPLES}")])
    file = Path(label)
    try:
        if file.is_file():
            return file
        if label in EXAMPLES or label in CYCLES:
            return example_path(label)
        if (file / KEPT_SCENARIO).is_file():
            return file / KEPT_SCENARIO
        if file.is_dir():
            raise report(label, [("", "is a folder; name the scenario file in it")])
        exists = file.exists()
    except (OSError, ValueError) as error:  # ValueError: a NUL character in the path
        raise report(as_written(label), [("", f"cannot be read: {_reason(error)}")]) from None
    if exists:
        raise report(label, [("", "is not a regular file; give a TOML file")])
    near = nearest(label, [*EXAMPLES, *CYCLES])
    hint = f'did you mean "{near}"?' if near else _KNOWN_EXAMPLES
    raise report(label, [("", f"no such file, and no bundled example of that name; {hint}")])


def _parse(file: Path, label: str) -> dict[str, Any]:
    try:
        return tomllib.loads(bounded_text(file, _LARGEST_FILE))
    except UnreadableError as error:
        raise report(label, [("", str(error))]) from None
    except tomllib.TOMLDecodeError as error:
        raise report(label, [("", _syntax(str(error)))]) from None
    except RecursionError:
        raise report(label, [("", "is not a scenario: it is nested too deeply")]) from None
    except ValueError as error:  # a whole number of thousands of digits
        raise report(label, [("", f"cannot be read: {_reason(error)}")]) from None


def _syntax(message: str) -> str:
    if "Cannot overwrite a value" in message or "Cannot declare" in message:
        message += "; the same key or table is given twice"
    return f"is not valid TOML: {message}"


def _reason(error: Exception) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)
