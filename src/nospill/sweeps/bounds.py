"""How far one number may go: the largest value of a key, or the least, whose motion takes at most a given time.

Duration is taken to grow with the value on the way to the bound. The bound is bracketed by steps that double, then
bisected; every plan starts from the one before that was fast enough, and the value just beyond the bound is planned
from nothing before it counts as too much. The value found has a certified plan; that none beyond it has is a finding of
the search, not a proof.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nospill.core.units import as_written, split_unit
from nospill.errors import ScenarioError
from nospill.planning.varied import Source, Varied, time_within, varied
from nospill.plans.cycle import CyclePlan
from nospill.plans.plan import Plan
from nospill.scenario.settings import stated_value
from nospill.sweeps.trials import OnTrial, Trials, Tried

USUAL_PRECISION = 0.01
"""Part of the value to which it is found."""

_NEAR, _FEW = 0.1, 2
"""Part of the answer within which values give the slope there, where there are more than so many."""
_LOOKS_AGAIN = 3
"""How often the value beyond the bound may turn out to be none when it is planned from nothing."""


@dataclass(frozen=True, slots=True)
class Bound:
    """The largest or the least value of a key within a time.

    Attributes:
        key: dotted, of the scenario.
        least: whether the least is asked for.
        within: s.
        value: the answer, as in a scenario file.
        plan: with it, certified.
        beyond: the nearest value beyond it that does not do; None where the search ended before one.
        tried: every value that was planned, in their order: duration over the value.
        unit: of the values' numbers; empty where they have none.
    """

    key: str
    least: bool
    within: float
    value: Any
    plan: Plan | CyclePlan
    beyond: Tried | None
    tried: tuple[Tried, ...]
    unit: str

    @property
    def slope(self) -> float | None:
        """Seconds a unit of the value about the answer: the line of least squares through what was planned near it.

        Durations are found to about a thousandth, so that values next to each other would not tell. None where there is
        one motion alone.
        """
        [answer] = [item.number for item in self.tried if item.value == self.value]
        motions = [(item.number, item.duration) for item in self.tried if item.duration is not None]
        motions.sort(key=lambda item: abs(item[0] - answer))
        near = [item for item in motions if abs(item[0] - answer) <= _NEAR * abs(answer)]
        near = np.array(near if len(near) > _FEW else motions[: _FEW + 1])
        return None if len(near) < 2 else float(np.polyfit(near[:, 0], near[:, 1], 1)[0])

    def __str__(self) -> str:
        return self.text

    @property
    def text(self) -> str:
        """The answer in one sentence."""
        word = "least" if self.least else "largest"
        found = f"{word} {self.key} within {self.within:.4g} s: {self.value} ({self.plan.duration:.3f} s)"
        if self.beyond is None:
            return f"{found}; the search ended there"
        return f"{found}; {self.beyond.value} does not do: {self.beyond.why_not}"


def largest(
    scene: Source,
    key: str,
    within: float | str,
    *,
    least: bool = False,
    between: tuple[Any, Any] | None = None,
    precision: float = USUAL_PRECISION,
    progress: OnTrial | None = None,
) -> Bound:
    """Find how far a number of a scenario may go with a motion that takes at most so long.

    Args:
        scene: a scene or a cycle, or what `load` or `load_cycle` takes; of a cycle the whole must be fast enough.
        key: dotted key of a number, as "cargo.c1.liquid_height"; "cargo.*.max_slosh_height" is that of all objects.
        within: longest duration, s or text with a unit.
        least: find the least value instead, as of a friction or of a residual height.
        between: two values to search between; where None, from the scenario's own value on, which must be above 0.
        precision: part of the value to which it is found.
        progress: called with every value as it is planned.

    Raises:
        ScenarioError: the key is unknown or none of a number, or the time is none.
        NoSolutionError: no value was found that does; names the fastest.
    """
    base = varied(scene)
    seconds = time_within(within)
    if not 1e-4 <= precision < 1.0:
        raise ScenarioError(f"precision {precision:g} is out of range; it must be from 0.0001 to below 1")
    ends = [stated_value(base.table, key)] if between is None else list(between)
    numbers, unit, like = _numbers(key, ends)
    _require_one(base, key, ends)
    if between is None and numbers[0] <= 0.0:
        raise ScenarioError(f"{key} = {as_written(ends[0])} is not above 0; give two values to search between")
    trials = Trials(base, key, seconds, unit if isinstance(like, str) else None, progress)
    sign = -1.0 if least else 1.0
    good, bad = trials.around(numbers[0], sign) if between is None else trials.at_ends(numbers, sign)
    for _ in range(_LOOKS_AGAIN):
        good, bad = trials.bisected(good, bad, precision)
        if bad is None or bad.duration is None:
            break
        again = trials.at(bad.number, cold=True)
        if not again.does:
            bad = again
            break
        further = [item for item in trials.tried if not item.does and sign * item.number > sign * again.number]
        good, bad = again, min(further, key=lambda item: sign * item.number, default=None)
    return Bound(key, least, seconds, good.value, trials.plan_of(good), bad, trials.tried, unit)


def _numbers(key: str, values: list[Any]) -> tuple[list[float], str, Any]:
    """Values without their unit, which is the same; raises ScenarioError."""
    parts = [split_unit(value) for value in values]
    if any(part is None for part in parts) or len({part[1] for part in parts if part is not None}) != 1:
        what = " and ".join(map(as_written, values))
        raise ScenarioError(f"{key} = {what}: numbers of one unit are needed, as between 0.2 and 0.6")
    found = [part for part in parts if part is not None]
    return [number for number, _ in found], found[0][1], values[0]


def _require_one(base: Varied, key: str, values: list[Any]) -> None:
    """Raise ScenarioError where the scenario takes none of the values: an unknown key, for one."""
    refused = None
    for value in values:
        try:
            base.changed({key: value})
        except ScenarioError as error:
            refused = refused or error
        else:
            return
    if refused is not None:
        raise refused
