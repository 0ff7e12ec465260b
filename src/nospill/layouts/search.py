"""The search for a layout: steps along the multipliers' derivatives, from several starts of which the better go on.

A step is a linear program within a trust region: what is sought (`layouts.goals`: the duration, or the margin within a
time) to the first order by `Planner.duration_change`, distances between objects and to the edge of the tray to the
first order, bounds. It is taken if the motion that is planned there, from the one before, is certified and better; else
the region shrinks. So no motion that fails ends the search, and nothing needs a derivative where the order of events
along the motion changes.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nospill.core.units import as_written
from nospill.errors import NoSolutionError, ScenarioError
from nospill.layouts.goals import Goal, LargestMargin, Outcome, Shortest
from nospill.layouts.margins import margin_of, require_margin
from nospill.layouts.record import Layout, Trial
from nospill.layouts.spacing import Spacing
from nospill.layouts.variables import Variables, variables_of
from nospill.planning.cycles import CyclePlanner
from nospill.planning.planner import Planner
from nospill.planning.varied import Source, Varied, time_within, varied

USUAL_PLANS = 30
"""Layouts that are planned."""

OnTrial = Callable[[Trial], object]
"""Called with every layout as it is planned."""

_RADIUS, _LEAST_RADIUS, _GROWTH, _SHRINKAGE = 0.15, 2e-3, 1.6, 0.4
"""Trust region, parts of the ranges: at first, where a search ends, and its factors after a step taken or not."""
_DERIVATIVE_STEP = 1e-4
"""Part of a range by which a number is moved for its derivative."""
_STARTS, _PART_OF_STARTS = 6, 6
"""Most starts, and plans for each start at least."""
_DRAWS = 2000
"""Random places that are looked at for one start whose objects stand apart."""
_TOUCHING = 1e-9
_BACK = 0.7
"""Factor on a step at whose end objects overlap, which the first order does not see."""


def layout(
    scene: Source,
    free: Mapping[str, Any],
    *,
    within: float | str | None = None,
    plans: int = USUAL_PLANS,
    seed: int = 0,
    progress: OnTrial | None = None,
) -> Layout:
    """Find values of a scenario's keys for the shortest certified motion, or for the largest margin within a time.

    The best of several searches is kept: one from the scenario as stated, the others from random layouts. That there is
    no better one is not proven.

    Args:
        scene: a scene or a cycle, or what `load` or `load_cycle` takes.
        free: dotted key -> [least, greatest], each as in the file: a number or a list of them, as
            {"tray.offset": ["80 mm", "150 mm"]}. The place of an object on the tray, "cargo.c1.at" or "cargo.*.at" for
            all, may have None: anywhere on the tray.
        within: longest duration, s or text with a unit, of a cycle dwells included: the layout with the largest margin
            is sought, the part of all limits on liquids and contacts that a certified motion leaves at least. None for
            the shortest motion.
        plans: how many layouts are planned; each takes one plan, with `within` up to six.
        seed: of the random starts.
        progress: called with every layout as it is planned.

    Raises:
        ScenarioError: a key is none of numbers, or its range is none; the time is none, or nothing has a margin.
        NoSolutionError: no layout that was tried has a certified motion (within the time); the message has the last
            reason.
    """
    base = varied(scene)
    if isinstance(plans, bool) or not isinstance(plans, int) or not 1 <= plans <= 10_000:
        raise ScenarioError(f"plans {as_written(plans)} must be a whole number from 1 to 10000")
    goal = _goal(within)
    variables = variables_of(base, free)
    if isinstance(goal, LargestMargin):
        require_margin(base)
    trials = _Trials(base, variables, goal, plans, progress)
    starts = _starts(variables, trials.spacing, min(_STARTS, max(1, plans // _PART_OF_STARTS)), seed)
    searches = [_Search(trials, values, number) for number, values in enumerate(starts)]
    before = searches[0].best
    alive = searches
    while trials.left > 0 and (alive := _going_on(alive)):
        rounds = max(1, trials.left // (2 * len(alive))) if len(alive) > 1 else trials.left
        for search in alive:
            search.go_on(rounds)
        alive = alive[: max(1, (len(alive) + 1) // 2)] if len(alive) > 1 else alive
    found = min((item for item in searches if item.best is not None), key=_Search.reached, default=None)
    if found is None or found.best is None:
        time = "" if within is None else f" within {as_written(within)}"
        raise NoSolutionError(
            f"none of {len(trials.done)} layouts has a certified motion{time}; the last: {trials.done[-1].why_not}"
        )
    best, values = _planned_again(goal, base, found.best), variables.changes(found.values)
    if before is not None and goal.reached(before) <= goal.reached(best):
        best, values = before, {}
    stated = None if before is None else goal.answer(before)
    answer = stated if stated is not None and best is before else goal.answer(best)
    seconds = goal.within if isinstance(goal, LargestMargin) else None
    margins: list[float | None] = [None, None]
    if seconds is not None:
        pairs = [(answer, best), *([] if stated is None or before is None else [(stated, before)])]
        margins[: len(pairs)] = [margin_of(plan, outcome.plan) for plan, outcome in pairs]
    return Layout(stated, answer, values, tuple(trials.done), trials.stuck, seconds, *margins)


def _goal(within: float | str | None) -> Goal:
    if within is None:
        return Shortest()
    return LargestMargin(time_within(within))


def _planned_again(goal: Goal, base: Varied, warm: Outcome) -> Outcome:
    """The best of an outcome and the same planned from nothing: where a search began decides which optimum it is.

    A margin is looked for from the outcome on too, which may have left some of the time.
    """
    planners = [base.planner()] if isinstance(goal, Shortest) else [copy.copy(warm.planner), base.planner()]
    again = [goal.planned(warm.task, planner, warm) for planner in planners]
    return min([warm, *(one for one in again if isinstance(one, Outcome))], key=goal.reached)


def _starts(variables: Variables, spacing: Spacing, count: int, seed: int) -> list[np.ndarray]:
    """The scenario as stated, and random layouts whose objects stand apart, as many as are found."""
    random = np.random.default_rng(seed)
    found = [variables.stated]
    for _ in range(count - 1):
        for _ in range(_DRAWS):
            values = variables.low + random.uniform(size=len(variables.low)) * variables.span
            if np.all(spacing.distances(values) >= 0.0):
                found.append(values)
                break
    return found


def _going_on(searches: list[_Search]) -> list[_Search]:
    """Those that are not over, the best first; those without a motion last."""
    return sorted((item for item in searches if not item.is_over), key=_Search.value)


class _Trials:
    """Layouts that are planned one after the other."""

    def __init__(self, base: Varied, variables: Variables, goal: Goal, count: int, progress: OnTrial | None) -> None:
        self.base, self.variables, self.goal, self.spacing = base, variables, goal, Spacing(base, variables)
        self.left, self.done, self.stuck = count, list[Trial](), dict[str, str]()
        self._progress = progress

    def plan(
        self, planner: Planner | CyclePlanner, values: np.ndarray, start: int, near: Outcome | None
    ) -> Outcome | None:
        """What becomes of a layout; None where it has no certified motion, and the trial says why."""
        self.left -= 1
        changes = self.variables.changes(values)
        try:
            task = self.base.task if start == 0 and values is self.variables.stated else self.base.changed(changes)
            found = self.goal.planned(task, planner, near)
        except ScenarioError as error:
            found = " ".join(str(error).split())
        if isinstance(found, str):
            trial, found = Trial(changes, start, None, found), None
        else:
            trial = Trial(changes, start, found.plan.duration, "", self.goal.reserve_of(found))
        self.done.append(trial)
        if self._progress is not None:
            self._progress(trial)
        return found

    def slopes(self, found: Outcome, values: np.ndarray) -> np.ndarray:
        """(n,) derivatives of what is sought from a layout that was planned, per unit of each number.

        Zero where the scenario cannot be moved either way; for another reason than that objects touch, `stuck` has it.
        """
        slopes = np.zeros(len(values))
        for index, span in enumerate(self.variables.span):
            why = ""
            for step in (_DERIVATIVE_STEP * span, -_DERIVATIVE_STEP * span) if span else ():
                moved = values.copy()
                moved[index] += step
                try:
                    task = self.base.changed(self.variables.exactly(moved))
                    slopes[index] = self.goal.change(found, task) / step
                    why = ""
                    break
                except ScenarioError as error:
                    # objects that touch, or stand at the edge, move one way only
                    touch = bool(np.any(self.spacing.distances(moved) < 0.0))
                    why = why or ("" if touch else " ".join(str(error).split()))
            if why:
                self.stuck.setdefault(self.variables.keys[index], why)
        return slopes


@dataclass
class _Search:
    """From one start towards a layout from which no step leads to a better one."""

    trials: _Trials
    values: np.ndarray
    number: int
    best: Outcome | None = None
    is_over: bool = False
    _planner: Planner | CyclePlanner = field(init=False)
    _radius: float = _RADIUS
    _slopes: np.ndarray | None = None

    def __post_init__(self) -> None:
        self._planner = self.trials.base.planner()
        if self.trials.left > 0:
            self.best = self.trials.plan(self._planner, self.values, self.number, None)
        self.is_over = self.best is None

    def value(self) -> float:
        """Of the best layout so far; infinite where there is none."""
        return np.inf if self.best is None else self.best.value

    def reached(self) -> float:
        """What of it is certified; infinite where there is none."""
        return np.inf if self.best is None else self.trials.goal.reached(self.best)

    def go_on(self, count: int) -> None:
        """Plan so many layouts more, if as many are worth it."""
        for _ in range(min(count, self.trials.left)):
            step = self._step()
            if step is None:
                self.is_over = True
                return
            tried = self.values + step
            found = self.trials.plan(self._planner, tried, self.number, self.best)
            if found is not None and found.value < self.value():
                self.values, self.best, self._slopes = tried, found, None
                self._radius = min(_GROWTH * self._radius, 1.0)
            else:
                self._radius *= _SHRINKAGE
        self.is_over = self.is_over or self._radius < _LEAST_RADIUS

    def _step(self) -> np.ndarray | None:
        """The step that promises most within the trust region; None where none promises enough."""
        from scipy.optimize import linprog  # it takes longer to load than a layout of a small scene to plan

        assert self.best is not None  # else the search is over
        known, goal = self.trials.variables, self.trials.goal
        if self._slopes is None:
            self._slopes = self.trials.slopes(self.best, self.values)
        while self._radius >= _LEAST_RADIUS:
            reach = self._radius * known.span
            low, high = np.maximum(known.low - self.values, -reach), np.minimum(known.high - self.values, reach)
            spacing = self.trials.spacing
            room, slopes = spacing.distances(self.values), spacing.slopes(self.values)
            found = linprog(
                self._slopes,
                A_ub=-slopes if len(room) else None,
                b_ub=np.maximum(room, 0.0) if len(room) else None,
                bounds=np.column_stack([np.minimum(low, 0.0), np.maximum(high, 0.0)]),
            )
            step = found.x if found.success else np.zeros(len(self.values))
            while np.any(spacing.distances(self.values + step) < -_TOUCHING) and np.any(np.abs(step) > 1e-6):
                step = _BACK * step
            if -self._slopes @ step > goal.worth * goal.size(self.best):
                return step
            self._radius *= _SHRINKAGE
        return None
