"""What a plan survives of its arm, as a record and in one line; how it is found is in `survival`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from nospill.laws.constraints.base import RowId

SWING_FREQUENCY = 5.0
"""Hz."""
DAMPING = 0.05
"""Ratio of an elastic transmission."""
MOST_DELAY, MOST_SWING = 0.02, 0.05
"""s and rad; beyond that a motion is not looked at."""
HIGHEST, LOWEST = 100.0, 6.0
"""Hz, between which elastic joints are tried."""


@dataclass(frozen=True, slots=True)
class Survived:
    """Of one fault the size that a plan survives.

    Attributes:
        size: s, rad or Hz, of a resonance the lowest; None where nothing fails within what is looked at.
        first: label of the row that fails first beyond it, "slip | bottle"; empty where none does.
    """

    size: float | None
    first: str = ""


@dataclass(frozen=True, slots=True)
class Survival:
    """What a plan survives, with nothing in reserve (see `tracked_rows`).

    Attributes:
        delay: between joints, s, until something spills, slides, tips, lifts or touches.
        swing: amplitude, rad, until something spills, slides, tips, lifts or touches.
        resonance: lowest frequency, Hz, likewise.
    """

    delay: Survived
    swing: Survived
    resonance: Survived

    @property
    def text(self) -> str:
        """One sentence without a full stop: "survives 0.25 ms between joints, ...; first to fail: slip of bottle"."""
        delay, swing, resonance = self.delay, self.swing, self.resonance
        late = f"{_figure(delay.size, MOST_DELAY)} ms between joints"
        swings = f"{_figure(swing.size, MOST_SWING)} mrad of swing at {SWING_FREQUENCY:g} Hz"
        if resonance.size is None:
            rings = f"resonances above {LOWEST:g} Hz"
        else:
            none = resonance.size >= HIGHEST
            rings = f"no resonance below {HIGHEST:g} Hz" if none else f"resonances above {resonance.size:.2g} Hz"
        first = next((item.first for item in (delay, swing, resonance) if item.first), "")
        fails = f"; first to fail: {_in_words(first)}" if first else ""
        return f"survives {late}, {swings}, {rings}{fails}"

    def to_dict(self) -> dict[str, Any]:
        """For summary.json, with the units in the names."""
        found: dict[str, Any] = {}
        for name, unit in _UNITS.items():
            item: Survived = getattr(self, name)
            found |= {f"{name}_{unit}": item.size, f"{name}_first": item.first}
        return found

    @classmethod
    def of_dict(cls, found: Mapping[str, Any]) -> Survival:
        """What `to_dict` wrote.

        Raises:
            KeyError: a key is missing.
        """
        return cls(**{name: Survived(found[f"{name}_{unit}"], found[f"{name}_first"]) for name, unit in _UNITS.items()})


_UNITS = {"delay": "s", "swing": "rad", "resonance": "hz"}


def _figure(size: float | None, most: float) -> str:
    """Thousandths with two digits, rounded down; of none more than the most that is looked at."""
    if size is None:
        return f"more than {1e3 * most:g}"
    if size <= 0.0:
        return "0"
    digits = 1 - math.floor(math.log10(1e3 * size))
    return f"{math.floor(1e3 * size * 10.0**digits + 1e-9) / 10.0**digits:.{max(digits, 0)}f}"


def _in_words(label: str) -> str:
    row = RowId.of(label)
    return f"{row.constraint} of {row.subject}" if row.subject else row.constraint
