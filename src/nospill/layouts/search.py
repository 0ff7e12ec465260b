"""The search for a layout: steps along the multipliers' derivatives, from several starts of which the better go on.

A step is a linear program within a trust region: duration to the first order (`Planner.duration_change`), distances
between objects and to the edge of the tray to the first order, bounds. It is taken if the motion that is planned there,
from the one before, is certified and shorter; else the region shrinks. So no motion that fails ends the search, and the
duration needs no derivative where the order of events along the motion changes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nospill.certification.wording import describe
from nospill.core.units import as_written
from nospill.errors import NoSolutionError, NospillError, ScenarioError
from nospill.layouts.record import Layout, Trial
from nospill.layouts.spacing import Spacing
from nospill.layouts.variables import Variables, variables_of
from nospill.planning.planner import Planner, plan
from nospill.plans.plan import Plan
from nospill.scenario.loading import ScenarioSource, load
from nospill.scene.scene import Scene

USUAL_PLANS = 30
"""Layouts that are planned."""

OnTrial = Callable[[Trial], object]
"""Called with every layout as it is planned."""

_RADIUS, _LEAST_RADIUS, _GROWTH, _SHRINKAGE = 0.15, 2e-3, 1.6, 0.4
"""Trust region, parts of the ranges: at first, where a search ends, and its factors after a step taken or not."""
_DERIVATIVE_STEP = 1e-4
"""Part of a range by which a number is moved for its derivative."""
_WORTH = 1e-4
"""Part of the duration that a step must promise, about what it is found to."""
_STARTS, _PART_OF_STARTS = 6, 6
"""Most starts, and plans for each start at least."""
_DRAWS = 2000
"""Random places that are looked at for one start whose objects stand apart."""
_TOUCHING = 1e-9
_BACK = 0.7
"""Factor on a step at whose end objects overlap, which the first order does not see."""


def layout(
    scene: Scene | ScenarioSource,
    free: Mapping[str, Any],
    *,
    plans: int = USUAL_PLANS,
    seed: int = 0,
    progress: OnTrial | None = None,
) -> Layout:
    """Find values of a scenario's keys for the shortest certified motion.

    The best of several searches is kept: one from the scenario as stated, the others from random layouts. That there is
    no better one is not proven.

    Args:
        scene: a scene, or what `load` takes.
        free: dotted key -> [least, greatest], each as in the file: a number or a list of them, as
            {"tray.offset": ["80 mm", "150 mm"]}. The place of an object on the tray, "cargo.c1.at" or "cargo.*.at" for
            all, may have None: anywhere on the tray.
        plans: how many layouts are planned.
        seed: of the random starts.
        progress: called with every layout as it is planned.

    Raises:
        ScenarioError: a key is none of numbers, or its range is none.
        NoSolutionError: no layout that was tried has a certified motion; the message has the last reason.
    """
    base = scene.require_as_read() if isinstance(scene, Scene) else load(scene)
    if isinstance(plans, bool) or not isinstance(plans, int) or not 1 <= plans <= 10_000:
        raise ScenarioError(f"plans {as_written(plans)} must be a whole number from 1 to 10000")
    variables = variables_of(base, free)
    trials = _Trials(base, variables, plans, progress)
    starts = _starts(base, variables, min(_STARTS, max(1, plans // _PART_OF_STARTS)), seed)
    searches = [_Search(trials, values, number) for number, values in enumerate(starts)]
    before = searches[0].best
    alive = searches
    while trials.left > 0 and (alive := _going_on(alive)):
        rounds = max(1, trials.left // (2 * len(alive))) if len(alive) > 1 else trials.left
        for search in alive:
            search.go_on(rounds)
        alive = alive[: max(1, (len(alive) + 1) // 2)] if len(alive) > 1 else alive
    found = min((item for item in searches if item.best is not None), key=_Search.duration, default=None)
    if found is None or found.best is None:
        raise NoSolutionError(f"none of {len(trials.done)} layouts has a certified motion; {trials.done[-1].why_not}")
    best, values = _planned_from_nothing(found.best), variables.changes(found.values)
    if before is not None and before.duration <= best.duration:
        best, values = before, {}
    return Layout(before, best, values, tuple(trials.done), trials.stuck)


def _planned_from_nothing(warm: Plan) -> Plan:
    """The shorter of a plan and the same planned from nothing: where a search began decides which optimum it is."""
    try:
        cold = plan(warm.scene)
    except NospillError:
        return warm
    return cold if cold.certificate.ok and cold.duration < warm.duration else warm


def _starts(base: Scene, variables: Variables, count: int, seed: int) -> list[np.ndarray]:
    """The scenario as stated, and random layouts whose objects stand apart, as many as are found."""
    random, spacing = np.random.default_rng(seed), Spacing(base, variables)
    found = [variables.stated]
    for _ in range(count - 1):
        for _ in range(_DRAWS):
            values = variables.low + random.uniform(size=len(variables.low)) * variables.span
            if np.all(spacing.distances(values) >= 0.0):
                found.append(values)
                break
    return found


def _going_on(searches: list[_Search]) -> list[_Search]:
    """Those that are not over, the shortest motion first; those without one last."""
    return sorted((item for item in searches if not item.is_over), key=_Search.duration)


class _Trials:
    """Layouts that are planned one after the other."""

    def __init__(self, base: Scene, variables: Variables, count: int, progress: OnTrial | None) -> None:
        self.base, self.variables, self.spacing = base, variables, Spacing(base, variables)
        self.left, self.done, self.stuck = count, list[Trial](), dict[str, str]()
        self._progress = progress

    def plan(self, planner: Planner, values: np.ndarray, start: int) -> Plan | None:
        """The certified motion of a layout; None where there is none, and the trial says why."""
        self.left -= 1
        changes, found, why_not = self.variables.changes(values), None, ""
        try:
            scene = self.base if start == 0 and values is self.variables.stated else self.base.changed(changes)
            found = planner.plan(scene)
            if not found.certificate.ok:
                found, why_not = None, describe(found.certificate.worst)
        except NospillError as error:
            why_not = str(error)
        trial = Trial(changes, start, None if found is None else found.duration, why_not)
        self.done.append(trial)
        if self._progress is not None:
            self._progress(trial)
        return found

    def slopes(self, planner: Planner, values: np.ndarray) -> np.ndarray:
        """(n,) derivatives of the duration of the planner's last motion, s per unit of each number.

        Zero where the scenario cannot be moved either way; for another reason than that objects touch, `stuck` has it.
        """
        found = np.zeros(len(values))
        for index, span in enumerate(self.variables.span):
            why = ""
            for step in (_DERIVATIVE_STEP * span, -_DERIVATIVE_STEP * span) if span else ():
                moved = values.copy()
                moved[index] += step
                try:
                    scene = self.base.changed(self.variables.exactly(moved))
                    found[index] = planner.duration_change(scene) / step
                    why = ""
                    break
                except ScenarioError as error:
                    # objects that touch, or stand at the edge, move one way only
                    touch = bool(np.any(self.spacing.distances(moved) < 0.0))
                    why = why or ("" if touch else " ".join(str(error).split()))
            if why:
                self.stuck.setdefault(self.variables.keys[index], why)
        return found


@dataclass
class _Search:
    """From one start towards a layout from which no step leads to a shorter motion."""

    trials: _Trials
    values: np.ndarray
    number: int
    best: Plan | None = None
    is_over: bool = False
    _planner: Planner = field(init=False)
    _radius: float = _RADIUS
    _slopes: np.ndarray | None = None

    def __post_init__(self) -> None:
        self._planner = Planner()
        if self.trials.left > 0:
            self.best = self.trials.plan(self._planner, self.values, self.number)
        self.is_over = self.best is None

    def duration(self) -> float:
        """Of the shortest motion so far, s; infinite where there is none."""
        return np.inf if self.best is None else self.best.duration

    def go_on(self, count: int) -> None:
        """Plan so many layouts more, if as many are worth it."""
        for _ in range(min(count, self.trials.left)):
            step = self._step()
            if step is None:
                self.is_over = True
                return
            tried = self.values + step
            found = self.trials.plan(self._planner, tried, self.number)
            if found is not None and found.duration < self.duration():
                self.values, self.best, self._slopes = tried, found, None
                self._radius = min(_GROWTH * self._radius, 1.0)
            else:
                self._radius *= _SHRINKAGE
        self.is_over = self.is_over or self._radius < _LEAST_RADIUS

    def _step(self) -> np.ndarray | None:
        """The step that promises most within the trust region; None where none promises enough."""
        from scipy.optimize import linprog  # it takes longer to load than a layout of a small scene to plan

        known = self.trials.variables
        if self._slopes is None:
            self._slopes = self.trials.slopes(self._planner, self.values)
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
            if -self._slopes @ step > _WORTH * self.duration():
                return step
            self._radius *= _SHRINKAGE
        return None
