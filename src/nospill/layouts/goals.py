"""What a layout is to be best at: the shortest motion, or the largest margin within a time.

A goal plans a layout, once or several times, and says by one number how good it is; its derivatives follow from the
multipliers.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from typing import Protocol

from nospill.errors import NospillError
from nospill.layouts.margins import by_own_limits, margin_of, reserving
from nospill.planning.cycles import CyclePlanner
from nospill.planning.planner import Planner
from nospill.planning.varied import Varied, duration_change, finding, planned
from nospill.plans.cycle import CyclePlan
from nospill.plans.plan import Plan
from nospill.scene.cycle import Cycle
from nospill.scene.scene import Scene

_CLOSE, _AIM = 3e-3, 1e-3
"""Parts of the time: a motion that is so much shorter uses it up, and one that is aimed at."""
_MOST_PLANS = 6
"""For one layout."""
_SLOPE = 0.5
"""Of ln(duration) over ln(1/(1 - reserve)) where limits on accelerations decide: T^2 goes as 1/(1 - reserve)."""
_LEAST_SLOPE, _FARTHEST, _NEAREST = 0.1, 0.7, 2e-3
"""Least slope that is believed; the longest step of ln(1/(1 - reserve)), and a bracket that is worth no plan more."""
_INSIDE = 0.1
"""Part of a bracket that stays on either side of the next place."""
_MOST = 4.0
"""Of ln(1/(1 - reserve)): 98 %."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """A layout that was planned with a certified motion.

    Attributes:
        task: the layout, with the limits as stated.
        plan: of it; where a reserve is kept, by the limits less that.
        planner: that has just made it.
        value: how good it is: the least is best.
        reserve: part of the limits on liquids and contacts that the plan keeps back.
    """

    task: Scene | Cycle
    plan: Plan | CyclePlan
    planner: Planner | CyclePlanner
    value: float
    reserve: float = 0.0


class Goal(Protocol):
    """What is sought."""

    worth: float
    """Change of the value that a step must promise, about what it is found to, as a part of `size`."""

    def planned(self, task: Scene | Cycle, planner: Planner | CyclePlanner, near: Outcome | None) -> Outcome | str:
        """The outcome of a layout, or why there is none, in one sentence.

        Args:
            task: the layout.
            planner: plans it, and goes on from there.
            near: that of a layout nearby.
        """
        ...

    def change(self, found: Outcome, task: Scene | Cycle) -> float:
        """Of the value, to the first order, from an outcome to another layout; raises ScenarioError."""
        ...

    def size(self, found: Outcome) -> float:
        """What changes of the value are measured by."""
        ...

    def reached(self, found: Outcome) -> float:
        """What of the value is certified: the least is best."""
        ...

    def reserve_of(self, found: Outcome) -> float | None:
        """What it keeps back, where that is sought."""
        ...

    def answer(self, found: Outcome) -> Plan | CyclePlan:
        """The plan by the limits as stated."""
        ...


def length(plan: Plan | CyclePlan) -> float:
    """Duration, s; of a cycle without the rounding of its legs to whole sample periods, so that small gains count."""
    if not isinstance(plan, CyclePlan):
        return plan.duration
    return sum(leg.duration for leg in plan.legs) + sum(leg.dwell for leg in plan.times)


class Shortest:
    """The shortest motion or cycle."""

    worth = 1e-4

    def planned(self, task: Scene | Cycle, planner: Planner | CyclePlanner, near: Outcome | None) -> Outcome | str:
        """See `Goal.planned`: one plan."""
        found = _certified(planner, task)
        return found if isinstance(found, str) else Outcome(task, found, copy.copy(planner), length(found))

    def change(self, found: Outcome, task: Scene | Cycle) -> float:
        """See `Goal.change`."""
        return duration_change(found.planner, task)

    def size(self, found: Outcome) -> float:
        """The duration."""
        return found.value

    def reached(self, found: Outcome) -> float:
        """The duration."""
        return found.value

    def reserve_of(self, found: Outcome) -> float | None:
        """None."""
        return None

    def answer(self, found: Outcome) -> Plan | CyclePlan:
        """The plan itself."""
        return found.plan


@dataclass(frozen=True)
class LargestMargin:
    """The largest part of all limits on liquids and contacts that a motion within a time can keep back.

    The fastest motion that keeps a reserve takes the longer the larger that is; the largest is the one that uses up the
    time. It is found by the secant method within a bracket, on ln(duration) over ln(1/(1 - reserve)). What is left of
    the time counts by that line's usual slope, so that small gains do.

    Attributes:
        within: s.
    """

    within: float
    worth = 1e-3

    def planned(self, task: Scene | Cycle, planner: Planner | CyclePlanner, near: Outcome | None) -> Outcome | str:
        """See `Goal.planned`: up to six plans; one where it cannot keep back what the layout nearby does."""
        at = 0.0 if near is None else -math.log(1.0 - near.reserve)
        known: list[tuple[float, float]] = []  # places whose motions are short enough, with ln(duration/within)
        beyond: tuple[float, float | None] | None = None
        best: Outcome | None = None
        for _ in range(_MOST_PLANS):
            reserve = 1.0 - math.exp(-at)
            found = _certified(planner, _kept(task, reserve))
            excess = None if isinstance(found, str) else math.log(length(found) / self.within)
            if isinstance(found, str) or excess is None or excess > 0.0:
                if best is None:
                    return found if isinstance(found, str) else self._too_long(found, near)
                beyond = (at, excess)
            else:
                value = -reserve + excess * (1.0 - reserve) / _SLOPE
                best = Outcome(task, found, copy.copy(planner), value, reserve)
                known.append((at, excess))
            if known[-1][1] >= -_CLOSE or known[-1][0] >= _MOST:
                break
            if beyond is not None and beyond[0] - known[-1][0] < _NEAREST:
                break
            at = _next(known, beyond)
        assert best is not None  # else it was returned why not
        return best

    def _too_long(self, found: Plan | CyclePlan, near: Outcome | None) -> str:
        kept = "" if near is None or near.reserve == 0.0 else f" with {near.reserve:.1%} of its limits kept back"
        return f"takes {length(found):.3f} s{kept}, longer than {self.within:.4g} s"

    def change(self, found: Outcome, task: Scene | Cycle) -> float:
        """See `Goal.change`: the reserve that is given up for what the duration would grow by."""
        longer = duration_change(found.planner, _kept(task, found.reserve))
        return longer / length(found.plan) * (1.0 - found.reserve) / _SLOPE

    def size(self, found: Outcome) -> float:
        """One: a margin is a part."""
        return 1.0

    def reached(self, found: Outcome) -> float:
        """The margin by the limits as stated: rows that no reserve moves, as lift, may leave less than that."""
        margin = margin_of(self.answer(found), found.plan)
        return 0.0 if margin is None else -margin

    def reserve_of(self, found: Outcome) -> float | None:
        """See `Goal.reserve_of`."""
        return found.reserve

    def answer(self, found: Outcome) -> Plan | CyclePlan:
        """Judged by the limits as stated, so that the certificate shows the margin."""
        return by_own_limits(found.plan, found.task)


def _next(known: list[tuple[float, float]], beyond: tuple[float, float | None] | None) -> float:
    """Where ln(duration/within) is to be looked at next, from what is known of it below zero and beyond."""
    low, excess = known[-1]
    aim = -_AIM - excess
    if beyond is None:
        slope = _SLOPE if len(known) < 2 else (excess - known[-2][1]) / (low - known[-2][0])
        return min(low + min(aim / max(slope, _LEAST_SLOPE), _FARTHEST), _MOST)
    high, over = beyond
    part = 0.5 if over is None else aim / (over - excess)
    return low + min(max(part, _INSIDE), 1.0 - _INSIDE) * (high - low)


def _kept(task: Scene | Cycle, reserve: float) -> Scene | Cycle:
    return Varied(task).changed(reserving(task, reserve)) if reserve > 0.0 else task


def _certified(planner: Planner | CyclePlanner, task: Scene | Cycle) -> Plan | CyclePlan | str:
    """The certified plan, or why there is none."""
    try:
        found = planned(planner, task)
    except NospillError as error:
        return " ".join(str(error).split())
    return found if found.certificate.ok else finding(found)
