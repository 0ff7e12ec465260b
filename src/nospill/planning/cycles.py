"""From a cycle to its plan: leg after leg, each from what the one before it leaves."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping
from dataclasses import replace

from nospill.certification.certificate import judge
from nospill.errors import NoSolutionError, ScenarioError
from nospill.motion.holds import hold_periods
from nospill.planning.log import OnProgress
from nospill.planning.planner import Planner
from nospill.plans.cycle import CyclePlan, planned_cycle
from nospill.plans.plan import Plan, judged_plan
from nospill.plans.rows import with_residual_slosh
from nospill.plans.settling import settling_time
from nospill.scenario.cycles import load_cycle, with_dwells
from nospill.scenario.leg_entry import LONGEST_DWELL
from nospill.scenario.loading import ScenarioSource
from nospill.scene.cycle import Cycle, CycleLeg
from nospill.scene.scene import Scene

_MOST_DWELLS = 12
"""Dwells that are tried where the shortest is asked for: three periods of the slowest liquid."""
_CURE = 'Its liquids swing on from the leg before: give that one a longer dwell, or dwell = "shortest".'


def plan_cycle(
    cycle: Cycle | ScenarioSource,
    *,
    warm: CyclePlan | None = None,
    progress: OnProgress | None = None,
    said: Callable[[str], None] | None = None,
) -> CyclePlan:
    """Find the fastest motion of each leg of a cycle, from what the leg before it leaves, and certify all of it.

    Args:
        cycle: the task, or what `load_cycle` takes.
        warm: the plan of a similar cycle; each leg starts from the one of the same name, instead of searching.
        progress: called with where planning stands, leg by leg.
        said: called with the name of a leg before it is planned.

    Returns:
        The plan; its certificate is not ok where a row of a leg fails.

    Raises:
        ScenarioError: no valid scenario describes a cycle, or the arm cannot follow a leg's path from where it stands.
        NoSolutionError: a leg has no motion; names it and what is in the way.
        MissingExtraError: as for `plan`.
    """
    return CyclePlanner(warm).plan(cycle, progress=progress, said=said)


def _planned_cycle(
    task: Cycle,
    planners: Mapping[str, Planner],
    progress: OnProgress | None,
    said: Callable[[str], None] | None,
) -> CyclePlan:
    """`plan_cycle`, each leg by the planner of its name."""
    plans: list[Plan] = []
    for index, leg in enumerate(task.legs):
        if said is not None:
            said(leg.name)
        first = plans[0] if index == len(task.legs) - 1 else None
        if plans and task.legs[index - 1].dwell is None:
            plans[-1:] = _after_shortest_dwell(leg, plans[-1], first, planners[leg.name], progress)
        else:
            before = plans[-1] if plans else None
            plans.append(_planned(leg, before, first, planners[leg.name], progress))
    if task.legs[-1].dwell is None:  # what comes next begins with fresh liquids
        plans[-1] = _dwelling(plans[-1], _until_settled(plans[-1], task.legs[-1]))
    dwells = [one.scene.motion.hold_after for one in plans]
    return planned_cycle(with_dwells(task, dwells), plans)


class CyclePlanner:
    """Plans cycle after cycle, each leg from the one of the same name in the cycle before.

    Not thread-safe: one per thread. A copy by `copy.copy` goes on by itself.
    """

    def __init__(self, last: CyclePlan | None = None) -> None:
        """Start with nothing, or with an earlier plan."""
        self.last = last
        known = () if last is None else zip(last.cycle.legs, last.legs, strict=True)
        self._planners = {leg.name: Planner(own) for leg, own in known}

    def plan(
        self,
        cycle: Cycle | ScenarioSource,
        *,
        progress: OnProgress | None = None,
        said: Callable[[str], None] | None = None,
    ) -> CyclePlan:
        """`plan_cycle(cycle)`, warm from the last plan; raises the same."""
        task = cycle if isinstance(cycle, Cycle) else load_cycle(cycle)
        planners = {leg.name: copy.copy(self._planners.get(leg.name, Planner())) for leg in task.legs}
        self.last = _planned_cycle(task, planners, progress, said)
        self._planners = planners
        return self.last

    def duration_change(self, cycle: Cycle) -> float:
        """Seconds by which the last cycle would be longer in another one, to the first order; no motion is planned.

        The sum over its legs of `Planner.duration_change`. Each is taken to begin with the swing and in the joints that
        the leg before it leaves now: what a change does to a leg's swing at its end, and by it to the next leg, does
        not count, nor does a dwell.

        Raises:
            ScenarioError: no cycle was planned here yet, or this one has other legs, objects, liquids or rules.
        """
        if self.last is None or [leg.name for leg in cycle.legs] != list(self._planners):
            raise ScenarioError(f"{cycle.name}: no cycle of these legs was planned before; call plan first")
        return sum(self._planners[leg.name].duration_change(leg.scene) for leg in cycle.legs)


def _planned(
    leg: CycleLeg, before: Plan | None, first: Plan | None, planner: Planner, progress: OnProgress | None
) -> Plan:
    """The plan of a leg after another one; `first` is that of the first leg, where this is the last."""
    swings = False
    try:
        scene = leg.scene if before is None else with_residual_slosh(leg.scene, before)
        swings = any(item.filling is not None and item.filling.initial_swing is not None for item in scene.cargo)
        return planner.plan(scene if first is None else _back_to(first, scene), progress=progress)
    except (ScenarioError, NoSolutionError) as error:
        helps = f" {_CURE}" if swings and isinstance(error, NoSolutionError) else ""
        raise type(error)(f'leg "{leg.name}": {error}{helps}', error.reason) from error


def _back_to(first: Plan, scene: Scene) -> Scene:
    """The scene of the last leg: any way leads into the joints in which the first one begins."""
    if scene.source["path"]["type"] != "free":
        return scene
    return scene.changed({"path.goal": {"joints": first.trajectory.joint_position[0].tolist()}})


def _after_shortest_dwell(
    leg: CycleLeg, before: Plan, first: Plan | None, planner: Planner, progress: OnProgress | None
) -> list[Plan]:
    """The plan before with the shortest dwell that a leg bears, and the plan of the leg."""
    step = _quarter_period(before.scene)
    for number in range(_MOST_DWELLS + 1):
        waiting = _dwelling(before, number * step)
        try:
            found = _planned(leg, waiting, first, planner, progress)
        except NoSolutionError:
            if number == _MOST_DWELLS or step == 0.0:
                raise
            continue
        if found.certificate.ok or number == _MOST_DWELLS or step == 0.0:
            return [waiting, found]
    raise AssertionError("the last dwell is taken or refused")


def _quarter_period(scene: Scene) -> float:
    """Of the slowest liquid, in whole sample periods, s; 0 without liquids."""
    frequencies = [cargo.filling.modes.slowest.frequency for cargo in scene.cargo if cargo.filling is not None]
    return math.ceil(math.pi / 2.0 / min(frequencies) * scene.output_rate) / scene.output_rate if frequencies else 0.0


def _until_settled(planned: Plan, leg: CycleLeg) -> float:
    """The dwell after which what stays on the tray is at rest, s.

    Raises:
        NoSolutionError: it is longer than a dwell may be.
    """
    stays = tuple(item for item in planned.scene.cargo if item.name not in leg.unloaded)
    dwell = settling_time(replace(planned.scene, cargo=stays), planned.certificate)
    if dwell > LONGEST_DWELL:
        raise NoSolutionError(
            f'leg "{leg.name}": what stays on the tray rests after {dwell:.3g} s, and a dwell is at most '
            f"{LONGEST_DWELL:g} s; unload it, or state a dwell"
        )
    return dwell


def _dwelling(planned: Plan, dwell: float) -> Plan:
    """A plan with another dwell after its motion, judged with it."""
    scene = planned.scene.changed({"motion.hold_after": dwell})
    if hold_periods(scene.motion, scene.output_rate) == hold_periods(planned.scene.motion, scene.output_rate):
        return planned
    return judged_plan(scene, planned.trajectory, judge(planned.trajectory, scene), planned.report)
