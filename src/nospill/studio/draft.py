"""What is being edited: the table of a scenario file, its history, and which object is selected."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from typing import Any

from nospill.core.units import as_written
from nospill.scenario.settings import changed_table

Key = tuple[str | int, ...]
"""Place of a value in the table: ("tray", "friction"), ("cargo", 0, "at", 1), the last one of a list of two."""

LONGEST_HISTORY = 200
"""Steps that can be undone; a table takes a few kilobytes."""


class Draft:
    """A scenario table under edit. Tables handed out are never changed afterwards; every edit makes a new one.

    Consecutive edits of one value, or of one drag, are one step of the history.

    Attributes:
        selected: number of the object whose values are shown.
        chosen: number of the obstacle whose values are shown; nothing counts while there are none.
    """

    def __init__(self, table: Mapping[str, Any]) -> None:
        """Start from a table, which is copied."""
        self._history: list[dict[str, Any]] = [copy.deepcopy(dict(table))]
        self._position = 0
        self._open: object = None
        self.selected = self.chosen = 0

    @property
    def table(self) -> dict[str, Any]:
        """The table as it stands; not to be changed."""
        return self._history[self._position]

    @property
    def cargo(self) -> list[dict[str, Any]]:
        """The entries `[[cargo]]`."""
        return self.table.get("cargo", [])

    @property
    def obstacles(self) -> list[dict[str, Any]]:
        """The entries `[[obstacle]]`."""
        return self.table.get("obstacle", [])

    @property
    def can_undo(self) -> bool:
        """Whether there is an earlier table."""
        return self._position > 0

    @property
    def can_redo(self) -> bool:
        """Whether a step was undone."""
        return self._position < len(self._history) - 1

    def value(self, key: Key) -> Any:
        """The value at a place, None where there is none."""
        value: Any = self.table
        for part in key:
            if isinstance(value, dict):
                value = value.get(str(part))
            elif isinstance(value, list) and isinstance(part, int) and part < len(value):
                value = value[part]
            else:
                return None
        return value

    def change(self, values: Mapping[Key, Any], *, step: object = None) -> bool:
        """Put values in their places, None to remove a key; tables on the way are made, emptied ones stay.

        Args:
            values: by their place.
            step: edits in a row with an equal one that is not None are undone together.

        Returns:
            Whether anything changed.
        """
        places: dict[Key, Any] = {}
        for key, value in values.items():
            *above, last = key
            if isinstance(last, int):
                given = places.get(tuple(above), self.value(tuple(above)))
                entries: list[Any] = list(given) if isinstance(given, list) else [0.0, 0.0]
                entries[last] = "" if value is None else value
                places[tuple(above)] = entries
            else:
                places[key] = value
        return self._take(changed_table(self.table, places), step)

    def type_in(self, key: Key, value: Any) -> bool:
        """`change` of one value as it is typed: one step until another value is edited."""
        return self.change({key: value}, step=key)

    def move(self, index: int, x: float, y: float, *, ended: bool = True) -> bool:
        """Put an object at x, y in m on the tray, written in mm to a hundredth; one drag is one step."""
        at = [millimetres(x), millimetres(y)]
        changed = self.change({("cargo", index, "at"): at}, step=("drag", index))
        if ended:
            self.close_step()
        return changed

    def move_obstacle(self, index: int, place: tuple[float, float, float], *, ended: bool = True) -> bool:
        """Put an obstacle at x, y, z in m, written in mm to a hundredth; one drag is one step."""
        at = [millimetres(value) for value in place]
        changed = self.change({("obstacle", index, "at"): at}, step=("drag obstacle", index))
        if ended:
            self.close_step()
        return changed

    def close_step(self) -> None:
        """What is edited next is undone on its own."""
        self._open = None

    def open(self, table: Mapping[str, Any]) -> None:
        """Take another table, which is copied; the old one is one step back."""
        self._take(copy.deepcopy(dict(table)), None)
        self.selected = self.chosen = 0

    def add(self, entry: Mapping[str, Any]) -> None:
        """Add an object under a name that is free, and select it."""
        self.selected = self._added("cargo", entry)

    def add_obstacle(self, entry: Mapping[str, Any]) -> None:
        """Add an obstacle under a name that is free, and choose it."""
        self.chosen = self._added("obstacle", entry)

    def remove(self, index: int) -> bool:
        """Take an object away; the last one stays, for the form to show."""
        if len(self.cargo) < 2:
            return False
        self._removed("cargo", index)
        return True

    def remove_obstacle(self, index: int) -> bool:
        """Take an obstacle away; False where there is none."""
        if not 0 <= index < len(self.obstacles):
            return False
        self._removed("obstacle", index)
        return True

    def _added(self, key: str, entry: Mapping[str, Any]) -> int:
        named = copy.deepcopy(dict(entry)) | {"name": self._free_name(str(entry["name"]))}
        table = copy.deepcopy(self.table)
        table.setdefault(key, []).append(named)
        self._take(table, None)
        return len(table[key]) - 1

    def _removed(self, key: str, index: int) -> None:
        table = copy.deepcopy(self.table)
        del table[key][index]
        if not table[key]:
            del table[key]
        self._take(table, None)
        self._select_what_is_there()

    def _select_what_is_there(self) -> None:
        self.selected = min(self.selected, len(self.cargo) - 1)
        self.chosen = max(0, min(self.chosen, len(self.obstacles) - 1))

    def undo(self) -> bool:
        """Go one step back; False at the beginning."""
        return self._go(-1)

    def redo(self) -> bool:
        """Take an undone step again; False where there is none."""
        return self._go(1)

    def _go(self, by: int) -> bool:
        if not 0 <= self._position + by < len(self._history):
            return False
        self._position += by
        self._open = None
        self._select_what_is_there()
        return True

    def _take(self, table: dict[str, Any], step: object) -> bool:
        if table == self.table and _same_types(table, self.table):
            return False
        together = step is not None and step == self._open and self._position > 0 and not self.can_redo
        del self._history[self._position + (0 if together else 1) :]
        self._history.append(table)
        del self._history[:-LONGEST_HISTORY]
        self._position = len(self._history) - 1
        self._open = step
        return True

    def _free_name(self, wanted: str) -> str:
        taken = {entry.get("name") for entry in [*self.cargo, *self.obstacles]}
        if wanted not in taken:
            return wanted
        stem = wanted.rstrip("0123456789") or "object"
        return next(name for number in range(2, len(taken) + 3) if (name := f"{stem}{number}") not in taken)


def millimetres(length: float) -> str:
    """A length in m as text in mm, to a hundredth."""
    return f"{round(1e3 * length, 2) + 0.0:.10g} mm"


def label_of(entry: Mapping[str, Any], index: int) -> str:
    """How an object is called, by its label or else its name, while both may be wrong."""
    name = entry.get("label") or entry.get("name")
    return name if isinstance(name, str) and name else f"object {index + 1} ({as_written(name)})"


def choices_of(entries: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    """Objects or obstacles by number and name."""
    return tuple(f"{index + 1}: {label_of(entry, index)}" for index, entry in enumerate(entries))


def _same_types(one: Any, other: Any) -> bool:
    """Whether equal tables write alike: 1 and 1.0 are equal, but a whole number and a real one in a file."""
    return repr(one) == repr(other)
