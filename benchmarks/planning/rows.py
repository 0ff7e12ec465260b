"""Lines of the benchmark's tables, with their targets."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.planning.measurements import DIFFERENT, INTERVALS, WELLS, WHOLE_EXAMPLES
from benchmarks.planning.scenes import CHANGES, LARGER_CHANGES, UNSEEN

_FEW = 3
"""Digits of times and ratios."""


@dataclass(frozen=True)
class Line:
    """One line of a table.

    Attributes:
        what: is measured.
        clock: s, of all runs. processor: s, likewise; empty where it was not measured.
        ratio: what the target speaks of. of: of what it is one. target: its limit. most: whether that is an upper one.
    """

    what: str
    clock: Sequence[float]
    processor: Sequence[float] = ()
    ratio: float | None = None
    of: str = ""
    target: float | None = None
    most: bool = True

    @property
    def verdict(self) -> str:
        """Whether the target is met; empty where there is none."""
        if self.target is None or self.ratio is None:
            return ""
        return "met" if (self.ratio <= self.target) == self.most else "missed"

    @property
    def cells(self) -> list[str]:
        """Of the table."""
        times = [figure for runs in (self.clock, self.processor) for figure in _median_and_p98(runs)]
        ratio = "" if self.ratio is None else f"{self.ratio:.{_FEW}g}"
        target = "" if self.target is None else f"{'≤' if self.most else '≥'} {self.target:.{_FEW}g}"
        return [self.what, *times, ratio, self.of, target, self.verdict]


def _median_and_p98(runs: Sequence[float]) -> tuple[str, str]:
    """Texts; of few runs the 98th percentile is nearly the longest, of one nothing is said."""
    if not runs:
        return "", ""
    longest = "" if len(runs) == 1 else f"{np.percentile(runs, 98):.{_FEW}f}"
    return f"{statistics.median(runs):.{_FEW}f}", longest


@dataclass(frozen=True)
class Found:
    """Measurements by key; those that failed are not there."""

    measurements: Mapping[str, Mapping[str, Any]]

    def __contains__(self, key: str) -> bool:
        return "all_seconds" in self.measurements.get(key, {})

    def of(self, key: str) -> Mapping[str, Any]:
        """The figures of a measurement."""
        return self.measurements[key]

    def changes(self, key: str, names: Iterable[str]) -> list[Mapping[str, Any]]:
        """The figures of some changes of a warm measurement; none where it is not there."""
        found = self.measurements.get(key, {}).get("changes", {})
        return [found[name] for name in names if name in found]

    def seconds(self, key: str) -> float:
        """Median of the processor time, of an older measurement of the clock, s."""
        return statistics.median(_runs([self.of(key)], "processor") or self.of(key)["all_seconds"])

    def ratio(self, key: str, other: str) -> float | None:
        """Of two times; None where they were not measured alternately in one run, or one did not converge."""
        if other not in self or any(not self.converged(one) for one in (key, other)):
            return None
        together = self.of(key).get("run") == self.of(other).get("run")
        return self.seconds(key) / self.seconds(other) if together else None

    def converged(self, key: str) -> bool:
        """Whether a baseline did; of one that did not only the time is known that it had."""
        return self.of(key).get("status", "Solve_Succeeded") == "Solve_Succeeded"

    def line(self, key: str, ratio: float | None = None, of: str = "", target: float | None = None) -> Line:
        """Of one measurement."""
        return _line(key, [self.of(key)], ratio, of, target)


def _runs(figures: Sequence[Mapping[str, Any]], kind: str) -> list[float]:
    return [run for one in figures for run in one.get(f"all_{kind}", ())]


def _line(what: str, figures: Sequence[Mapping[str, Any]], ratio: float | None, of: str, target: float | None) -> Line:
    return Line(what, _runs(figures, "seconds"), _runs(figures, "processor"), ratio, of, target)


_COLD_TARGETS = {"cold matrix-liquid-tilt": 1.0, "cold mixed-tray": 1.4}
"""s of processor time."""


def whole(found: Found) -> Iterator[Line]:
    """The whole physics: examples as they stand, after changes too, and the command."""
    for name in WHOLE_EXAMPLES:
        key = f"cold {name}"
        if key in found:
            target, seconds = _COLD_TARGETS.get(key), found.seconds(key)
            duration = found.of(key)["duration"]
            shown = (seconds, "s of processor time") if target else (seconds / duration, "of the motion")
            yield found.line(key, *shown, target)
        changes = found.changes(f"warm {name}", CHANGES)
        if changes:
            warm = sum(one["warm"] for one in changes)
            ratio = statistics.median(_runs(changes, "processor")) / found.seconds(key) if key in found else None
            label = f"changed {name}" + ("" if warm == len(changes) else f" ({len(changes) - warm} planned anew)")
            yield _line(label, changes, ratio, "of the cold plan", 0.25)
    for key, target in {"process, second run": 0.55, "process with figures, second run": None}.items():
        if key in found:
            yield found.line(key, found.seconds(key), "s of processor time", target)
    for key in ("process, cold cache", "imports of a plan"):
        if key in found:
            yield found.line(key)


def published(found: Found) -> Iterator[Line]:
    """The published physics, against the published transcription."""
    for key in ("baseline liquid", "baseline rigid"):
        if key in found:
            stopped = "" if found.converged(key) else ", not converged"
            yield _line(f"{key} ({found.of(key)['iterations']} iterations{stopped})", [found.of(key)], None, "", None)
    for key, reference, target in (
        ("one mode: cold matrix-liquid", "baseline liquid", 100.0),
        ("one mode: cold matrix-rigid", "baseline rigid", 12.0),
        ("one mode: no compiler matrix-liquid", "baseline liquid", 45.0),
        ("one mode: no compiler matrix-rigid", "baseline rigid", 4.0),
    ):
        if key in found:
            slower = found.ratio(key, reference)
            faster = None if slower is None else 1.0 / slower
            figures = found.of(key)
            clock, processor = _runs([figures], "seconds"), _runs([figures], "processor")
            yield Line(key, clock, processor, faster, f"times faster than {reference}", target, most=False)
    if "one mode: cold matrix-liquid-tilt" in found:
        key = "one mode: cold matrix-liquid-tilt"
        yield found.line(key, found.seconds(key) / found.of(key)["duration"], "of the motion", 0.8)
    limits = {"matrix-liquid": 0.05, "matrix-liquid-tilt": 0.1}
    for name, limit in limits.items():
        for size, names, target in (("changed", CHANGES, limit), ("changed by more", LARGER_CHANGES, 0.3)):
            changes = found.changes(f"one mode: warm {name}", names)
            if changes:
                shares = [run / one["duration"] for one in changes for run in one["all_processor"]]
                label, median = f"one mode: {size} {name}", statistics.median(shares)
                yield _line(label, changes, median, "of the motion", target)
    if "toppra, rigid on a level tray" in found:
        key = "toppra, rigid on a level tray"
        yield found.line(key, found.ratio(key, "one mode: cold matrix-rigid"), "of one mode: cold matrix-rigid")


def growth(found: Found) -> Iterator[Line]:
    """Structures that are new, many objects, fine grids, memory: with the published physics."""
    for name in UNSEEN:
        for cache, target in (("blocks compiled", 1.5), ("empty cache", 3.0)):
            key = f"first plan, {name}, {cache}"
            if key in found and found.of(key).get("again"):
                ratio = found.of(key)["seconds"] / found.of(key)["again"]
                yield found.line(key, ratio, "of the second, by the clock", target)
    for key, reference, target in (
        ("32 cups", "4 cups", 10.0),
        (f"{DIFFERENT[-1]} different cups", f"{DIFFERENT[0]} different cups", 20.0),
        *(
            (f"{count} wells and vials", "one mode: cold matrix-liquid", 5.0 if count == 132 else None)
            for count in WELLS
        ),
        (f"N = {INTERVALS[-1]}", f"N = {INTERVALS[0]}", 4.2),
    ):
        if key in found:
            yield found.line(key, found.ratio(key, reference), f"of {reference}", target)
    memory = {key: value["peak_memory_mb"] for key, value in found.measurements.items() if "peak_memory_mb" in value}
    memory = {key: most for key, most in memory.items() if key in found and not key.startswith(("baseline", "toppra"))}
    if memory:
        key = max(memory, key=lambda one: memory[one])
        yield _line(f"peak memory: {key}", [found.of(key)], memory[key], "MB", 600.0)


TABLES: dict[str, Callable[[Found], Iterator[Line]]] = {
    "The whole physics, as the examples stand": whole,
    "One mode and linear heights, as published": published,
    "More of everything, one mode": growth,
}
