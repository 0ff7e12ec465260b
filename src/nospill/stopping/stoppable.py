"""Plans that can be stopped in a given time at every instant: slowed down as far as that takes, and no farther.

What a stop takes is mostly the momentum that has to go, so the bound on the speed of the tray's centre is what is
looked for: plan, find the stops, and where one takes too long, plan again with a lower bound. The plan that comes out
is a usual one, of the scenario with that `motion.max_speed`, and can be checked as any.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from nospill.certification.replay import tray_from_joints
from nospill.errors import NoSolutionError, ScenarioError
from nospill.planning.log import OnProgress
from nospill.planning.planner import plan
from nospill.planning.request import requested_scene
from nospill.plans.plan import Plan
from nospill.scenario.loading import ScenarioSource
from nospill.scene.scene import Scene
from nospill.stopping.longest import longest_stop
from nospill.stopping.stops import EVERY

_TRIES = 8
"""Plans that are made at most, the first without a bound included."""
_LEAST_STEP, _CLOSE = 0.75, 1.04
"""Part of a speed that the next try has at least; ratio of one that holds and one that does not that is near enough."""


@dataclass(frozen=True, slots=True)
class StoppablePlan:
    """A plan and how soon it can be stopped.

    Attributes:
        plan: of the scenario with a bound on the speed of the tray's centre, where it needs one.
        within: s, in which it was asked to stop.
        longest: s, from any instant until the arm stands: the wait for the next instant at which a stop begins, and
            that stop.
        at: s, the instant of the stop for which it is longest.
        max_speed: m/s, that bound; None where the fastest motion can be stopped in time.
        fastest: s, duration of the fastest motion.
        tried: speed, m/s, duration and longest time to stop, s, of every plan that was made.
    """

    plan: Plan
    within: float
    longest: float
    at: float
    max_speed: float | None
    fastest: float
    tried: tuple[tuple[float, float, float], ...]

    @property
    def text(self) -> str:
        """What it costs, in words."""
        stops = f"stoppable within {self.within:g} s: the longest stop takes {self.longest:.3f} s, from {self.at:.3f} s"
        if self.max_speed is None:
            return f"{stops}; the fastest motion, without a bound on its speed"
        more = 100.0 * (self.plan.duration / self.fastest - 1.0)
        return (
            f"{stops}; motion.max_speed = {self.max_speed:.3f} m/s, {self.plan.duration:.3f} s in the place of "
            f"{self.fastest:.3f} s (+{more:.1f} %)"
        )


def plan_stoppable(
    scene: Scene | ScenarioSource,
    *,
    within: float | None = None,
    every: float = EVERY,
    progress: OnProgress | None = None,
    said: Callable[[str], None] | None = None,
) -> StoppablePlan:
    """Find the fastest motion from every instant of which a certified stop takes no longer than a given time.

    A stop begins at instants that are `every` apart, so that what one may take is the time less that. Fastest is meant
    among motions with a bound on the speed of the tray's centre, of the few bounds that are tried.

    Args:
        scene: the task, or what `load` takes.
        within: s; `motion.stoppable` of the scene when left out.
        every: s, between the instants at which stops begin.
        progress: called with where planning stands.
        said: called with what every plan gave.

    Raises:
        ScenarioError: no time is given, or one that leaves nothing for a stop; or as `plan` and `stops`.
        NoSolutionError: there is no motion, or none that can be stopped in time was found.
    """
    asked = requested_scene(scene)
    within = asked.motion.stoppable if within is None else within
    if within is None or not every < within <= 600.0:
        raise ScenarioError(
            f"{asked.name}: stoppable = {within}: a time above {every:g} s is needed, in which the motion can be "
            'stopped, as motion.stoppable = "0.6 s"'
        )
    free = asked.changed({"motion.stoppable": None})
    made = plan(free, progress=progress)
    fastest, speed = made.duration, _greatest_speed(made)
    bound: float | None = None
    best: StoppablePlan | None = None
    tried: list[tuple[float, float, float]] = []
    low, high = 0.0, speed
    while True:
        longest, at = _longest(made, every, within)
        tried.append((bound or speed, made.duration, longest))
        if said is not None:
            late = "" if longest <= within else ": too long"
            said(f"tray at up to {tried[-1][0]:.3f} m/s: {made.duration:.3f} s, longest stop {longest:.3f} s{late}")
        if longest <= within:
            best, low = StoppablePlan(made, within, longest, at, bound, fastest, tuple(tried)), bound or speed
        else:
            high = bound or speed
        if (best is not None and high < _CLOSE * low) or len(tried) == _TRIES:
            break
        bound = _rounded(np.sqrt(low * high) if best is not None else high * max(within / longest, _LEAST_STEP))
        made = plan(free.changed({"motion.max_speed": bound}), warm=made, progress=progress)
    if best is None:
        raise NoSolutionError(
            f"{asked.name}: no motion was found that stops within {within:g} s; with the tray at up to {high:.3f} m/s "
            f"the longest stop takes {longest:.3f} s, from {at:.3f} s. Allow more time, or state a lower "
            "motion.max_acceleration"
        )
    return replace(best, tried=tuple(tried))


def _longest(made: Plan, every: float, within: float) -> tuple[float, float]:
    """The longest time from any instant of a plan until the arm stands, s, and the instant of its stop, s.

    No stop of a plan that is not certified is known.
    """
    if not made.certificate.ok:
        return np.inf, 0.0
    return longest_stop(made, every, within)


def _greatest_speed(made: Plan) -> float:
    """Of the tray's centre, m/s."""
    record = made.trajectory
    columns = (record.joint_position, record.joint_speed, record.joint_acceleration)
    velocity = tray_from_joints(made.scene, list(columns))[0].velocity
    return float(np.max(np.linalg.norm(velocity, axis=1)))


def _rounded(speed: float) -> float:
    return float(np.floor(1e3 * speed) / 1e3)
