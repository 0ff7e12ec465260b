"""Values of one key that are planned one after the other, until one that does and one that does not are neighbours."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from nospill.core.units import format_quantity
from nospill.errors import NoSolutionError, NospillError
from nospill.planning.cycles import CyclePlanner
from nospill.planning.planner import Planner
from nospill.planning.varied import Varied, finding, planned
from nospill.plans.cycle import CyclePlan
from nospill.plans.plan import Plan

_STEPS, _GROWTH = (1, 2, 4, 8, 16), 1.15
"""Powers of a factor by which the value of the scenario is changed until the bound lies between: 1.15 to 9.4."""
_DIGITS = 4
"""Significant digits of values that are tried."""


@dataclass(frozen=True, slots=True)
class Tried:
    """A value that was planned.

    Attributes:
        value: as in a scenario file.
        number: the same without its unit.
        duration: of its motion, s; None where there is none.
        why_not: why it does not do, one sentence; empty where it does.
    """

    value: Any
    number: float
    duration: float | None
    why_not: str

    @property
    def does(self) -> bool:
        """Whether its motion is certified and takes no longer than is asked for."""
        return not self.why_not

    @property
    def is_too_long(self) -> bool:
        """Whether its motion is certified and takes longer."""
        return self.duration is not None and self.why_not == _seconds(self.duration)


OnTrial = Callable[[Tried], object]
"""Called with every value as it is planned."""


class Trials:
    """Values that are planned one after the other, each once."""

    def __init__(self, base: Varied, key: str, within: float, unit: str | None, progress: OnTrial | None) -> None:
        self._base, self._key, self._within, self._unit, self._progress = base, key, within, unit, progress
        self._found: dict[float, Tried] = {}
        self._plans: dict[float, Plan | CyclePlan] = {}
        self._near: Planner | CyclePlanner | None = None

    @property
    def tried(self) -> tuple[Tried, ...]:
        """In the order of the values."""
        return tuple(sorted(self._found.values(), key=lambda item: item.number))

    def plan_of(self, trial: Tried) -> Plan | CyclePlan:
        """The motion of a value that does."""
        return self._plans[trial.number]

    def at(self, number: float, *, cold: bool = False) -> Tried:
        """What becomes of a value; planned from nothing if asked for, though it was planned before."""
        number = float(f"{number:.{_DIGITS}g}")
        if number in self._found and not cold:
            return self._found[number]
        value = number if self._unit is None else f"{number:.{_DIGITS}g} {self._unit}".rstrip()
        duration, why_not = self._outcome(number, value, cold)
        found = Tried(value, number, duration, why_not)
        before = self._found.get(number)
        if before is None or (found.duration or math.inf) < (before.duration or math.inf):
            self._found[number] = found
        if self._progress is not None:
            self._progress(found)
        return found

    def _outcome(self, number: float, value: Any, cold: bool) -> tuple[float | None, str]:
        planner = self._base.planner() if cold or self._near is None else copy.copy(self._near)
        try:
            plan = planned(planner, self._base.changed({self._key: value}))
        except NospillError as error:
            return None, " ".join(str(error).split())
        if not plan.certificate.ok:
            return plan.duration, finding(plan)
        if not self._plans:
            self._near = planner  # none does yet: the value before is nearer than nothing
        if plan.duration > self._within * (1.0 + 1e-9):
            return plan.duration, _seconds(plan.duration)
        self._near, self._plans[number] = planner, plan
        return plan.duration, ""

    def around(self, start: float, sign: float) -> tuple[Tried, Tried | None]:
        """A value that does and one beyond it that does not; raises NoSolutionError."""
        last = self.at(start)
        away = sign if last.does else -sign
        for step in _STEPS:
            found = self.at(start * _GROWTH ** (away * step))
            if found.does != last.does:
                return (last, found) if last.does else (found, last)
            if not last.does and found.duration is None and last.duration is not None:
                return self._before(last, found)
            last = found
        if last.does:
            return last, None
        raise self._nothing()

    def _before(self, slow: Tried, none: Tried) -> tuple[Tried, Tried]:
        """A value that does, between one whose motion is too slow and one without any, and the slow one beside it."""
        for _ in _STEPS:
            middle = self.at(0.5 * (slow.number + none.number))
            if middle.does:
                return middle, slow
            slow, none = (slow, middle) if middle.duration is None else (middle, none)
        raise self._nothing()

    def at_ends(self, numbers: list[float], sign: float) -> tuple[Tried, Tried | None]:
        """The same of two values to search between."""
        inner, outer = sorted(numbers, key=lambda number: sign * number)
        good = self.at(inner)
        if not good.does:
            raise self._nothing()
        bad = self.at(outer)
        return (bad, None) if bad.does else (good, bad)

    def bisected(self, good: Tried, bad: Tried | None, precision: float) -> tuple[Tried, Tried | None]:
        """Two values as near to each other as is asked for."""
        while bad is not None and abs(bad.number - good.number) > precision * abs(good.number):
            middle = self.at(0.5 * (good.number + bad.number))
            if middle.number in (good.number, bad.number):
                break
            good, bad = (middle, bad) if middle.does else (good, middle)
        return good, bad

    def _nothing(self) -> NoSolutionError:
        planned = [item for item in self.tried if item.duration is not None]
        if not planned:
            first = self.tried[0]
            return NoSolutionError(f"no value of {self._key} has a motion; with {first.value}: {first.why_not}")
        fastest = min(planned, key=lambda item: item.duration or 0.0)
        longest = format_quantity(self._within, "time", digits=4)
        return NoSolutionError(
            f"no value of {self._key} was found that does within {longest}; the nearest, {fastest.value}: "
            f"{fastest.why_not}"
        )


def _seconds(duration: float) -> str:
    return f"{duration:.3f} s"
