"""What a sweep is: base scenario, points, columns, goals; from a file or from Python."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from nospill.core.files import UnreadableError, bounded_text
from nospill.core.suggestions import nearest
from nospill.core.units import as_written, quantity
from nospill.errors import ScenarioError
from nospill.planning.varied import Source, Varied, varied
from nospill.sweeps.axes import Axis, Changes, axes_of, grid, latin_hypercube
from nospill.sweeps.columns import Column, columns_of
from nospill.sweeps.figures import figure_names, require_no_own_limits
from nospill.sweeps.points import Point, point_of
from nospill.sweeps.processes import Limits

LEAST, GREATEST = "least", "greatest"
USUAL_GOAL = {"duration_s": LEAST}
USUAL_TIME, USUAL_MEMORY = 600.0, "4 GB"
USUAL_AGAIN = 10

_LARGEST_FILE = 10_000_000
_TRIED = 20
"""Values of an axis that are tried one by one, to tell a key that there is not from a value that does not fit."""
_KEYS = ("scenario", "axis", "columns", "goals", "samples", "seed", "time_limit", "memory_limit", "again_cold")
_MEMORY = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(MB|GB)\s*")
_BYTES = {"MB": 1_000_000, "GB": 1_000_000_000}


@dataclass(frozen=True, slots=True)
class SweepDefinition:
    """A sweep, checked.

    Attributes:
        base: the scenario that is varied, of a motion or of a cycle.
        axes: what is varied.
        points: what is planned, in the order of the axes.
        columns: derived ones.
        goals: column -> `LEAST` or `GREATEST`, the first one first.
        limits: of one point.
        again_cold: how many of the points planned warm are planned from nothing once more, beside the best.
        samples: number of points that were drawn; None for a grid.
        seed: of the draw.
        scenario_name: by which a command finds the base scenario.
    """

    base: Varied
    axes: tuple[Axis, ...]
    points: tuple[Point, ...]
    columns: tuple[Column, ...] = ()
    goals: tuple[tuple[str, str], ...] = tuple(USUAL_GOAL.items())
    limits: Limits = field(default_factory=lambda: Limits(USUAL_TIME))
    again_cold: int = USUAL_AGAIN
    samples: int | None = None
    seed: int = 0
    scenario_name: str = ""

    @property
    def text(self) -> str:
        """The base scenario, which needs no other file."""
        return self.base.text()

    @property
    def short_names(self) -> dict[str, str]:
        """Key of an axis -> name by which columns call it: its last parts, as far as needed, joined by "_"."""
        keys = [key for axis in self.axes for key in axis.keys]
        return {key: _short(key, keys) for key in keys}


def define_sweep(
    base: Source,
    axes: Mapping[Any, Any],
    *,
    columns: Mapping[str, str] | None = None,
    goals: Mapping[str, str] | None = None,
    samples: int | None = None,
    seed: int = 0,
    time_limit: float | str = USUAL_TIME,
    memory_limit: str = USUAL_MEMORY,
    again_cold: int = USUAL_AGAIN,
) -> SweepDefinition:
    """A sweep from what a caller or a file gives; see `sweep` for the arguments.

    Raises:
        ScenarioError: one line that names what is wrong.
    """
    scenario = varied(base)
    require_no_own_limits(scenario)
    if not isinstance(axes, Mapping) or not axes:
        raise ScenarioError('axes: there is none; give {"tray.friction": [0.3, 0.4, 0.5]}')
    parsed = axes_of(axes)
    _require_whole(seed, "seed", 0)
    _require_whole(again_cold, "again_cold", 0)
    values = grid(parsed) if samples is None else latin_hypercube(parsed, samples, seed)
    _require_known_keys(scenario, parsed, values[0])
    text = scenario.text()
    points = tuple({point.key: point for point in (point_of(text, one) for one in values)}.values())
    plain = SweepDefinition(scenario, parsed, points)
    known = {*figure_names(scenario), *plain.short_names.values()}
    derived = columns_of({} if columns is None else columns, known)
    return SweepDefinition(
        scenario,
        parsed,
        points,
        derived,
        _goals(USUAL_GOAL if goals is None else goals, known | {column.name for column in derived}),
        Limits(_seconds(time_limit), _bytes(memory_limit)),
        again_cold,
        samples,
        seed,
        os.fspath(base) if isinstance(base, str | os.PathLike) else scenario.name,
    )


def read_sweep(path: str | os.PathLike[str]) -> SweepDefinition:
    """A sweep from a TOML file; its scenario is a file beside it, an example, or a table.

    Raises:
        ScenarioError: it cannot be read, or is no sweep; one line that names the file and what is wrong.
    """
    label = os.fsdecode(path)
    try:
        table = tomllib.loads(bounded_text(Path(path), _LARGEST_FILE))
    except (UnreadableError, tomllib.TOMLDecodeError, ValueError, RecursionError) as error:
        what = str(error) if isinstance(error, UnreadableError) else f"is not valid TOML: {error}"
        raise ScenarioError(f"{label}: {what}") from None
    try:
        return _from_table(table, Path(path).parent)
    except ScenarioError as error:
        raise ScenarioError(f"{label}: {error}", error.reason) from None


def _from_table(table: Mapping[str, Any], folder: Path) -> SweepDefinition:
    unknown = next((key for key in table if key not in _KEYS), None)
    if unknown is not None:
        near = nearest(unknown, _KEYS)
        hint = f"did you mean {near}?" if near else f"allowed are {', '.join(_KEYS)}"
        raise ScenarioError(f"{unknown} is an unknown key; {hint}")
    if "scenario" not in table:
        raise ScenarioError('scenario is missing; name a file or an example, as scenario = "matrix-liquid"')
    entries = table.get("axis", [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise ScenarioError("axis: write each axis as a table [[axis]] with key and values")
    options = {key: table[key] for key in _KEYS[2:] if key in table}
    for key in ("columns", "goals"):
        if not isinstance(options.get(key, {}), dict):
            raise ScenarioError(f"{key}: write it as a table [{key}]")
    return define_sweep(_scenario(table["scenario"], folder), _axes(entries), **options)


def _scenario(given: Any, folder: Path) -> Any:
    """A file beside the sweep's goes before an example of that name."""
    if isinstance(given, str) and (folder / given).exists():
        return folder / given
    return given


def _axes(entries: list[dict[str, Any]]) -> dict[Any, Any]:
    axes: dict[Any, Any] = {}
    for number, entry in enumerate(entries):
        rest = dict(entry)
        key, keys, values = rest.pop("key", None), rest.pop("keys", None), rest.pop("values", None)
        if (key is None) == (keys is None) or not isinstance(key, str | None) or not isinstance(keys, list | None):
            raise ScenarioError(f"axis {number}: give key, or keys for several that change together")
        if (values is None) == (not rest):
            raise ScenarioError(f"axis {number}: give values, or from and to with count or step")
        name = key if keys is None else tuple(map(str, keys))
        if name in axes:
            raise ScenarioError(f"axis {name}: is given twice")
        axes[name] = rest if values is None else values
    return axes


def _require_known_keys(base: Varied, axes: tuple[Axis, ...], first: Changes) -> None:
    """Refuse a key that the scenario has not, before anything is planned.

    A value that does not fit is a point with a reason; a key is refused where none of its values fits, neither alone
    nor with the first ones of the other axes.
    """
    for axis in axes:
        values = axis.values[:_TRIED] if axis.ends is None else (axis.at(0.0), axis.at(0.5), axis.at(1.0))
        refusal: ScenarioError | None = None
        for changes in (*(axis.changes(value) for value in values), first):
            try:
                base.changed(changes)
                break
            except ScenarioError as error:
                refusal = refusal or error
        else:
            raise ScenarioError(f"axis {axis.label}: {refusal}")


def _goals(given: Mapping[str, str], known: set[str]) -> tuple[tuple[str, str], ...]:
    if not isinstance(given, Mapping) or not given:
        raise ScenarioError('goals: give at least one, as duration_s = "least"')
    for name, direction in given.items():
        if name not in known:
            near = nearest(str(name), known)
            hint = f"did you mean {near}?" if near else f"there are {', '.join(sorted(known))}"
            raise ScenarioError(f"goals: there is no column {name}; {hint}")
        if direction not in (LEAST, GREATEST):
            raise ScenarioError(f'goals: {name} = {as_written(direction)} must be "{LEAST}" or "{GREATEST}"')
    return tuple((str(name), str(direction)) for name, direction in given.items())


def _seconds(given: Any) -> float:
    try:
        found = quantity(given, "time")
    except ScenarioError as error:
        raise ScenarioError(f"time_limit: {error}") from None
    if found <= 0.0:
        raise ScenarioError(f"time_limit = {as_written(given)} must be above 0")
    return found


def _bytes(given: Any) -> int:
    match = _MEMORY.fullmatch(given) if isinstance(given, str) else None
    if match is None or float(match[1]) <= 0.0:
        raise ScenarioError(f'memory_limit = {as_written(given)} is no memory; give MB or GB, for example "4 GB"')
    return round(float(match[1]) * _BYTES[match[2]])


def _require_whole(value: Any, name: str, least: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise ScenarioError(f"{name} = {as_written(value)} must be a whole number from {least} on")


def _short(key: str, keys: list[str]) -> str:
    """The last parts of a key that no other key ends in, as a name: "cargo.*.liquid_height" -> "liquid_height"."""
    parts = key.split(".")
    for count in range(1, len(parts) + 1):
        tail = parts[-count:]
        if sum(other.split(".")[-count:] == tail for other in keys) == 1:
            return "_".join(re.sub(r"\W", "_", part) for part in tail)
    return "_".join(re.sub(r"\W", "_", part) for part in parts)
