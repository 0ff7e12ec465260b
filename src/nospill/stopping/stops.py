"""All stops of a plan: the spill-free one from every instant, and beside it the controller's own."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from nospill.compiled.codegen import compiles_afterwards
from nospill.core.files import atomic_folder, atomic_text
from nospill.errors import ScenarioError
from nospill.export import EXPORTERS
from nospill.plans.names import STOPS_FILE, STOPS_FOLDER
from nospill.plans.plan import Plan
from nospill.plans.state import MotionState, require_known_joints
from nospill.plans.stops import Stop, Stops, file_of
from nospill.robots.robot import Robot
from nospill.stopping.controller import braked, slowed_to_rest
from nospill.stopping.later import sooner_by_waiting
from nospill.stopping.own_way import along_own_way
from nospill.stopping.solving import joint_path_of, rest_of_plan, splice_at, stop_from
from nospill.stopping.splices import states_with_leads

EVERY = 0.02
"""s; from how many instants a stop is looked for."""
SLOWING = 0.25
"""s; in which a controller scales time to zero, and a joint whose acceleration nobody limits stops from full speed."""
_AFRESH = 5
"""At every so many instants a stop is looked for from afar too."""
_SHORTEST_LEFT = 0.06
"""s; before the end of the plan no stop is sooner than what is left of it."""

OnStop = Callable[[int, int], None]
"""Called with how many instants are done, of how many."""


@compiles_afterwards
def stops(
    plan: Plan,
    *,
    every: float = EVERY,
    residual: float = 1.0,
    deceleration: ArrayLike | None = None,
    slowing: float = SLOWING,
    progress: OnStop | None = None,
) -> Stops:
    """Find the fastest certified motion to rest from every instant of a plan, along what is left of its path or way.

    Each spills, slides and tips nothing, also while its liquids swing on after the end, which they may. What is left of
    the plan is always one, so that there is one from every instant. This is a motion, and no safety function.

    Args:
        plan: certified.
        every: s, between the instants.
        residual: how high liquids may swing on after a stop, over max_slosh_height; 0.2 is a calm one.
        deceleration: rad/s^2, one or (n,), with which the controller brakes each joint; when left out the limits of
            the arm's accelerations, or what stops a joint from its full speed in 0.25 s.
        slowing: s, in which the controller scales time to zero along the path.
        progress: called after every instant.

    Raises:
        ScenarioError: the plan is not certified, a number is none or not above zero, or the plan has what no state is
            known of: a range of speeds, a controller with delay or lag.
        NoSolutionError: no joint path leads along the path of the scene.
    """
    brake = _decelerations(deceleration, plan.scene.robot)
    for name, value in (("every", every), ("slowing", slowing)):
        if not 1e-3 <= value <= 60.0:
            raise ScenarioError(f"{name} = {value:g} s: a time of 0.001 to 60 s is needed")
    if not 0.0 < residual <= 1.0:
        raise ScenarioError(f"residual = {residual:g}: a part of max_slosh_height is needed, above 0 and up to 1")
    require_stoppable(plan)
    instants = np.arange(every, plan.duration - _SHORTEST_LEFT, every)
    if not len(instants):
        raise ScenarioError(f"every = {every:g} s: the motion takes {plan.duration:.3f} s, no instant lies within it")
    own_way = along_own_way(plan, every)
    states, leads = states_with_leads(own_way, instants)
    own, controller = [], []
    found = _one_by_one(own_way, states, leads, residual)
    for number, (stop, state, lead) in enumerate(zip(found, states, leads, strict=True), start=1):
        own.append(stop)
        splice = splice_at(own_way, state, lead, residual)
        controller += [braked(splice, brake), slowed_to_rest(splice, slowing)]
        if progress is not None:
            progress(number, len(states))
    own = _waiting(own_way, states, leads, own, residual)
    return Stops(
        plan.scene.name, plan.duration, tuple(own), tuple(controller), tuple(brake.tolist()), slowing, residual
    )


def _one_by_one(
    plan: Plan, states: Sequence[MotionState], leads: Sequence[MotionState], residual: float
) -> Iterator[Stop]:
    """The stop from every state, each solved from the one before it.

    Where none is found the next state is passed over: where one is found again after it, waiting for that is a stop.
    """
    joint_path, found, missed = joint_path_of(plan), None, False
    for number, (state, lead) in enumerate(zip(states, leads, strict=True), start=1):
        if missed:
            missed = False
            yield rest_of_plan(plan, state, residual)
            continue
        above = 0.0 if number % _AFRESH == 0 else math.inf
        stop, found = stop_from(plan, state, joint_path, found, residual=residual, afresh_above=above, lead=lead)
        missed = found is None
        yield stop


def _waiting(
    plan: Plan, states: Sequence[MotionState], leads: Sequence[MotionState], own: list[Stop], residual: float
) -> list[Stop]:
    """The stops of a plan, where it is sooner those of the next instant with what leads there."""
    for index in reversed(range(len(own) - 1)):
        own[index] = sooner_by_waiting(plan, states[index], leads[index], own[index], own[index + 1], residual)
    return own


def write_stops(found: Stops, plan: Plan, folder: str | Path) -> None:
    """Write the table into a plan folder and the samples of every stop below it, a file for joint controllers each.

    Raises:
        PlanFolderError: the disk refuses.
    """
    place = Path(folder)
    with atomic_folder(place / STOPS_FOLDER, replaceable=_is_library) as new:
        for stop in found.stops:
            if stop.is_sooner:
                EXPORTERS["csv"].write(stop.trajectory.joint_samples, plan.scene, new / file_of(stop))
    atomic_text(place / STOPS_FILE, json.dumps(found.to_dict(), indent=1, allow_nan=False) + "\n")


def _is_library(names: set[str]) -> bool:
    return all(name.endswith(".csv") for name in names)


def require_stoppable(plan: Plan) -> None:
    """Refuse a plan of which no stop, or no state, is known.

    Raises:
        ScenarioError: it is not certified, or has a range of speeds or a controller with delay or lag.
    """
    name, rules = plan.scene.name, plan.scene.motion
    if not plan.certificate.ok:
        raise ScenarioError(f"{name}: this plan is not certified, and what is left of it is no stop: plan it anew")
    if rules.speed_range is not None:
        raise ScenarioError(
            f"{name}: motion.speed_range is stated, and where a slower motion is stopped is another state; plan "
            "without it to find stops at full speed"
        )
    require_known_joints(plan.scene)


def _decelerations(stated: ArrayLike | None, robot: Robot) -> np.ndarray:
    """Of each joint (n,), rad/s^2."""
    if stated is None:
        return robot.max_speed / SLOWING if robot.max_acceleration is None else robot.max_acceleration
    try:
        values = np.broadcast_to(np.asarray(stated, dtype=float), len(robot.joints)).copy()
    except (TypeError, ValueError):
        raise ScenarioError(
            f"deceleration = {stated!r}: one number in rad/s^2 is needed, or one for each of {', '.join(robot.joints)}"
        ) from None
    if not np.all((values > 0.0) & np.isfinite(values)):
        raise ScenarioError(
            f"deceleration = {values.tolist()} rad/s^2: every joint needs one above 0, as 6 rad/s^2; leave it out for "
            "the limits of the arm"
        )
    return values
