"""Where a stop takes over from its plan: both as one motion, which a receiver interpolates by one spline.

Acceleration goes on, jerk jumps. A spline through the samples of both rounds that off: it overshoots by a few per cent
of what the acceleration changes from one sample to the next, before the instant too, where the plan may stand on a
limit. At the instant itself its speed is not the recorded one; a spline through the stop alone is off by another
amount, and the liquids, whose state is relative to the tray, would begin with a push that nobody gave them.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from nospill.motion.holds import held_trajectory
from nospill.motion.interpolation import QUINTIC_SPLINE, JointMotion, JointSamples
from nospill.motion.trajectory import Trajectory
from nospill.plans.plan import Plan
from nospill.plans.state import MotionState, states_of
from nospill.scene.scene import Scene

BEFORE = 8
"""Samples before the instant, from which on the motion is looked at: the overshoot falls to 0.43 with each."""

_KNOWN = 40
"""Samples before those, through which the spline is laid: what is before them changes nothing that can be seen."""


@dataclass(frozen=True, slots=True)
class Splice:
    """A plan at an instant at which a stop may begin.

    Attributes:
        record: of the plan.
        t: s, the instant.
        lead: the state of the plan a few samples before it.
        scene: of a stop that begins in that one, with the time for which the arm stands after it.
    """

    record: Trajectory
    t: float
    lead: MotionState
    scene: Scene

    @property
    def wait(self) -> float:
        """From the lead to the instant, s."""
        return self._rows / self.record.rate

    def joined(self, stop: Trajectory) -> tuple[Trajectory, JointMotion]:
        """Plan and stop from the lead on, on a clock that begins there, and what the joints do: one spline of it all.

        Args:
            stop: the samples of the stop, on a clock that begins with it.
        """
        joined, rate = joined_record(self.lead.rest, stop, self.wait), self.record.rate
        last = self._row(self.lead.t)
        first = max(last - _KNOWN, 0)
        held = held_trajectory(joined, self.scene.motion).joint_position
        q = np.concatenate([self.record.joint_position[first:last], held])
        start = self.record.joint_speed[first : first + 1], self.record.joint_acceleration[first : first + 1]
        in_motion = first > 0 or self.record.in_motion
        samples = JointSamples((np.arange(len(q)) - (last - first)) / rate, q, *start, in_motion=in_motion)
        return joined, QUINTIC_SPLINE.motion(samples)

    @property
    def _rows(self) -> int:
        return self._row(self.t) - self._row(self.lead.t)

    def _row(self, t: float) -> int:
        return round((t - self.record.t[0]) * self.record.rate)


def states_with_leads(plan: Plan, instants: np.ndarray) -> tuple[list[MotionState], list[MotionState]]:
    """The states of a plan at some instants (m,), s, and those a few samples before each.

    Raises:
        As `states_of`.
    """
    record = plan.trajectory
    leads = np.maximum(instants - BEFORE / record.rate, record.t[0])
    states = states_of(record, plan.scene, np.concatenate([instants, leads]))
    return states[: len(instants)], states[len(instants) :]


def joined_record(rest: Trajectory, stop: Trajectory, wait: float) -> Trajectory:
    """What is left of a plan until a time, s, and a stop that begins there; its liquids are those of a judgement."""
    rows = round(wait * rest.rate)
    columns = {name: np.concatenate([getattr(rest, name)[:rows], getattr(stop, name)]) for name in _columns(rest)}
    return replace(rest, t=np.arange(rows + len(stop.t)) / rest.rate, slosh={}, **columns)


def _columns(record: Trajectory) -> list[str]:
    return [item.name for item in fields(record) if item.name not in ("t", "joints", "slosh", "in_motion")]
