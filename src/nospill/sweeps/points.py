"""Points of a sweep and what becomes of them: keys by content, groups of neighbours, lines."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from nospill.core.units import in_si
from nospill.sweeps.axes import Axis, Changes

PLANNED, UNCERTIFIED, NO_MOTION, REFUSED = "planned", "not certified", "no motion", "refused"
OUT_OF_TIME, OUT_OF_MEMORY, CRASH = "out of time", "out of memory", "crash"
OF_THE_MACHINE = frozenset({OUT_OF_TIME, OUT_OF_MEMORY, CRASH})
"""How a point may end that says something about where it was planned, and not about the scenario."""

GROUP = 8
"""Neighbours planned warm from one of them: more make the first one's search cheaper, and lie farther from it."""

_KEY = 16


@dataclass(frozen=True, slots=True)
class Point:
    """A variant of the base scenario.

    Attributes:
        key: hash of the base scenario's text and of the values; the same wherever and whenever it is planned.
        values: key of the scenario -> value.
    """

    key: str
    values: Changes = field(hash=False)


@dataclass(frozen=True, slots=True)
class Group:
    """Neighbours that one process plans one after the other.

    Attributes:
        head: planned from nothing; the others start from its plan. None: each is planned from nothing.
        points: those that are wanted, the head among them or not.
    """

    head: Point | None
    points: tuple[Point, ...]


@dataclass(frozen=True, slots=True)
class Line:
    """What became of a point.

    Attributes:
        key: of the point.
        values: key of the scenario -> value.
        ending: how it ended: `PLANNED` means certified.
        reason: one sentence where it did not; empty otherwise.
        figures: name -> number, of a motion.
        nearest: constraint and subject of the row nearest to its limit, of a motion.
        warm_from: key of the point from whose plan it started; empty where it was planned from nothing.
        cold: planned from nothing once more, beside the line that was planned warm.
        plan_s: time it took, s.
        nospill: version that planned it.
    """

    key: str
    values: Changes = field(hash=False)
    ending: str
    reason: str = ""
    figures: dict[str, float] = field(default_factory=dict, hash=False)
    nearest: str = ""
    warm_from: str = ""
    cold: bool = False
    plan_s: float = 0.0
    nospill: str = ""

    @property
    def certified(self) -> bool:
        """Whether there is a motion and its certificate holds."""
        return self.ending == PLANNED

    def to_dict(self) -> dict[str, Any]:
        """What a file holds."""
        return asdict(self)

    @classmethod
    def from_dict(cls, found: Mapping[str, Any]) -> Line:
        """A line of a file; raises KeyError or TypeError where it is none."""
        return cls(**found)


def point_of(base: str, values: Changes) -> Point:
    """A point with its key.

    Args:
        base: text of the base scenario, which needs no other file.
        values: key of the scenario -> value.
    """
    content = json.dumps([base, values], sort_keys=True, ensure_ascii=True)
    return Point(hashlib.sha256(content.encode()).hexdigest()[:_KEY], values)


def grouped(points: Sequence[Point], axes: Sequence[Axis], size: int = GROUP) -> list[Group]:
    """Points as groups of neighbours, whoever plans them and in whatever order.

    Points with unlike words are apart; the rest is halved across its widest axis until no group is larger than `size`
    (a k-d tree). The head is the point nearest to the middle.

    Args:
        points: all of the sweep, those that are planned already too, so that the heads stay the same.
        axes: along which they lie.
        size: points of a group at most.
    """
    if not points:
        return []
    places, words = _places(points, axes)
    found = []
    for part in _parts(np.arange(len(points)), places, words, size):
        distance = np.sum((places[part] - places[part].mean(axis=0)) ** 2, axis=1)
        first = int(part[int(np.argmin(np.round(distance, 9)))])
        members = [first, *(int(index) for index in part if index != first)]
        found.append(Group(points[first], tuple(points[index] for index in members)))
    return found


def _places(points: Sequence[Point], axes: Sequence[Axis]) -> tuple[np.ndarray, list[tuple[str, ...]]]:
    """(points, axes) numbers from 0 to 1, and for each point the values that are no numbers."""
    places = np.zeros((len(points), max(1, len(axes))))
    words: list[list[str]] = [[] for _ in points]
    for column, axis in enumerate(axes):
        values = [point.values[axis.keys[0]] for point in points]
        numbers = [in_si(value) for value in values]
        if any(number is None for number in numbers):
            for own, value in zip(words, values, strict=True):
                own.append(json.dumps(value, sort_keys=True, default=str))
            continue
        row = np.asarray(numbers, dtype=float)
        span = float(np.ptp(row))
        places[:, column] = (row - row.min()) / span if span > 0.0 else 0.0
    return places, [tuple(own) for own in words]


def _parts(indices: np.ndarray, places: np.ndarray, words: list[tuple[str, ...]], size: int) -> list[np.ndarray]:
    alike: dict[tuple[str, ...], list[int]] = {}
    for index in indices:
        alike.setdefault(words[int(index)], []).append(int(index))
    return [part for group in alike.values() for part in _halved(np.asarray(group), places, size)]


def _halved(indices: np.ndarray, places: np.ndarray, size: int) -> list[np.ndarray]:
    if len(indices) <= size:
        return [indices]
    widest = int(np.argmax(np.round(np.ptp(places[indices], axis=0), 9)))
    order = indices[np.argsort(places[indices, widest], kind="stable")]
    # whole groups of `size` on the one side, so that few are nearly empty
    groups = -(-len(order) // size)
    middle = min(len(order) - 1, size * (groups // 2))
    return [*_halved(order[:middle], places, size), *_halved(order[middle:], places, size)]
