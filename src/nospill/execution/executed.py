"""The verdict on what was executed, compared with what was planned, with the band that the noise of the log leaves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from nospill.certification.certificate import Judgement, judge, judge_joints
from nospill.certification.clearance import clearance_traces
from nospill.certification.replay import replay
from nospill.certification.traces import constraint_traces
from nospill.certification.tracked_rows import without_reserve
from nospill.certification.verdict import Row, Trace
from nospill.errors import ModelError, ScenarioError
from nospill.execution.bands import (
    CERTIFIED,
    DRAWS,
    NOT_CERTIFIED,
    OPEN,
    height_bands,
    outcome,
    row_bands,
    smoothing_errors,
)
from nospill.execution.log import JointLog
from nospill.execution.motion import RecordedMotion, Span, recorded_motion, samples, stopping_time
from nospill.execution.observer import ObservedLiquid, observed_liquids
from nospill.execution.smoothing import BANDWIDTH, SmoothJoints
from nospill.execution.tracking import Tracking, track_command, tracking
from nospill.laws.constraints.base import EVERYWHERE, EvaluationPoint, RowId
from nospill.laws.constraints.clearance import Clearance
from nospill.laws.constraints.slip import Slip
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.motion.interpolation import QUINTIC_SPLINE, HeldMotion, JointMotion, JointSamples
from nospill.plans.plan import Plan
from nospill.scene.scene import Scene
from nospill.simulation.compare import Comparison, compare
from nospill.simulation.motion_file import Heights

_RATE = 500.0
"""Hz, of the samples of the motion, and of the grid on which the drawn motions are judged."""
_BEFORE, _AFTER = 0.02, 0.4
"""s; of rest that are played before and after the motion."""
_JOINT_POINTS = tuple(point for point in EVERYWHERE if point is not EvaluationPoint.CONTROL)
_PEAKS = (SloshHeight.name, Slip.name)


@dataclass(frozen=True, slots=True, eq=False)
class Peak:
    """The largest value of a constraint, planned and executed.

    Attributes:
        constraint, subject: of the row.
        planned: in the unit of the constraint.
        executed: likewise.
        by_joint: likewise, by joint: what the peak would lose if this joint alone had moved as planned.
    """

    constraint: str
    subject: str
    planned: float
    executed: float
    by_joint: Mapping[str, float]


@dataclass(frozen=True, eq=False)  # without slots: outcomes are worked out once
class Executed:
    """What was executed, judged. Times are those of the plan, or s from the begin of the motion where there is none.

    Attributes:
        scene: what it was judged by.
        recorded: the motion on the clock of the log.
        clock: time of the log at time zero here, s.
        judgement: of what was executed.
        bands: half width of the 95 % band of the margin of a row, in its unit; zero for a log without noise.
        smoothing: likewise, what smoothing may have changed the margin by.
        without_reserve: use of what may happen on the tray with nothing in reserve, by row: above 1 it happens.
        heights: heights of the liquids (m,) m over `judgement.replay.t`, by object.
        height_bands: half width of their 95 % bands, likewise.
        tracking: against the plan; against the command in the log where there is no plan; None where there is neither.
        planned: the judgement of the plan, if there is one.
        peaks: planned and executed, if there is a plan.
        measured: measured heights against executed ones, by object.
    """

    scene: Scene
    recorded: RecordedMotion
    clock: float
    judgement: Judgement
    bands: Mapping[RowId, float]
    smoothing: Mapping[RowId, float]
    without_reserve: Mapping[RowId, float]
    heights: Mapping[str, np.ndarray]
    height_bands: Mapping[str, np.ndarray]
    tracking: Tracking | None
    planned: Judgement | None
    peaks: tuple[Peak, ...]
    measured: Mapping[str, Comparison]

    @property
    def ok(self) -> bool:
        """Whether every row of what was executed holds, beyond what the noise leaves open."""
        return self.outcome == CERTIFIED

    @property
    def outcome(self) -> str:
        """Of all rows: `CERTIFIED`, `NOT_CERTIFIED` or `OPEN`."""
        found = set(self.outcomes.values())
        if NOT_CERTIFIED in found or self.judgement.certificate.unjudged:
            return NOT_CERTIFIED
        return OPEN if OPEN in found else CERTIFIED

    @cached_property
    def outcomes(self) -> Mapping[RowId, str]:
        """Of every row: whether it holds, fails or cannot be told."""
        rows = self.judgement.certificate.rows
        return {row.id: outcome(row, self.bands, self.smoothing, len(rows)) for row in rows}

    @cached_property
    def left(self) -> Mapping[str, ObservedLiquid]:
        """How the liquids swing when the arm has stopped, and how well that is known, by object."""
        return observed_liquids(self.judgement.replay, self.scene, at=self.recorded.end - self.clock)

    @property
    def word(self) -> str:
        """The verdict in a few words."""
        if self.outcome == OPEN:
            return f"{OPEN} at this {'rate' if self.recorded.is_exact else 'noise'}"
        return replace(self.judgement.certificate, ok=self.ok).word


def executed(
    log: JointLog,
    scene: Scene,
    *,
    plan: Plan | None = None,
    measured: Mapping[str, Heights] | None = None,
    bandwidth: float = BANDWIDTH,
) -> Executed:
    """Judge what was executed.

    Args:
        log: of the joints.
        scene: what it must keep to.
        plan: what was planned, of the same scene.
        measured: heights of liquids, by object; their clocks are aligned.
        bandwidth: of the motion of the joints that is followed, Hz; what is faster counts as noise.

    Raises:
        ScenarioError: the log is not of this robot or this plan, or no whole motion; a measured object has no liquid.
        ModelError: the liquids cannot be integrated.
    """
    given = dict(measured or {})
    require_liquids(given, scene)
    if not bandwidth > 0.0:
        raise ScenarioError(f"--bandwidth {bandwidth:g}: hertz above 0 are needed, for example 50")
    recorded = recorded_motion(log, scene, bandwidth=bandwidth)
    followed = _tracking(recorded, scene, plan)
    clock = followed.clock if plan is not None and followed is not None else recorded.begin
    begin, end = recorded.begin - clock, recorded.end - clock
    if plan is not None:  # which says when a motion begins and ends that fades in and out
        begin, end = min(begin, 0.0), max(end, plan.duration)
    else:
        end += stopping_time(recorded)
    after = max([_AFTER, *(_longer(heights, recorded) for heights in given.values())])
    span = Span(begin - _BEFORE, begin, end, end + after)

    def played(smooth: SmoothJoints | None = None) -> HeldMotion:
        return _shift(recorded.held(smooth), clock)

    motion = played()
    record = samples(motion, scene.robot.joints, span, _RATE)
    judgement = judge_joints(record, scene, motion=motion)
    distances = [row for row in judgement.certificate.rows if row.constraint == Clearance.name]
    rough = _traces(motion, scene, span, distances)
    drawn = [_traces_or_none(played(comparison), scene, span, distances) for comparison in _draws(recorded)]
    smoothing = smoothing_errors(rough, _traces_or_none(played(recorded.coarser), scene, span, distances))
    if plan is not None:
        asked = HeldMotion(plan.trajectory.motion, span.start, span.stop)
        read = played(recorded.reading(asked(recorded.sampling.t - clock)))
        of_plan = smoothing_errors(
            _traces(asked, scene, span, distances), _traces_or_none(read, scene, span, distances)
        )
        smoothing = {key: max(value, of_plan[key]) for key, value in smoothing.items()}
    heights = _heights(judgement.traces)
    return Executed(
        scene=scene,
        recorded=recorded,
        clock=clock,
        judgement=judgement,
        bands=row_bands(rough, drawn),
        smoothing=smoothing,
        without_reserve=without_reserve(judgement.replay, scene, judgement.certificate.rows),
        heights=heights,
        height_bands=height_bands(rough, drawn, judgement.replay.t),
        tracking=followed,
        planned=None if plan is None else judge(plan.trajectory, plan.scene),
        peaks=() if plan is None else _peaks(motion, rough, plan.trajectory.motion, scene, span),
        measured={
            name: compare(_from_rest(judgement.replay.t, heights[name], _longer(comparison, recorded)), comparison)
            for name, comparison in given.items()
        },
    )


def _tracking(recorded: RecordedMotion, scene: Scene, plan: Plan | None) -> Tracking | None:
    log = recorded.log
    command = None
    if log.command is not None:
        kept = recorded.sampling.kept
        command = QUINTIC_SPLINE.motion(JointSamples(recorded.sampling.t, log.command[kept]))
    if plan is not None:
        against_plan = tracking(recorded, scene, plan.trajectory.motion, plan.duration)
        if command is None:
            return against_plan
        of_command = track_command(recorded, scene, command)
        return replace(against_plan, delay=of_command.delay, of_command=True)
    return None if command is None else track_command(recorded, scene, command)


def _shift(motion: HeldMotion, clock: float) -> HeldMotion:
    """The motion on a clock that is at zero when its own is at `clock`."""

    def inside(t: np.ndarray, order: int = 0, /) -> np.ndarray:
        return motion.inside(t + clock, order)

    return HeldMotion(inside, motion.start - clock, motion.end - clock)


def _traces(motion: HeldMotion, scene: Scene, span: Span, distances: Sequence[Row] = ()) -> tuple[Trace, ...]:
    """Traces on a coarse grid, for differences; of distances those of the rows of what was executed."""
    record = samples(motion, scene.robot.joints, span, _RATE)
    again = replay(record, scene, motion=motion, rate=_RATE)
    listed = [row.subject for row in distances]
    return (
        *constraint_traces(record, scene, again, points=_JOINT_POINTS),
        *clearance_traces(scene, again.t, again.joint_position, distances, listed=listed),
    )


def _traces_or_none(motion: HeldMotion, scene: Scene, span: Span, distances: Sequence[Row]) -> tuple[Trace, ...] | None:
    """`_traces`; None where the liquids cannot be integrated, as along motions that noise has made rough."""
    try:
        return _traces(motion, scene, span, distances)
    except ModelError:
        return None


def _draws(recorded: RecordedMotion) -> list[SmoothJoints]:
    """Motions that the log could as well be of; none where it has no noise."""
    generator = np.random.default_rng(0)
    return [recorded.smooth.drawn(generator) for _ in range(0 if recorded.is_exact else DRAWS)]


def _heights(traces: tuple[Trace, ...]) -> dict[str, np.ndarray]:
    return {trace.subject: trace.value for trace in traces if trace.constraint == SloshHeight.name}


def _peaks(
    motion: HeldMotion, rough: tuple[Trace, ...], planned: JointMotion, scene: Scene, span: Span
) -> tuple[Peak, ...]:
    """Peaks on the coarse grid: planned, executed, and with one joint at a time as planned."""

    def largest(traces: tuple[Trace, ...]) -> dict[tuple[str, str], float]:
        return {(own.constraint, own.subject): float(np.max(own.value)) for own in traces if own.constraint in _PEAKS}

    def with_planned(joint: int) -> HeldMotion:
        def inside(t: np.ndarray, order: int = 0, /) -> np.ndarray:
            values = motion(t, order)
            values[:, joint] = planned(t, order)[:, joint]
            return values

        return HeldMotion(inside, span.start, span.stop)

    done = largest(rough)
    wanted = largest(_traces(HeldMotion(planned, span.start, span.stop), scene, span))
    joints = scene.robot.joints
    without = [largest(_traces(with_planned(index), scene, span)) for index in range(len(joints))]
    return tuple(
        Peak(*key, wanted[key], value, {name: value - own[key] for name, own in zip(joints, without, strict=True)})
        for key, value in done.items()
    )


def _from_rest(t: np.ndarray, height: np.ndarray, before: float) -> Heights:
    """Heights with so much rest before the motion, s: a camera may run long before it."""
    count = max(0, int(before / (t[1] - t[0])))
    early = t[0] - (t[1] - t[0]) * np.arange(count, 0, -1)
    return Heights(np.concatenate([early, t]), np.concatenate([np.zeros(count), height]))


def _longer(heights: Heights, recorded: RecordedMotion) -> float:
    """How much longer than the motion a liquid was filmed, s."""
    return float(heights.t[-1] - heights.t[0]) - (recorded.end - recorded.begin) + _AFTER


def require_liquids(measured: Mapping[str, Heights], scene: Scene) -> None:
    """Raise ScenarioError where a measured height is of no object with a liquid."""
    liquids = [cargo.name for cargo in scene.cargo if cargo.filling]
    for name in measured:
        if name not in liquids:
            known = ", ".join(liquids) or "none"
            raise ScenarioError(f"--measured {name}: no object of this name with a liquid; there are: {known}")
