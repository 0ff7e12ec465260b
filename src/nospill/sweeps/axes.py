"""What is varied: keys of a scenario with their values, as a grid or as a Latin hypercube."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nospill.core.units import as_written, split_unit
from nospill.errors import ScenarioError

Changes = dict[str, Any]
"""Key of the scenario -> value as in a file: what makes a point of the base scenario, as `Scene.changed` takes it."""

MOST_POINTS = 100_000
"""Of a sweep: a week on a hundred cores at a second each, and a table that still opens."""

_DIGITS = 12
"""Significant digits of values between the ends of a range: 0.1 + 0.2 is written as 0.3."""
_RANGE_KEYS = {"from", "to", "count", "step"}


@dataclass(frozen=True, slots=True)
class Axis:
    """One thing that is varied.

    Attributes:
        keys: of the scenario that change together, dotted; one, or several that are zipped.
        values: one entry a value; of several keys each entry has one value for each.
        ends: of a range that is drawn from and not listed: its first and last value; else None.
    """

    keys: tuple[str, ...]
    values: tuple[Any, ...] = ()
    ends: tuple[Any, Any] | None = None

    @property
    def label(self) -> str:
        """Its keys in one text."""
        return ", ".join(self.keys)

    def changes(self, value: Any) -> Changes:
        """What a value of it sets."""
        return dict(zip(self.keys, value if len(self.keys) > 1 else [value], strict=True))

    def at(self, fraction: float) -> Any:
        """The value at a fraction from 0 to 1: of a range between its ends, of a list the entry there."""
        if self.ends is not None:
            return between(*self.ends, fraction)
        return self.values[min(int(fraction * len(self.values)), len(self.values) - 1)]


def axis_of(key: str | Sequence[str], given: Any) -> Axis:
    """An axis from what a file or a caller gives.

    Args:
        key: dotted key of the scenario, or several, which are zipped.
        given: a list of values, or a table with `from` and `to`, and `count` or `step` (neither: to be drawn from).
            Of several keys each entry of the list has a value for each.

    Raises:
        ScenarioError: there is no value, or it is neither; one line that names the axis.
    """
    keys: tuple[str, ...] = (key,) if isinstance(key, str) else tuple(key)
    label = ", ".join(map(str, keys))
    if not keys or not all(isinstance(item, str) and item.strip() for item in keys):
        raise ScenarioError(f"axis {as_written(label)}: a key of the scenario is needed, as cargo.c1.friction")
    if isinstance(given, Mapping):
        if len(keys) != 1:
            raise ScenarioError(f"axis {label}: keys that change together need a list of values, one for each key")
        return _range(keys[0], given)
    if isinstance(given, np.ndarray | range):
        given = given.tolist() if isinstance(given, np.ndarray) else list(given)
    if isinstance(given, str | bytes) or not isinstance(given, Sequence):
        raise ScenarioError(
            f"axis {label}: {as_written(given)} is no list of values; give [1, 2, 3] or "
            '{from = "20 mm", to = "60 mm", count = 9}'
        )
    if not len(given):
        raise ScenarioError(f"axis {label}: is empty; give at least one value, or leave the axis out")
    if len(keys) > 1:
        for entry in given:
            if isinstance(entry, str) or not isinstance(entry, Sequence) or len(entry) != len(keys):
                raise ScenarioError(
                    f"axis {label}: {as_written(entry)} has not one value for each of its {len(keys)} keys"
                )
        return Axis(keys, tuple(tuple(_plain(value) for value in entry) for entry in given))
    return Axis(keys, tuple(map(_plain, given)))


def _range(key: str, given: Mapping[str, Any]) -> Axis:
    unknown = sorted(set(given) - _RANGE_KEYS)
    if unknown or not {"from", "to"} <= set(given) or {"count", "step"} <= set(given):
        what = f"{unknown[0]} is unknown" if unknown else "is no range"
        raise ScenarioError(f'axis {key}: {what}; give {{from = "20 mm", to = "60 mm", count = 9}}, or step for count')
    first, last = _plain(given["from"]), _plain(given["to"])
    start, end = split_unit(first), split_unit(last)
    if start is None or end is None or start[1] != end[1]:
        raise ScenarioError(
            f"axis {key}: from {as_written(first)} to {as_written(last)} is no range; give two numbers of the same unit"
        )
    if "count" in given:
        count = given["count"]
        if isinstance(count, bool) or not isinstance(count, int) or count < 1:
            raise ScenarioError(f"axis {key}: count = {as_written(count)} must be a whole number above 0")
        _require_few(count, f"axis {key}")
        return Axis((key,), tuple(between(first, last, index / max(1, count - 1)) for index in range(count)))
    if "step" in given:
        return Axis((key,), _stepped(key, first, last, given["step"]))
    return Axis((key,), ends=(first, last))


def _stepped(key: str, first: Any, last: Any, step: Any) -> tuple[Any, ...]:
    """Values from the first on, a step apart, not beyond the last."""
    parts = [split_unit(value) for value in (first, last, step)]
    start, end, pace = (part[0] if part is not None else math.nan for part in parts)
    if parts[2] is None or parts[0] is None or parts[2][1] != parts[0][1] or not pace * (end - start) > 0.0:
        raise ScenarioError(
            f"axis {key}: step = {as_written(step)} leads from {as_written(first)} to {as_written(last)} in no number "
            "of steps; give a number of the same unit"
        )
    count = math.floor((end - start) / pace + 1e-9) + 1
    _require_few(count, f"axis {key}")
    return tuple(_written(start + index * pace, parts[0][1], first) for index in range(count))


def between(first: Any, last: Any, fraction: float) -> Any:
    """A quantity between two of the same unit, written like the first."""
    start, end = split_unit(first), split_unit(last)
    assert start is not None and end is not None  # as `axis_of` has seen to
    return _written(start[0] + fraction * (end[0] - start[0]), start[1], first)


def _written(number: float, unit: str, like: Any) -> Any:
    rounded = float(f"{number:.{_DIGITS}g}")
    return f"{rounded:.{_DIGITS}g} {unit}".rstrip() if isinstance(like, str) else rounded


def _plain(value: Any) -> Any:
    """A value as a file holds it: numbers of NumPy and tuples are what they stand for."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple | list):
        return [_plain(entry) for entry in value]
    return value


def axes_of(given: Mapping[Any, Any]) -> tuple[Axis, ...]:
    """Axes from a table of key, or keys, and values.

    Raises:
        ScenarioError: as `axis_of`, or a key is varied twice.
    """
    axes = tuple(axis_of(key, values) for key, values in given.items())
    keys = [key for axis in axes for key in axis.keys]
    twice = next((key for key in keys if keys.count(key) > 1), None)
    if twice is not None:
        raise ScenarioError(f"axis {twice}: is given twice; zip what changes together into one axis")
    return axes


def grid(axes: Sequence[Axis]) -> list[Changes]:
    """Every combination of the axes' values, the last axis changing first; one point without changes where none is.

    Raises:
        ScenarioError: there are more than `MOST_POINTS`, or an axis is to be drawn from.
    """
    drawn = next((axis for axis in axes if axis.ends is not None), None)
    if drawn is not None:
        raise ScenarioError(f"axis {drawn.label}: a grid needs count or step; samples = 100 draws from a range without")
    _require_few(math.prod(len(axis.values) for axis in axes), "the grid")
    chosen = itertools.product(*(axis.values for axis in axes))
    return [_merged(axes, values) for values in chosen]


def latin_hypercube(axes: Sequence[Axis], samples: int, seed: int) -> list[Changes]:
    """Points drawn so that each axis is covered evenly, whatever the others do (McKay, Beckman, Conover 1979).

    Args:
        axes: ranges to draw from, or lists, whose entries come equally often.
        samples: number of points.
        seed: of the draw.

    Raises:
        ScenarioError: too many points, or none.
    """
    if isinstance(samples, bool) or not isinstance(samples, int) or samples < 1:
        raise ScenarioError(f"samples = {as_written(samples)} must be a whole number above 0")
    _require_few(samples, "samples")
    if not axes:
        raise ScenarioError("samples: there is no axis to draw from")
    from scipy.stats import qmc  # takes as long to load as all else of a sweep

    drawn = qmc.LatinHypercube(len(axes), rng=np.random.default_rng(seed)).random(samples)
    return [_merged(axes, [axis.at(float(at)) for axis, at in zip(axes, row, strict=True)]) for row in drawn]


def _merged(axes: Sequence[Axis], values: Sequence[Any]) -> Changes:
    return {key: value for axis, own in zip(axes, values, strict=True) for key, value in axis.changes(own).items()}


def _require_few(count: int, what: str) -> None:
    if count > MOST_POINTS:
        raise ScenarioError(
            f"{what}: {count:,} points; at most {MOST_POINTS:,} are planned, so take fewer values, or draw some with "
            "samples = 1000"
        )
