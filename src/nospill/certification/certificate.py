"""The judge: a verdict from the exported trajectory and the scene alone."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from nospill.certification.between_instants import peaks_between, with_peaks
from nospill.certification.carriers import with_liquids_apart
from nospill.certification.clearance import OTHERS, clearance_rows, clearance_traces
from nospill.certification.corners import Corners, corner_traces
from nospill.certification.plausibility import require_rate
from nospill.certification.record_checks import (
    joint_record,
    record_traces,
    require_motion,
    require_record,
    require_same_joints_and_liquids,
    tilt_traces,
)
from nospill.certification.replay import MINIMUM_RATE, Replay, coarse_replays, replay
from nospill.certification.run import COMMAND, command_traces, of_joints_alone, run_of
from nospill.certification.traces import constraint_traces
from nospill.certification.tracked_rows import Followed
from nospill.certification.tracking_band import Band, OverBand, band_of
from nospill.certification.verdict import Certificate, Row, Trace, condensed, fullest, keep_fullest, worst_row
from nospill.collisions.pairs import self_collision
from nospill.core.blas_threads import one_blas_thread
from nospill.errors import ModelError
from nospill.laws.constraints import constrained
from nospill.laws.constraints.base import EVERYWHERE, Constraint, EvaluationPoint, RowId
from nospill.laws.slosh.integrate import require_converged
from nospill.motion.holds import held_trajectory
from nospill.motion.interpolation import JointMotion
from nospill.motion.trajectory import Trajectory
from nospill.scene.scene import Scene

_OF_JOINTS = tuple(point for point in EVERYWHERE if point is not EvaluationPoint.CONTROL)
"""What follows from the joints alone; controls are those of the record."""
_NEAR = 0.9
"""Use of the limit above which a pair of bodies is followed over time."""
_ROUGH_RATE = 1000.0
"""Hz, of the grid of a rough look."""
_FARTHEST = 1.0
"""m; a liquid that moves farther in a rough look has left its cup long before."""


@dataclass(frozen=True, slots=True)
class Judgement:
    """A certificate with its evidence.

    Attributes:
        certificate: the verdict.
        traces: of every constraint, for the objects as stated; of clearance those of the pairs that come near.
        replay: dense, for the objects as stated.
        end_time: of the motion without its holds, which begins at 0, s.
        corners: where numbers of the objects may be off, the rows of every variant; the certificate has the worst.
        corner_use: likewise the largest use over the variants at every instant of the replay, (m,), by row.
        band: where the joints may be late, the rows over all of their band.
        planned_rows: then the rows of the certificate without it.
        fullest: of every row but those of clearance the trace it is the worst instant of: of the variant that uses most
            of the limit, with the instants between those of the replay that use more of it.
    """

    certificate: Certificate
    traces: tuple[Trace, ...]
    replay: Replay
    end_time: float
    corners: tuple[Row, ...] = ()
    corner_use: Mapping[RowId, np.ndarray] = field(default_factory=dict)
    fullest: Mapping[RowId, Trace] = field(default_factory=dict)
    band: Band | None = None
    planned_rows: tuple[Row, ...] = ()

    @property
    def leaves_margin(self) -> bool:
        """Whether every row holds and leaves what a finer grid may find."""
        return self.certificate.ok and all(row.shortfall <= 0.0 for row in self.variant_rows)

    @property
    def variant_rows(self) -> tuple[Row, ...]:
        """The rows of every variant of every object, and the rows that are of no object; none over a band of arms."""
        rows = self.planned_rows or self.certificate.rows
        if not self.corners:
            return rows
        objects = {row.constraint for row in self.corners}
        return (*self.corners, *(row for row in rows if row.constraint not in objects))


def certify(
    trajectory: Trajectory,
    scene: Scene,
    *,
    constraints: Iterable[Constraint] | None = None,
    motion: JointMotion | None = None,
    rate: float = MINIMUM_RATE,
) -> Certificate:
    """Judge an exported trajectory.

    The joints are played again on a dense grid, the tray's pose and motion recomputed from them, the liquids
    re-integrated from their initial swing; every constraint of the scene is evaluated at every instant, distances to
    obstacles between them too. Where numbers of the objects may be off, each constraint of theirs is evaluated at every
    corner too, and the worst row is the one that counts.

    Args:
        trajectory: the record.
        scene: what it must keep to.
        constraints: limits of your own classes, added to those of the scenario; those that the scene has from its
            planning when left out.
        motion: what the receiver's joints do; the quintic spline through the recorded positions when left out.
        rate: Hz, the least rate of the grid; a second, finer certificate is one at a higher rate (8 kHz, say).

    Raises:
        ModelError: the liquids cannot be integrated.
        ScenarioError: no trajectory, or no scene; a constraint is none, is about nothing in the scene or fails; a rate
            that is none.
        PlanFolderError: the trajectory does not fit the scene (other joints or liquids), or is no motion (a value that
            is not finite, time that does not run forward, times in ms or joints in degrees).
    """
    return judge(trajectory, scene, constraints=constraints, motion=motion, rate=rate).certificate


def judge(
    trajectory: Trajectory,
    scene: Scene,
    *,
    constraints: Iterable[Constraint] | None = None,
    motion: JointMotion | None = None,
    rate: float = MINIMUM_RATE,
) -> Judgement:
    """`certify` with its evidence; the same arguments and errors."""
    require_record(trajectory, scene)
    require_same_joints_and_liquids(trajectory, scene)
    return judge_motion(trajectory, constrained(scene, constraints), motion=motion, rate=rate)


@one_blas_thread()
def judge_motion(
    trajectory: Trajectory,
    scene: Scene,
    *,
    motion: JointMotion | None = None,
    rate: float = MINIMUM_RATE,
    first: Judgement | None = None,
    corners: Corners = corner_traces,
    over_band: OverBand = band_of,
) -> Judgement:
    """`judge` whatever liquids the record has: a motion under planning carries those of its problem.

    With what `judge_first` has found of it already, at the usual rate, the rest is added. The rows of variants and over
    a band are those of `corner_traces` and `band_of`, or of laws that end where one is broken.
    """
    require_rate(rate)
    require_motion(trajectory, scene.robot)
    held = held_trajectory(trajectory, scene.motion)
    run = run_of(held, scene.controller, motion)
    alone = run.record is held
    points = EVERYWHERE if alone else _OF_JOINTS
    first = first or _limits(run.record, scene, motion=run.motion, rate=rate, points=points, corners=corners)
    judged = _with_distances(first, scene)
    require_converged(judged.replay.slosh_error)
    controls = () if alone else constraint_traces(held, scene, judged.replay, points=[EvaluationPoint.CONTROL])
    of_command = [] if run.command is None else command_traces(scene, run.command)
    if run.compensated:
        of_record = record_traces(trajectory, held, scene, judged.replay)
    else:  # without its liquids, since the record is not about what the joints did
        asked = replay(held, replace(scene, cargo=()), motion=run.described, rate=rate)
        of_record = [replace(trace, variant=COMMAND) for trace in record_traces(trajectory, held, scene, asked)]
        controls = (*(replace(trace, variant=COMMAND) for trace in controls), *tilt_traces(scene, judged.replay))
    planned = condensed([*judged.certificate.rows, *map(worst_row, (*controls, *of_command))])
    band = None
    if scene.tracking is not None:
        followed = Followed.of_run(run, scene, planned)
        band = over_band(followed, scene.tracking, judged.traces, judged.corner_use, judged.replay.t)
    of_motion = planned if band is None else condensed([*planned, *band.rows])
    rows = (*of_motion, *map(worst_row, of_record))
    return replace(
        judged,
        certificate=replace(judged.certificate, ok=all(row.ok for row in rows) and not scene.unjudged, rows=rows),
        traces=(*judged.traces, *controls),
        end_time=trajectory.end_time,
        band=band,
        planned_rows=() if band is None else (*planned, *map(worst_row, of_record)),
        fullest=fullest([*judged.fullest.values(), *controls, *of_command, *of_record]),
    )


@one_blas_thread()
def judge_first(trajectory: Trajectory, scene: Scene, *, motion: JointMotion | None = None) -> Judgement:
    """The first part of `judge_motion`, two thirds to four fifths of its time: what is broken here is broken there.

    The limits; without distances between bodies and checks of the record. `judge_motion` goes on from it.
    """
    held = held_trajectory(trajectory, scene.motion)
    run = run_of(held, scene.controller, motion)
    points = EVERYWHERE if run.record is held else _OF_JOINTS
    found = _limits(run.record, scene, motion=run.motion, rate=MINIMUM_RATE, points=points)
    return replace(found, end_time=trajectory.end_time)


@one_blas_thread()
def judge_roughly(trajectory: Trajectory, scene: Scene, *, motion: JointMotion | None = None) -> Judgement:
    """A look at a motion that is going to be changed where it breaks a limit, in two fifths of `judge_first`'s time.

    Of the objects as stated at 1 kHz, the liquids integrated once, and without what lies between the instants: uses
    agree with those of a verdict within 0.5 % of a limit, 2 % where accelerations jump. It certifies nothing.

    Raises:
        ModelError: a liquid leaves its cup.
    """
    held = held_trajectory(trajectory, scene.motion)
    run = run_of(held, scene.controller, motion)
    record, points = run.record, EVERYWHERE if run.record is held else _OF_JOINTS
    rate = record.rate * float(np.ceil(_ROUGH_RATE / record.rate - 1e-9))  # jerks jump at the samples
    ends = float(record.t[0]), float(record.t[-1])
    played = coarse_replays(scene, [run.motion or record.motion], *ends, rate=rate)[0]
    if not np.max(np.abs(played.slosh_displacement), initial=0.0) < _FARTHEST:  # that may be no number
        raise ModelError("slosh cannot be integrated along this motion: the liquid leaves its cup")
    traces = constraint_traces(record, scene, played, points=points)
    worst = fullest(traces)
    rows = tuple(map(worst_row, worst.values()))
    verdict = Certificate(ok=all(row.ok for row in rows) and not scene.unjudged, grid_hz=played.rate, rows=rows)
    return Judgement(verdict, traces, played, trajectory.end_time, fullest=worst)


def certify_joints(
    t: ArrayLike,
    q: ArrayLike,
    scene: Scene,
    *,
    constraints: Iterable[Constraint] | None = None,
    rate: float = MINIMUM_RATE,
) -> Certificate:
    """Judge joint samples, wherever they come from, from rest to rest; what the joints do, whatever was asked for.

    Between the samples the joints move on the quintic spline through them, before and after they stand still; tray and
    liquids follow as in `certify`. Judged are position, speed, acceleration and torque of the joints, speed and
    acceleration of the tray, every limit on objects and liquids, places that are passed, and distances to obstacles.
    Left out is what joint samples do not say: whether the tray is on its path, level or within its tilt, and at the
    goal; jerks; and the checks of a record.

    Args:
        t: (m,) increasing times, s.
        q: (m, n) joint positions in the order of `scene.robot.joints`, rad.
        scene: what they must keep to.
        constraints: limits of your own classes, as in `certify`.
        rate: Hz, the least rate of the grid.

    Raises:
        ScenarioError: no scene, a constraint or a rate that is none, or arrays that are no samples of a motion of its
            joints (times in ms and joints in degrees are refused as such).
        ModelError: the liquids cannot be integrated.
    """
    require_rate(rate)
    record = joint_record(t, q, scene)
    return judge_joints(record, constrained(scene, constraints), rate=rate).certificate


def judge_joints(
    trajectory: Trajectory, scene: Scene, *, motion: JointMotion | None = None, rate: float = MINIMUM_RATE
) -> Judgement:
    """`judge` of what joints did, whatever was planned.

    Without the rows on the record of a plan, on its controls, and on the corridor, which needs the place on the path.

    Args:
        trajectory: the joints as samples (`Trajectory.of_joints`), from rest to rest.
        scene: what they must keep to.
        motion: what they do between and outside of the samples.
        rate: Hz, the least rate of the grid.
    """
    alone = of_joints_alone(scene)
    return _with_distances(_limits(trajectory, alone, motion=motion, rate=rate, points=_OF_JOINTS), alone)


def judge_command(
    trajectory: Trajectory, scene: Scene, *, motion: JointMotion, rate: float = MINIMUM_RATE
) -> Judgement:
    """`judge_joints` of what the joints make of a command that nobody has compensated.

    With a controller in the scene they follow it late, as its delay and lag say, and the command itself has rows of its
    own (`command_traces`); without one they do what they are asked for.

    Args:
        trajectory: the command as samples, from rest to rest.
        scene: what must be kept to.
        motion: the command between the samples.
        rate: Hz, the least rate of the grid.
    """
    late = None if scene.controller is None else replace(scene.controller, compensate=False)
    run = run_of(trajectory, late, motion)
    judgement = judge_joints(run.record, scene, motion=run.motion, rate=rate)
    if run.command is None:
        return judgement
    rows = condensed([*judgement.certificate.rows, *map(worst_row, command_traces(scene, run.command))])
    ok = all(row.ok for row in rows) and not scene.unjudged
    return replace(judgement, certificate=replace(judgement.certificate, ok=ok, rows=rows))


def _limits(
    held: Trajectory,
    scene: Scene,
    *,
    motion: JointMotion | None,
    rate: float,
    points: Collection[EvaluationPoint],
    corners: Corners = corner_traces,
) -> Judgement:
    """The rows of the constraints but for distances, with their evidence."""
    motion = motion or held.motion
    played = replay(held, scene, motion=motion, rate=rate)
    traces = constraint_traces(held, scene, played, points=points)
    peaks = peaks_between(held, scene, played, traces, motion)
    at_peaks = with_liquids_apart(with_peaks(traces, peaks), held, scene, motion=motion, rate=rate)
    worst = fullest(at_peaks)
    of_corners: list[Row] = []
    corner_use: dict[RowId, np.ndarray] = {}
    for trace in corners(held, scene, motion, rate, played):
        of_corners.append(worst_row(trace))
        keep_fullest(worst, trace)
        if len(trace.t) > 1:
            use = np.interp(played.t, trace.t, trace.use)
            corner_use[trace.id] = np.maximum(corner_use.get(trace.id, use), use)
    rows = tuple(map(worst_row, worst.values()))
    verdict = Certificate(
        ok=all(row.ok for row in rows) and not scene.unjudged,
        grid_hz=played.rate,
        rows=rows,
        published=scene.fidelity == "deliverable",
        modes=scene.fewer_modes,
        unjudged=scene.unjudged,
        self_collision=self_collision(scene),
    )
    return Judgement(verdict, traces, played, held.end_time, tuple(of_corners), corner_use, worst)


def _with_distances(judged: Judgement, scene: Scene) -> Judgement:
    """The same with the rows on distances between bodies, and the traces of those that come near."""
    played, verdict = judged.replay, judged.certificate
    joints = (played.joint_position, played.joint_speed, played.joint_acceleration)
    distances = clearance_rows(scene, played.t, *joints)
    near = [row for row in distances if row.use >= _NEAR and row.subject != OTHERS]
    ok = verdict.ok and all(row.ok for row in distances)
    return replace(
        judged,
        certificate=replace(verdict, ok=ok, rows=(*verdict.rows, *distances)),
        traces=(*judged.traces, *clearance_traces(scene, played.t, played.joint_position, near)),
    )
