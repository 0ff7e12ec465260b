"""A sweep that was planned: lines in the order of the points, columns, the best, the table as text."""

from __future__ import annotations

import csv
import io
from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from nospill.core.units import in_si
from nospill.errors import ScenarioError
from nospill.sweeps.definition import LEAST, SweepDefinition
from nospill.sweeps.figures import figure_names
from nospill.sweeps.points import Line

_AGREES = 1e-3
"""Durations that differ by less, relatively, are taken for the same motion."""


@dataclass(frozen=True)  # without slots: what is derived is computed once
class Sweep:
    """Points of a sweep with what became of them.

    Attributes:
        definition: what was asked.
        lines: one a point that has been planned, in the order of the points.
        cold: of points planned warm, planned from nothing once more.
    """

    definition: SweepDefinition
    lines: tuple[Line, ...]
    cold: tuple[Line, ...] = ()

    def __repr__(self) -> str:
        return f"<Sweep of {self.definition.base.name}: {self.headline}>"

    @property
    def headline(self) -> str:
        """How many points there are, and how many certified."""
        certified = sum(line.certified for line in self.lines)
        return f"{len(self.lines)} of {len(self.definition.points)} points planned, {certified} certified"

    @cached_property
    def rows(self) -> tuple[dict[str, Any], ...]:
        """One a line: key, values as given, how it ended, figures and derived columns (None where there is none)."""
        cold = {line.key: line for line in self.cold}
        return tuple(self._row(line, cold.get(line.key)) for line in self.lines)

    def _row(self, line: Line, cold: Line | None) -> dict[str, Any]:
        known = dict(line.figures)
        for key, name in self.definition.short_names.items():
            number = in_si(line.values[key])
            if number is not None:
                known[name] = number
        figures: dict[str, Any] = {name: line.figures.get(name) for name in figure_names(self.definition.base)}
        for column in self.definition.columns:
            value = column.value(known) if line.figures else None
            figures[column.name] = value
            if value is not None:
                known[column.name] = value
        return {
            "key": line.key,
            **line.values,
            "ending": line.ending,
            **figures,
            "nearest": line.nearest,
            "cold_duration_s": None if cold is None else cold.figures.get("duration_s"),
            "plan_s": line.plan_s,
            "reason": line.reason,
        }

    def column(self, name: str) -> list[Any]:
        """A column of `rows`, or the numbers of an axis by its short name.

        Raises:
            ScenarioError: there is none.
        """
        keys = {short: key for key, short in self.definition.short_names.items()}
        if name in keys:
            return [in_si(line.values[keys[name]]) for line in self.lines]
        if self.rows and name not in self.rows[0]:
            raise ScenarioError(f"there is no column {name}; there are {', '.join([*self.rows[0], *keys])}")
        return [row[name] for row in self.rows]

    @property
    def best(self) -> Line | None:
        """The certified line that is best by the first goal; None where none is certified."""
        name, direction = self.definition.goals[0]
        sign = 1.0 if direction == LEAST else -1.0
        rated = zip(self.lines, self.column(name), strict=True)
        held = [
            (sign * value, index) for index, (line, value) in enumerate(rated) if line.certified and value is not None
        ]
        return self.lines[min(held)[1]] if held else None

    @property
    def endings(self) -> dict[str, int]:
        """How many points ended how, the commonest first."""
        return dict(Counter(line.ending for line in self.lines).most_common())

    @property
    def cold_text(self) -> str:
        """What planning from nothing once more says, in one sentence; empty where nothing was planned warm."""
        warm = {line.key: line for line in self.lines if line.warm_from}
        pairs = [(warm[line.key], line) for line in self.cold if line.key in warm]
        if not pairs:
            return ""
        ratios = [
            own.figures["duration_s"] / again.figures["duration_s"] - 1.0
            for own, again in pairs
            if own.certified and again.certified
        ]
        same = sum(abs(ratio) < _AGREES for ratio in ratios)
        agree = same + sum(not own.certified and not again.certified for own, again in pairs)
        text = (
            f"{len(pairs)} of {len(warm)} points planned warm were planned from nothing too: {agree} agree within 0.1 %"
        )
        widest = max(ratios, key=abs, default=0.0)
        if same < len(ratios):
            text += f", at most {100 * abs(widest):.2g} % apart ({'longer' if widest > 0 else 'shorter'} when warm)"
        return text

    def csv(self) -> str:
        """The table as text, a row a point; numbers in full."""
        out = io.StringIO()
        if self.rows:
            writer = csv.DictWriter(out, list(self.rows[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(self.rows)
        return out.getvalue()
