"""From the coarse answer to a certified motion: mesh refinement, then constraint generation and tightening."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

from nospill import diagnosis
from nospill.certification.certificate import Judgement, judge_motion
from nospill.certification.corners import broken_or_corner_traces
from nospill.certification.tracking_band import broken_or_band_of
from nospill.certification.tracks import judged_tracks, variant_tracks
from nospill.errors import ModelError, NoSolutionError
from nospill.laws.constraints import DEVIATION_JERK_NAMES, LIQUID_NAMES
from nospill.laws.constraints.base import RowId
from nospill.motion.trajectory import Trajectory
from nospill.planning.active_set import ActiveSet
from nospill.planning.candidate import Candidate, exported, problem_about, solved
from nospill.planning.log import Log
from nospill.planning.next_set import next_set
from nospill.planning.widest_range import broken_speeds, holds_from, holds_further
from nospill.transcription.export_samples import on_grid
from nospill.transcription.passages import bounded_as
from nospill.transcription.resampling import fine_intervals
from nospill.transcription.sensitivity import saving_of
from nospill.transcription.solvers import row_slack, usable
from nospill.transcription.solvers.options import (
    BARRIERS,
    LAST_BARRIER,
    NEAR_OPTIMUM,
    OF_OTHER_ROWS,
    Options,
    near_adapted,
    near_optimum,
)
from nospill.transcription.stages import Stages
from nospill.transcription.time_scaling import slow_enough
from nospill.transcription.trajectory_start import from_trajectory

REFINE_ITERATIONS = 150
_BREAKS = 1.0
"""Part of its budget by which a start is over a row and no longer near the optimum."""
_TIGHTEN_ITERATIONS = 100
_ADAPTED_ITERATIONS = 60
"""With a barrier that is adapted: where it leads to an answer it takes half of that, else one that goes down does."""
_FAR = 0.015
"""Part of its duration that less back-off promises a motion, from which its answer is far."""
_ROUNDS, _ROUNDS_OVER_BAND = 8, 16
"""Of tightening, since members last joined; over a band of arms more, since heights after the end fall as a small power
of the weights of the jerks, which rise the less the less is missing."""
_GROWTHS = 12
_ALIKE = 0.8
"""Part of the coarse answer's duration that a fine one near it takes at least."""
_NEARLY_ALIKE = 2.5
"""Ratio of the weights of the jerks with which multipliers are worth a start, between problems with margins."""
_FEW_SPEEDS = 12
"""Speeds that broke a limit up to which they are looked at before all others: more ask for members from all of them."""
_SLOWEST = 4.0
"""Times as slow as a motion is made at most, from which members or modes did not join."""


def to_fine_grid(coarse: Candidate, log: Log) -> Candidate:
    """The coarse answer on the fine grid, or as far as that is reached: the certificate is independent of the grid."""
    coarse = replace(coarse, active=replace(coarse.active, expected=coarse.stages.duration))
    active, stages = coarse.active, coarse.stages
    wanted = fine_intervals(active.scene, stages.duration)
    jerks = {
        row for row in active.possible if row.constraint in DEVIATION_JERK_NAMES
    }  # that a coarse grid does not show
    rows = active.near(coarse.solution.slack) | jerks
    first = _with_modes(coarse, rows, log) or _refine(coarse, wanted, rows, log)
    if first is not None and first.stages.duration > _ALIKE * stages.duration:
        return first  # else it left the coarse answer, whose rows say nothing of it
    halfway = _refine(coarse, max(wanted // 2, stages.intervals), active.usual, log)
    last = None if halfway is None else _refine(halfway, wanted, active.usual, log)
    return last or halfway or coarse


def _with_modes(coarse: Candidate, rows: Collection[RowId], log: Log) -> Candidate | None:
    """The coarse answer on the fine grid with the modes that it asks for; None where it asks for none, or in vain."""
    if coarse.active.task.scene.planned_modes > 1 and any(row.constraint in LIQUID_NAMES for row in rows):
        with suppress(NoSolutionError):
            judged = _judge(coarse, log)
            after = next_set(coarse.active, judged.judgement)
            active = after.with_rows(after.rows.union(rows))
            if active.refined:
                start = _smoothed(coarse, active, log) or judged.trajectory
                begun = start_from(active, start, log, coarse.stages)
                return _solve_near_optimum(active, begun, of_other_rows(active, begun), log)
    return None


def _smoothed(coarse: Candidate, active: ActiveSet, log: Log) -> Trajectory | None:
    """The coarse answer once more with the weights that late joints ask for, a start nearer by; None without such."""
    smooth = coarse.active.as_smooth_as(active.smoothness)
    if smooth is coarse.active or active.task.scene.tracking is None or active.rings:
        return None
    again = solved(smooth, coarse.stages, log, near_optimum(BARRIERS[1], REFINE_ITERATIONS))
    with suppress(ModelError):
        return exported(again) if again.has_converged else None
    return None


def _refine(candidate: Candidate, intervals: int, rows: Collection[RowId], log: Log) -> Candidate | None:
    """The motion on another grid with some rows; None where no first barrier (on planes, the least) leads there."""
    active = candidate.active.with_rows(rows)
    start = on_grid(active.scene, candidate.stages, intervals, active.task.passage.along)
    return _solve_near_optimum(active, start, NEAR_OPTIMUM[:1] if active.task.leads_past else NEAR_OPTIMUM, log)


def _solve_near_optimum(
    active: ActiveSet, start: Stages, tries: Sequence[Options], log: Log, *, tightens: bool = False
) -> Candidate | None:
    """The first converged answer from a start that is nearly optimal, with one choice of options after the other."""
    for options in tries:
        if log.out_of_time:
            break
        most = {"max_iterations": REFINE_ITERATIONS}
        candidate = solved(active, start, log, {**options, **most}, tightens=tightens)
        if candidate.has_converged:
            return candidate
    return None


@dataclass(frozen=True, slots=True)
class Judged:
    """A candidate with its samples, all modes of the liquids among them, and their certificate."""

    candidate: Candidate
    trajectory: Trajectory
    judgement: Judgement


def refine_until_certified(
    candidate: Candidate, log: Log, *, below: float = math.inf, heaviest: float = math.inf
) -> Judged:
    """`certify_by_refinement` without that last solve; raises the same.

    Given up, uncertified, once it takes as long as `below`, s: what joins a problem or is kept from it shortens none;
    once jerks are to weigh more than `heaviest` times.
    Over a range of speeds that is not reached, the motion that holds furthest down it.
    """
    judged = furthest = _judge(candidate, log)
    tightened = grown = 0
    most = _ROUNDS if candidate.active.task.scene.tracking is None else _ROUNDS_OVER_BAND
    while not judged.judgement.leaves_margin and tightened < most and grown < _GROWTHS and not log.out_of_time:
        if judged.trajectory.end_time >= below:
            break
        before, certified = judged.candidate, judged.judgement.certificate.ok
        active = next_set(before.active, judged.judgement, before.solution.slack)
        grows = active.scene is not before.active.scene
        if active is before.active or (certified and grows) or active.smoothness.factor > heaviest:
            break
        others = active.margins is not before.active.margins
        if not (grows or others) and _at_least(before, active) >= below:
            break
        log.rounds += 1
        if not grows:
            tightened += bool(active.margins) or active.smoothness.factor == before.active.smoothness.factor
            start = before.stages
            shortens = below < math.inf  # a certified motion, which stands where this leads nowhere
            better = tighten(before, active, log, afresh=not (others or shortens))
            if better is None and others:
                better = tighten(before, active.with_less_margin(), log)
            if better is None:
                break
        else:
            grown, tightened = grown + 1, 0
            start = start_from(active, judged.trajectory, log, before.stages)
            better = _with_members(before, active, start, log)
            better = better or solve_from(active, start, log, of_other_rows(active, start)[:1])
            if better is None:  # far from any answer: from a motion slow enough to keep the rows
                slow = slow_enough(problem_about(active, start), start, _SLOWEST)
                better = solve_from(active, slow, log, ({}, *NEAR_OPTIMUM[1:]))
            if better is None:
                if active.members == before.active.members:
                    break
                raise diagnosis.infeasible_with_more(judged.judgement.certificate.worst, judged.trajectory.end_time)
        if better.stages.duration >= below:
            break
        try:
            following = _judge(better, log, else_from=start, before=judged.judgement)
        except NoSolutionError:
            break  # of a motion that cannot be played nothing is known: the one before stands
        if certified and not following.judgement.certificate.ok:
            break
        judged = following
        if certified and judged.candidate.active.task.scene.motion.speeds:
            break  # what a finer grid may find is little, and a verdict at all speeds takes long
        if holds_further(judged.judgement, furthest.judgement, judged.candidate.active.task):
            furthest = judged
    if judged.judgement.certificate.ok or holds_from(furthest.judgement, furthest.candidate.active.task) is None:
        return judged
    return furthest


def _judge(candidate: Candidate, log: Log, else_from: Stages | None = None, before: Judgement | None = None) -> Judged:
    """The certificate of a candidate; one that leaves the arm's reach is solved again from a motion that does not.

    Where it ends at a first look, that is at the few speeds that broke a limit in the verdict before.
    """
    scene, stages = candidate.active.task.scene, candidate.stages
    try:
        with log.phase("export"):
            trajectory = exported(candidate)
        with log.phase("certify"):
            looked_at = candidate.active.task.judged_scene(candidate.active.refined)
            again = () if before is None else _looked_at_again(candidate.active, before)
            first_looks = partial(broken_or_corner_traces, again=again)
            judgement = judge_motion(trajectory, looked_at, corners=first_looks, over_band=broken_or_band_of)
            if judgement.leaves_margin and looked_at is not scene:
                judgement = judge_motion(trajectory, scene)
            slosh = judged_tracks(trajectory, scene, judgement.replay, judgement.traces)
            log.judged(holds_from(judgement, candidate.active.task))
            return Judged(candidate, replace(trajectory, slosh=slosh), judgement)
    except ModelError as error:
        again = None if else_from is None else _off_singularities(candidate.active, else_from, log)
        if again is not None:
            return _judge(again, log)
        raise diagnosis.not_playable(scene, stages.duration, stages.intervals, error) from None


def _looked_at_again(active: ActiveSet, before: Judgement) -> Collection[float]:
    """The few speeds that broke a limit in the verdict before, for a first look.

    None before a problem holds liquids nearly as slow as the range goes: back-off is not taken back where members at
    lower speeds make it needless.
    """
    asked, broken = active.task.scene.motion.speed_range, broken_speeds(before, active.task)
    return broken if asked and len(broken) <= _FEW_SPEEDS and active.membership.slowest < 2.0 * asked[0] else ()


def _at_least(before: Candidate, active: ActiveSet) -> float:
    """Seconds that the motion takes with another back-off, to the first order: no less, as far as it is convex."""
    return before.stages.duration - saving_of(before.problem, before.solution, active.backoff)


def tighten(before: Candidate, active: ActiveSet, log: Log, *, afresh: bool = True) -> Candidate | None:
    """The motion solved again with more rows, more back-off or heavier jerks; None where that fails.

    Warm where no row joined. Then once more as from any start, where `afresh`: with margins that are too much it takes
    longest, and in vain.
    """
    heavier = active.smoothness.factor / before.active.smoothness.factor
    same = bool(active.margins) == bool(before.active.margins) and active.rows == before.active.rows
    near = heavier == 1.0 or (bool(before.active.margins) and 1.0 / _NEARLY_ALIKE <= heavier <= _NEARLY_ALIKE)
    far = _at_least(before, active) < (1.0 - _FAR) * before.stages.duration
    if same and (far or not near):
        again = solved(active, before.stages, log, near_adapted(_ADAPTED_ITERATIONS), before, tightens=True)
        if again.has_converged:
            return again
    warm = before if same and near else None
    barrier, most = (LAST_BARRIER, _TIGHTEN_ITERATIONS) if warm else (BARRIERS[0], REFINE_ITERATIONS)
    again = solved(active, before.stages, log, near_optimum(barrier, most), warm, tightens=True)
    if not again.has_converged and afresh:
        again = solved(active, before.stages, log, tightens=True)
    if not again.has_converged and not afresh:
        return None
    return again if usable(again.solution) else None


def _with_members(before: Candidate, active: ActiveSet, start: Stages, log: Log) -> Candidate | None:
    """The motion solved from a start with further members, and the multipliers of what was there; else None.

    Where more join than there were, or modes do, those multipliers say little.
    """
    last = before.active
    alike = active.task is last.task and (active.refined, active.modes) == (last.refined, last.modes)
    if not alike or len(active.members) > 2 * len(last.members) or start.intervals != before.stages.intervals:
        return None
    found = solved(active, start, log, near_adapted(_ADAPTED_ITERATIONS), before, tightens=True)
    return found if found.has_converged and found.keeps_branch else None


def of_other_rows(active: ActiveSet, start: Stages) -> Sequence[Options]:
    """What is tried from the optimum of a problem that had other rows, by how far it breaks those of this one.

    Where the tray may leave its path the least barrier comes first all the same: little but the weights of the jerks
    holds the tray beside its path, and a larger barrier leads it away.
    """
    if active.task.scene.motion.leaves_path:
        return NEAR_OPTIMUM
    slack = row_slack(problem_about(active, start), start)
    return OF_OTHER_ROWS if min(slack.values(), default=0.0) < -_BREAKS else NEAR_OPTIMUM


def start_from(active: ActiveSet, trajectory: Trajectory, log: Log, last: Stages | None = None) -> Stages:
    """A motion as a start on the fine grid; the redundant joint is counted as in the last answer, as its bounds are."""
    with log.phase("corners"):
        moved = replace(trajectory, slosh=variant_tracks(trajectory, active.task.scene, active.names))
        intervals = fine_intervals(active.scene, trajectory.end_time)
        return from_trajectory(active.scene, moved, intervals, last.self_motion if last else None)


def solve_from(active: ActiveSet, start: Stages, log: Log, tries: Sequence[Options] | None = None) -> Candidate | None:
    """A motion solved on its grid with what is active; None where no choice of options leads anywhere.

    Where the arm leaves its branch, it is solved again with the determinant bounded.
    """
    tries = (*of_other_rows(active, start), {}) if tries is None else tries
    found = _solve_near_optimum(active, start, tries, log, tightens=True)
    kept = found is None or found.keeps_branch or active.task.passage.determinant is not None
    return found if kept else _off_singularities(active, start, log)


def _off_singularities(active: ActiveSet, start: Stages, log: Log) -> Candidate | None:
    """A motion solved from a start with the determinant bounded as there; None where it is, or that leads nowhere."""
    passage = bounded_as(active.task.passage, active.scene, start)
    bounded = passage and replace(active, task=replace(active.task, passage=passage))
    return bounded and _solve_near_optimum(bounded, start, (*NEAR_OPTIMUM, {}), log, tightens=True)
