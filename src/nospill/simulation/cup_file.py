"""One container with its liquid from a file of its own: the keys of a cargo entry at top level."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import Any

from pydantic import ValidationError

from nospill.core.files import UnreadableError, bounded_text
from nospill.errors import ModelError, ScenarioError
from nospill.scenario.cargo_entries import CargoEntry
from nospill.scenario.cargo_reader import read_cargo
from nospill.scenario.messages import faults_of
from nospill.scenario.sentences import report
from nospill.scenario.tables import Table
from nospill.scene.cargo import Cargo

_EXAMPLE = (
    'for example shape = "cylinder", radius = "35 mm", height = "80 mm", liquid = "water", liquid_height = "49 mm"'
)
_LARGEST_FILE = 1_000_000


class _Cup(Table):
    """One entry at the place where messages look for it."""

    cargo: list[CargoEntry]


def cup_from_table(
    table: Mapping[str, Any], *, label: str = "cup", slosh_modes: int = 1, folder: str | os.PathLike[str] = "."
) -> Cargo:
    """Build a container with its liquid from the keys of a cargo entry.

    Args:
        table: as in a `[[cargo]]` entry; `name` and `at` may be missing, `liquid` may not.
        label: what messages call it.
        slosh_modes: modes of the liquid in each direction.
        folder: where files that the table names are looked up.

    Raises:
        ScenarioError: unknown, missing or impossible values. ModelError: the slosh model does not cover the filling.
    """
    entry = {"name": "cup", "at": [0.0, 0.0], **table}
    wrapped = {"cargo": [entry]}
    if "shape" not in table:
        raise report(label, [("", f"shape is missing; give the keys of a cargo entry at top level, {_EXAMPLE}")])
    try:
        cup = _Cup.model_validate(wrapped).cargo[0]
    except ValidationError as error:
        raise report(label, [("", text) for _, text in faults_of(error, wrapped)]) from None
    try:
        cup = cup.model_copy(update=cup.standalone(FilePath(folder)))
        # Friction and footprint are a cargo's, but no motion of the liquid asks for them.
        cargo = read_cargo(
            cup, friction=1.0, friction_reserve=0.0, footprint_reserve=0.0, fidelity="full", slosh_modes=slosh_modes
        )
    except (ScenarioError, ModelError) as error:
        raise report(label, [("", str(error))]) from None
    if cargo.filling is None:
        raise report(label, [("", f"liquid is missing: there is nothing to slosh; {_EXAMPLE}")])
    return cargo


def read_cup(path: str | os.PathLike[str], *, slosh_modes: int = 1) -> Cargo:
    """Read a container with its liquid from a TOML file, as `cup_from_table`.

    Raises:
        ScenarioError: the file cannot be read or is not TOML, or its values are wrong.
        ModelError: the slosh model does not cover the filling.
    """
    label = os.fsdecode(path)
    try:
        table = tomllib.loads(bounded_text(path, _LARGEST_FILE))
    except UnreadableError as error:
        raise report(label, [("", f"{error}; give a TOML file with the keys of one cargo entry, {_EXAMPLE}")]) from None
    except tomllib.TOMLDecodeError as error:
        raise report(label, [("", f"is not valid TOML: {error}")]) from None
    except RecursionError:
        raise report(label, [("", "is not the description of a cup: it is nested too deeply")]) from None
    except ValueError as error:  # a whole number of thousands of digits
        raise report(label, [("", f"cannot be read: {error}")]) from None
    return cup_from_table(table, label=label, slosh_modes=slosh_modes, folder=FilePath(path).parent)
