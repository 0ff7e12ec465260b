"""The column of times of a table, found by its name and by what it is: it increases, by nearly even steps."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from nospill.core.units import listed
from nospill.errors import ScenarioError

LABORATORY_RATE = 500.0
"""Rows a second of a file without header and times, Hz: the laboratory's controller."""

_FACTORS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_SHORTEST, _LONGEST = 2.5e-4, 0.2
"""s; usual steps of recorders are between these, so that a step of 1 is a millisecond and one of 1000 a microsecond."""
_USUAL = ("t", "time", "timestamp", "stamp")
"""Names of times, the first that is there before others."""
_NAMED = re.compile(r"time|stamp|clock|ipoc|(?:^|[^a-z])(?:t|secs?|seconds|elapsed)$")
_WHOLE = re.compile(r"(.*?)(?:secs?|seconds)$")
_PARTS = ("nanosec", "nanosecs", "nsec", "nsecs", "nanoseconds")
_INCREASING, _EVEN = 0.9, 0.9
"""Parts of the steps of a clock that go forwards, and that are within half and twice the usual one."""
_FAR = 1e6
"""s; times beyond are told from the first one."""
_SAME_RATE = 0.01
"""Two clocks of one recorder agree within this part."""


@dataclass(frozen=True, slots=True, eq=False)
class Clock:
    """Times of the rows.

    Attributes:
        t: (m,) s; NaN where a row has none.
        said: where they are from, as "time from robot_time (s by its steps)".
        columns: names that it was read from.
    """

    t: np.ndarray
    said: str
    columns: tuple[str, ...]


def found_clock(origin: str, columns: Mapping[str, np.ndarray], units: Mapping[str, str]) -> Clock | None:
    """The clock among the columns of a table that are no joints; None where no column is one.

    Args:
        origin: the file, for messages.
        columns: (m,) by name; NaN where a row has no number.
        units: as the names say it: "s", "ms", "us", "ns", or "" where a name says nothing.

    Raises:
        ScenarioError: several that disagree, one whose unit cannot be told, or one that counts rows.
    """
    pair = _pair(columns)
    if pair is not None:
        whole, part = pair
        # relative first, so that nanoseconds stay in what a float keeps of seconds since 1970
        first = columns[whole][np.isfinite(columns[whole])][:1]
        t = (columns[whole] - (first[0] if len(first) else 0.0)) + 1e-9 * columns[part]
        return Clock(t, f"time from {whole} and {part}", pair)
    named = sorted(filter(_NAMED.search, columns), key=lambda name: (_rank(name), list(columns).index(name)))
    even = [name for name in named if _is_clock(columns[name])]
    if not even and named:
        even = named[:1]  # as it is: what is wrong with it is said by who reads its times
    if not even:
        return _unnamed(origin, columns, units)
    clocks = [_in_seconds(origin, name, columns[name], units.get(name, "")) for name in even]
    rates = [_step(clock.t) for clock in clocks]
    for clock, rate in zip(clocks[1:], rates[1:], strict=True):
        if abs(rate / rates[0] - 1.0) > _SAME_RATE:
            raise ScenarioError(
                f"{origin}: {clocks[0].columns[0]} and {clock.columns[0]} both look like times, and the second runs "
                f"{rate / rates[0]:.3g} times as fast; leave in the one that the robot's clock wrote"
            )
    return clocks[0]


def is_named(columns: Iterable[str]) -> bool:
    """Whether a column has a name of times."""
    return any(map(_NAMED.search, columns))


def _unnamed(origin: str, columns: Mapping[str, np.ndarray], units: Mapping[str, str]) -> Clock | None:
    """The one column that can be nothing but a clock, whatever its name."""
    likely = [name for name, values in columns.items() if _is_clock(values)]
    told = [name for name in likely if units.get(name, "") in _FACTORS]
    counters = [name for name in likely if name not in told and np.all(np.diff(columns[name]) == 1.0)]
    likely = [name for name in likely if name not in counters]
    if len(likely) == 1:
        return _in_seconds(origin, likely[0], columns[likely[0]], units.get(likely[0], ""))
    if likely:
        raise ScenarioError(
            f"{origin}: {listed(tuple(likely), last='and')} could each be times; name the right one t_s"
        )
    if counters:
        raise ScenarioError(
            f"{origin}: {counters[0]} counts the rows and is no time; give rows a second, as --rate 500"
        )
    return None


def _pair(columns: Mapping[str, np.ndarray]) -> tuple[str, str] | None:
    """Columns of whole seconds and of nanoseconds with one prefix, as ROS writes stamps."""
    for name in columns:
        match = _WHOLE.fullmatch(name)
        if match is not None and not match[1].endswith("nano"):
            for part in _PARTS:
                if (other := f"{match[1]}{part}") in columns and other != name:
                    return name, other
    return None


def _rank(name: str) -> int:
    return _USUAL.index(name) if name in _USUAL else len(_USUAL)


def _is_clock(values: np.ndarray) -> bool:
    """Whether values increase by nearly even steps."""
    known = values[np.isfinite(values)]
    steps = np.diff(known)
    if len(steps) < 2 or not np.median(steps) > 0.0:
        return False
    relative = steps / np.median(steps)
    return bool(np.mean(steps > 0.0) >= _INCREASING and np.mean((relative > 0.5) & (relative < 2.0)) >= _EVEN)


def _step(values: np.ndarray) -> float:
    """Usual step of a clock, in the mean over those that are not gaps."""
    steps = np.diff(values[np.isfinite(values)])
    usual = np.median(steps) if len(steps) else 0.0
    near = steps[np.abs(steps - usual) <= np.abs(usual)]
    return float(np.mean(near)) if len(near) else 0.0


def _in_seconds(origin: str, name: str, values: np.ndarray, unit: str) -> Clock:
    """A column as times: in the unit of its name, which its steps must bear out, or in the one that they tell."""
    step = _step(values)
    fitting = [known for known, factor in _FACTORS.items() if _SHORTEST <= factor * step < _LONGEST]
    if unit in _FACTORS:
        if fitting and unit not in fitting and not 1e-2 * _SHORTEST <= _FACTORS[unit] * step <= 5.0 * _LONGEST:
            raise ScenarioError(
                f"{origin}: {name} is named in {unit}, and its steps of {step:.4g} look like {fitting[0]}; "
                f"name it {name}_{fitting[0]}"
            )
        chosen, said = unit, unit
    elif step <= 0.0:
        chosen, said = "s", "s"
    elif len(fitting) == 1:
        chosen, said = fitting[0], f"{fitting[0]} by its steps"
    else:
        raise ScenarioError(
            f"{origin}: steps of {step:.4g} in {name} are of no unit of time that a recorder has; name it "
            f"{name}_s, {name}_ms, {name}_us or {name}_ns"
        )
    factor, first = _FACTORS[chosen], values[np.isfinite(values)][:1]
    # of a clock that counts from 1970 the float keeps no nanoseconds: it counts from the first row
    start = float(first[0]) if len(first) and abs(factor * first[0]) > _FAR else 0.0
    return Clock(factor * (values - start), f"time from {name} ({said})", (name,))


def rows_clock(rows: int, rate: float | None) -> Clock:
    """Times of rows that have none: so many a second."""
    chosen = LABORATORY_RATE if rate is None else rate
    why = "as the laboratory's files have; --rate says otherwise" if rate is None else "as given"
    return Clock(np.arange(rows) / chosen, f"{chosen:g} rows a second, {why}", ())


def missing_clock(origin: str, others: Sequence[str]) -> ScenarioError:
    """The sentence about a table with a header and no times."""
    shown = ", ".join(others)[:160] or "none"
    return ScenarioError(
        f"{origin}: no column of times among the others ({shown}): they are named, or increase by even steps; name it "
        "t_s, or give rows a second, as --rate 500"
    )
