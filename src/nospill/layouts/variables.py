"""What a layout may change: numbers of a scenario, each between two bounds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nospill.core.units import as_written, in_si
from nospill.errors import ScenarioError
from nospill.path_search.base_yaw import has_free_base
from nospill.path_search.candidates import has_free_path
from nospill.path_search.end_yaws import free_ends
from nospill.planning.varied import Varied
from nospill.scenario.layout import footprint_core
from nospill.scenario.settings import stated_value
from nospill.scene.cargo import Cargo
from nospill.scene.cycle import Cycle

PLACE, EVERY_PLACE = "at", "cargo.*.at"
"""Last part of the key that says where an object stands on the tray, and the key of all of them."""

_DIGITS = 5
"""Decimals of the values that are tried, in SI units: a hundredth of a millimetre."""


@dataclass(frozen=True, slots=True, eq=False)
class Variables:
    """The numbers that may change, key by key, SI.

    Attributes:
        keys: of the scenario, dotted, one a number: a key with two numbers stands here twice.
        low: (n,) least values.
        high: (n,) greatest values.
        stated: (n,) values of the scenario.
        places: name of the object that each number places on the tray, empty for the others.
    """

    keys: tuple[str, ...]
    low: np.ndarray
    high: np.ndarray
    stated: np.ndarray
    places: tuple[str, ...]

    @property
    def span(self) -> np.ndarray:
        """(n,) widths of the ranges."""
        return self.high - self.low

    def changes(self, values: np.ndarray) -> dict[str, Any]:
        """What values (n,) set, as `Scene.changed` takes it; rounded."""
        return self.exactly(np.round(values, _DIGITS))

    def exactly(self, values: np.ndarray) -> dict[str, Any]:
        """The same unrounded, for a step that is smaller."""
        found: dict[str, list[float]] = {}
        for key, value in zip(self.keys, values, strict=True):
            found.setdefault(key, []).append(float(value))
        return {key: numbers if len(numbers) > 1 else numbers[0] for key, numbers in found.items()}


def variables_of(base: Varied, free: Mapping[str, Any]) -> Variables:
    """The numbers that may change.

    Args:
        base: the scenario.
        free: dotted key -> its least and its greatest value, each a number or a list of them, as in the file. The place
            of an object, "cargo.c1.at" or "cargo.*.at", may have None: anywhere on the tray.

    Raises:
        ScenarioError: a key is none of numbers, or its range is none; one line that names it.
    """
    expanded: dict[str, Any] = {}
    for key, ends in free.items():
        if key == EVERY_PLACE:
            movable = [name for name, item in cargo_of(base).items() if not item.carrier]
            expanded |= {f"cargo.{name}.{PLACE}": ends for name in movable if _is_stated(base, f"cargo.{name}.{PLACE}")}
        else:
            expanded[key] = ends
    if not expanded:
        raise ScenarioError(
            "a layout without anything that may change; name a key, as cargo.*.at or robot.base_position"
        )
    if any(scene.motion.duration is not None for scene in base.scenes):
        raise ScenarioError(
            "motion.duration is stated, so that the motion takes as long in every layout; leave it out, and give "
            "--within TIME (from Python within=) for the layout with the largest margin in that time"
        )
    if any(map(has_free_base, base.scenes)):
        raise ScenarioError(
            'robot.base_yaw = "free" is chosen anew for every layout; state an angle, and let robot.base_yaw change '
            "between two values"
        )
    if ends := [end for scene in base.scenes for end in free_ends(scene)]:
        raise ScenarioError(f'path.{ends[0]}.yaw = "free" is chosen anew for every layout; state an angle')
    if moved := next((key for key in expanded if _is_end_of_free_path(base, key)), None):
        raise ScenarioError(
            f"{moved}: the ends of a free path are not moved by a layout; try values with nospill sweep"
        )
    rows = [row for key, ends in expanded.items() for row in _rows(base, key, ends)]
    low, high, stated = np.array([row[1:4] for row in rows], dtype=float).T
    return Variables(tuple(row[0] for row in rows), low, high, stated, tuple(row[4] for row in rows))


def cargo_of(base: Varied) -> dict[str, Cargo]:
    """Everything that ever stands on the tray, by name."""
    return {item.name: item for scene in base.scenes for item in scene.cargo}


def _is_end_of_free_path(base: Varied, key: str) -> bool:
    """Whether a key is of a path that is looked for anew in every layout."""
    if isinstance(base.task, Cycle):
        leg = next((leg for leg in base.task.legs if key.startswith(f"leg.{leg.name}.path.")), None)
        return leg is not None and has_free_path(leg.scene)
    return key.startswith("path.") and has_free_path(base.task)


def _is_stated(base: Varied, key: str) -> bool:
    try:
        stated_value(base.table, key)
    except ScenarioError:
        return False
    return True


def _rows(base: Varied, key: str, ends: Any) -> list[tuple[str, float, float, float, str]]:
    """Of each number of a key: the key, its bounds, its value and the object that it places."""
    if not _is_stated(base, key):
        raise ScenarioError(
            f"{key}: the scenario states no value there to start from; state one, as by --set {key}=..."
        )
    stated = _numbers(key, stated_value(base.table, key))
    placed = _placed(base, key)
    if ends is None:
        if placed is None:
            raise ScenarioError(f"{key}: needs a least and a greatest value; only the place of an object goes without")
        reach = np.max(np.abs(footprint_core(placed) - placed.position), axis=0) + placed.container.footprint.rounding
        high = base.scenes[0].tray.size / 2 - reach - (placed.tolerance.position if placed.tolerance else 0.0)
        low = -high
    else:
        if isinstance(ends, str) or not isinstance(ends, Sequence | np.ndarray) or len(ends) != 2:
            raise ScenarioError(
                f'{key}: {as_written(ends)} is no range; give [least, greatest], as ["80 mm", "150 mm"] or '
                "[[0.5, -0.2, 0.4], [0.7, 0.2, 0.4]]"
            )
        low, high = (np.array(_numbers(key, end)) for end in ends)
    if not len(low) == len(high) == len(stated):
        raise ScenarioError(f"{key}: its range has {len(low)} and {len(high)} numbers, the scenario {len(stated)}")
    if np.any(low > high):
        raise ScenarioError(f"{key}: the least value {as_written(_plain(low))} is above {as_written(_plain(high))}")
    if np.any(np.round(low, _DIGITS) > np.round(stated, _DIGITS)) or np.any(
        np.round(high, _DIGITS) < np.round(stated, _DIGITS)
    ):
        raise ScenarioError(
            f"{key}: the scenario's own value is outside its range; state another, as by --set {key}=..."
        )
    name = "" if placed is None else placed.name
    return list(zip([key] * len(stated), low, high, stated, [name] * len(stated), strict=True))


def _placed(base: Varied, key: str) -> Cargo | None:
    """The object on the tray whose place a key says."""
    parts = key.split(".")
    if len(parts) != 3 or parts[0] != "cargo" or parts[2] != PLACE:
        return None
    named = {name: item for name, item in cargo_of(base).items() if not item.carrier}
    entry, entries = parts[1], base.table["cargo"]
    if entry.isdigit() and entry not in named:
        entry = str(entries[int(entry)].get("name", "")) if int(entry) < len(entries) else ""
    return named.get(entry)


def _numbers(key: str, value: Any) -> list[float]:
    """A number or several, SI."""
    entries = list(value) if isinstance(value, Sequence | np.ndarray) and not isinstance(value, str) else [value]
    numbers = [in_si(entry) for entry in entries]
    if not numbers or any(number is None or not np.isfinite(number) for number in numbers):
        raise ScenarioError(f"{key}: {as_written(value)} is no number; a layout changes numbers, with or without units")
    return [float(number) for number in numbers if number is not None]


def _plain(values: np.ndarray) -> Any:
    return [float(value) for value in values] if len(values) > 1 else float(values[0])
