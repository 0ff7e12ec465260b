"""What a plan records in addition to its motion: its largest figures, and what planning cost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from nospill.certification.certificate import Judgement
from nospill.certification.left_after_end import LeftAfterEnd
from nospill.certification.limiting import limiting_rows
from nospill.certification.other_speeds import SpeedUse
from nospill.certification.survived import Survival
from nospill.laws.constraints.joint_speed import JointSpeed
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.scene.scene import Scene


@dataclass(frozen=True, slots=True)
class MotionMaxima:
    """Largest figures of a motion, as the judge saw it.

    Attributes:
        tray_acceleration: of the tray's centre, m/s^2.
        tray_angular_acceleration: rad/s^2.
        tilt: of the tray's normal from the vertical, rad.
        joint_speed_use: largest joint speed as a fraction of its limit.
        slosh_height: m, by object with liquid.
        residual_height: m, by object with liquid.
        time_at_limit: part of the motion's time for which it is at a limit that it comes near, by label of the row.
        other_speeds: uses of the limits on objects at lower speeds; None where nobody has looked.
        survival: what the motion survives of an arm that does not quite track it; None where nobody has looked.
        left: what is left of each liquid's waves after the end; None where nobody has looked.
    """

    tray_acceleration: float
    tray_angular_acceleration: float
    tilt: float
    joint_speed_use: float
    slosh_height: dict[str, float]
    residual_height: dict[str, float]
    time_at_limit: dict[str, float] = field(default_factory=dict)
    other_speeds: tuple[SpeedUse, ...] | None = None
    survival: Survival | None = None
    left: dict[str, LeftAfterEnd] | None = None


GIVEN = "given"
"""Status of a motion that nothing here planned."""

_AGREED = 5e-3


@dataclass(frozen=True, slots=True)
class Starts:
    """What the starting points led to.

    Attributes:
        tried: how many.
        converged: how many of them.
        agreed: how many ended within 0.5 % of the best.
        durations: end time of each that converged on the coarse grid, s.
    """

    tried: int
    converged: int
    agreed: int
    durations: tuple[float, ...]

    @classmethod
    def of(cls, starts: Sequence[float | None]) -> Starts:
        """What starts led to, by the end time of each, s; None where it did not converge."""
        durations = tuple(duration for duration in starts if duration is not None)
        agreed = sum(duration <= min(durations) * (1 + _AGREED) for duration in durations)
        return cls(len(starts), len(durations), agreed, durations)


@dataclass(frozen=True, slots=True)
class PlanningReport:
    """What planning cost.

    Attributes:
        plan_time: s.
        solve_time: in the solver, s.
        iterations: of all solves.
        rounds: of tightening.
        starts: what the starting points led to.
        phases: s, by name.
        solver_status: status of the last solve.
        backoff: fraction of the budget kept from the optimiser, by "constraint | subject", where it is above the first.
        branch: the start configuration in words.
        base_yaw: which one was taken if the scenario left it free, or None.
        end_yaws: likewise of the ends of a free path, as "start 0 deg, goal 45 deg".
        blocked_way: what is in the way of the direct one where a free path takes another, in words, or empty.
        linear_solvers: of every solve; where one failed, the one after it and its own name.
        savings: s, by "constraint | subject": what a limit wider by a tenth would save, to the first order, of those
            that hold the motion back longest.
        compared: s, by name: duration of the fastest certified motion of another kind, where that was asked for.
        jerk_weight_factor: factor on the weights of the jerks, above 1 where fast modes of a liquid had to be damped.
        ran_out: whether planning ended because the time planning.max_plan_time was up.
        fallbacks: what was taken in the place of what was asked for, a sentence each.
        warm: whether it was planned from an earlier plan.
        not_warm: why not, where an earlier plan was at hand.
    """

    plan_time: float
    solve_time: float
    iterations: int
    rounds: int
    starts: Starts
    phases: dict[str, float]
    solver_status: str
    backoff: dict[str, float]
    branch: str = ""
    base_yaw: str | None = None
    end_yaws: str | None = None
    blocked_way: str = ""
    linear_solvers: tuple[str, ...] = ()
    savings: dict[str, float] = field(default_factory=dict)
    compared: dict[str, float] = field(default_factory=dict)
    jerk_weight_factor: float = 1.0
    ran_out: bool = False
    fallbacks: tuple[str, ...] = ()
    warm: bool = False
    not_warm: str = ""

    @classmethod
    def empty(cls, solver_status: str = "none") -> PlanningReport:
        """The report of a motion that no planner made."""
        return cls(0.0, 0.0, 0, 0, Starts(0, 0, 0, ()), {}, solver_status, {})


def motion_maxima(judgement: Judgement, scene: Scene) -> MotionMaxima:
    """The largest figures of a judged motion."""
    tray = judgement.replay.tray
    largest: dict[str, dict[str, float]] = {}
    for trace in (item for item in judgement.traces if item.constraint in (SloshHeight.name, ResidualHeight.name)):
        largest.setdefault(trace.constraint, {})[trace.subject] = float(np.max(np.abs(trace.value)))
    return MotionMaxima(
        tray_acceleration=float(np.max(np.linalg.norm(tray.acceleration, axis=1))),
        tray_angular_acceleration=float(np.max(np.linalg.norm(tray.angular_acceleration, axis=1))),
        tilt=float(np.max(np.arccos(np.clip(tray.rotation[:, 2, 2], -1.0, 1.0)))),
        joint_speed_use=float(np.max([trace.use for trace in judgement.traces if trace.constraint == JointSpeed.name])),
        slosh_height=largest.get(SloshHeight.name, {}),
        residual_height=largest.get(ResidualHeight.name, {}),
        time_at_limit={item.row.label: item.share for item in limiting_rows(judgement, scene)},
    )
