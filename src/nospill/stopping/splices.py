"""Where a stop takes over from its plan: both as one motion, which a receiver interpolates by one spline.

Acceleration goes on, jerk jumps. A spline through the samples of both rounds that off: it overshoots by a few per cent
of what the acceleration changes from one sample to the next, before the instant too, where the plan may stand on a
limit.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from nospill.certification.replay import MINIMUM_RATE, replay
from nospill.certification.traces import constraint_traces
from nospill.errors import ModelError
from nospill.laws.constraints.base import EvaluationPoint, RowId
from nospill.motion.interpolation import QUINTIC_SPLINE, JointSamples
from nospill.motion.trajectory import Trajectory
from nospill.plans.plan import Plan
from nospill.plans.state import MotionState, states_of
from nospill.scene.scene import Scene

BEFORE = 8
"""Samples before the instant, from which on the motion is looked at: the overshoot falls to 0.43 with each."""
_AFTER = 8
_POINTS = (EvaluationPoint.OBJECT, EvaluationPoint.JOINT, EvaluationPoint.TRAY)
_ROUNDING = 1e-6


@dataclass(frozen=True, slots=True)
class Splice:
    """A plan at an instant at which a stop may begin.

    Attributes:
        record: of the plan.
        t: s, the instant.
        lead: the state of the plan a few samples before it.
        scene: of a stop that begins in that one.
    """

    record: Trajectory
    t: float
    lead: MotionState
    scene: Scene

    def broken(self, stop: Trajectory) -> dict[RowId, float]:
        """Use of the limits that plan and stop together break near the instant.

        Args:
            stop: the samples of the stop, on a clock that begins with it.
        """
        rate, start = self.record.rate, self.record.t[0]
        row, first = round((self.t - start) * rate), round((self.lead.t - start) * rate)
        q = np.concatenate([self.record.joint_position[:row], stop.joint_position])
        spline = QUINTIC_SPLINE.motion(JointSamples(np.arange(len(q)) / rate, q))
        joined = joined_record(self.lead.rest, stop, (row - first) / rate)
        near = shortened(joined, row - first + _AFTER)
        try:
            played = replay(
                near, self.scene, motion=lambda t, order=0: spline(t + first / rate, order), rate=MINIMUM_RATE
            )
            traces = constraint_traces(near, self.scene, played, points=_POINTS)
        except (ModelError, np.linalg.LinAlgError):
            return {}  # the verdict on the stop itself says more
        uses = [(trace.id, float(np.max(trace.use))) for trace in traces]
        return {row_id: use for row_id, use in uses if use > 1.0 + _ROUNDING}


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


def shortened(record: Trajectory, rows: int) -> Trajectory:
    """The first rows of a record, without its liquids."""
    columns = {name: getattr(record, name)[:rows] for name in _columns(record)}
    return replace(record, t=record.t[:rows], slosh={}, **columns)


def _columns(record: Trajectory) -> list[str]:
    return [item.name for item in fields(record) if item.name not in ("t", "joints", "slosh", "in_motion")]
