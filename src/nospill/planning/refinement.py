"""From the coarse answer to a certified motion: mesh refinement, then constraint generation and tightening."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

from nospill.errors import MOTION, NOT_CONVERGED, ModelError, NoSolutionError, Reason
from nospill.judge.certificate import Judgement, judge
from nospill.judge.wording import describe
from nospill.laws.constraints.base import RowId
from nospill.laws.scene_parameters import structure_of
from nospill.motion.trajectory import Trajectory
from nospill.planning.active_set import ActiveSet
from nospill.planning.candidate import BARRIERS, Candidate, near_optimum, recorded, solved, started_from
from nospill.planning.log import Log
from nospill.planning.task import Task
from nospill.robots.kinematics.regularity import clearance
from nospill.scene.scene import Scene
from nospill.transcription.export_samples import with_joints_solved
from nospill.transcription.layout import layout_of
from nospill.transcription.passages import stage_determinants
from nospill.transcription.resampling import resample, resolving_intervals
from nospill.transcription.solvers import Solution, usable
from nospill.transcription.stages import Stages

REFINE_ITERATIONS = 100
_TIGHTEN_ITERATIONS = 40
_TIGHTEN_BARRIER = 1e-6
_ROUNDS = 8
"""Of tightening, since members last joined."""
_GROWTHS = 12
_FINE_SWING = 0.7


def fine_intervals(scene: Scene, duration: float) -> int:
    """Number of intervals of the fine grid for a motion of this duration, s."""
    return max(scene.planning.intervals, resolving_intervals(scene, duration, _FINE_SWING))


def to_fine_grid(coarse: Candidate, log: Log) -> Candidate:
    """The coarse answer on the fine grid, or as far as that is reached: the certificate is independent of the grid."""
    active, stages = coarse.active, coarse.stages
    wanted = fine_intervals(active.scene, stages.duration)
    first = _refined(coarse, wanted, active.near(coarse.solution.slack), log)
    if first is not None:
        return first
    halfway = _refined(coarse, max(wanted // 2, stages.intervals), active.possible, log)
    last = None if halfway is None else _refined(halfway, wanted, active.possible, log)
    return last or halfway or coarse


def _refined(candidate: Candidate, intervals: int, rows: Collection[RowId], log: Log) -> Candidate | None:
    """The motion solved on another grid with some rows; None where no first barrier leads anywhere."""
    task, scene = candidate.task, candidate.active.scene
    start = resample(candidate.stages, layout_of(structure_of(scene)), intervals)
    start = with_joints_solved(scene, start, task.passage.along)
    return _converged(task, candidate.active.with_rows(rows), start, BARRIERS, log)


def _converged(
    task: Task, active: ActiveSet, start: Stages, barriers: tuple[float | None, ...], log: Log
) -> Candidate | None:
    """The first converged answer from a start that is nearly optimal, with one first barrier after the other."""
    for barrier in barriers:
        if log.out_of_time:
            break
        options = {"max_iterations": REFINE_ITERATIONS} if barrier is None else near_optimum(barrier, REFINE_ITERATIONS)
        found = solved(task, active, start, log, options)
        if has_converged(found.solution):
            return found
    return None


def has_converged(solution: Solution) -> bool:
    """Whether the solver converged to an answer that is feasible."""
    return usable(solution) and solution.converged


@dataclass(frozen=True, slots=True)
class Judged:
    """A candidate with its samples and their certificate."""

    candidate: Candidate
    trajectory: Trajectory
    judgement: Judgement


def certified_by_refinement(candidate: Candidate, log: Log) -> Judged:
    """Judge everything, solve some, add what is violated, until the certificate holds or nothing is left to act on.

    Raises:
        NoSolutionError: the motion cannot be played, or there is none with what joined the problem.
    """
    try:
        return _certified(candidate, log)
    except ModelError as error:
        stages = candidate.stages
        raise NoSolutionError(
            f"No motion found: one of {stages.duration:.3f} s on {stages.intervals} intervals "
            f"cannot be played, {error}. Try another planning.intervals or a path away from singularities.",
            Reason(NOT_CONVERGED, "singularity", candidate.task.scene.robot.name),
        ) from None


def _certified(candidate: Candidate, log: Log) -> Judged:
    judged = _judged(candidate, log)
    tightened = grown = 0
    while tightened < _ROUNDS and grown < _GROWTHS and not log.out_of_time:
        before = judged.candidate
        active = before.active.after(before.task, judged.judgement)
        if active is before.active:
            break
        log.rounds += 1
        if active.members == before.active.members:
            tightened += 1
            better = _tightened(before, active, log)
            if better is None:
                break
        else:
            grown, tightened = grown + 1, 0
            better = solved_from(before.task, active, judged.trajectory, log)
            if better is None:
                raise _infeasible(judged)
        judged = _judged(better, log)
    return judged


def _judged(candidate: Candidate, log: Log) -> Judged:
    with log.phase("export"):
        trajectory = recorded(candidate)
    with log.phase("certify"):
        return Judged(candidate, trajectory, judge(trajectory, candidate.task.scene))


def _tightened(before: Candidate, active: ActiveSet, log: Log) -> Candidate | None:
    """The motion solved again with more rows or more back-off, warm where no row joined; None where that fails."""
    if active.rows == before.active.rows:
        options = near_optimum(_TIGHTEN_BARRIER, _TIGHTEN_ITERATIONS)
        again = solved(before.task, active, before.stages, log, options, warm=before.solution)
    else:
        options = near_optimum(BARRIERS[0], REFINE_ITERATIONS)
        again = solved(before.task, active, before.stages, log, options)
    if not has_converged(again.solution):
        again = solved(before.task, active, before.stages, log)
    return again if usable(again.solution) else None


def solved_from(task: Task, active: ActiveSet, trajectory: Trajectory, log: Log) -> Candidate | None:
    """A motion of the whole scene solved on the fine grid with what is active; None where nothing converges.

    Where the arm leaves its branch, it is solved again with the determinant bounded.
    """
    with log.phase("corners"):
        start = started_from(task, active, trajectory, fine_intervals(active.scene, trajectory.end_time))
    for barriers in ((*BARRIERS, None),) * 2:
        found = _converged(task, active, start, barriers, log)
        if found is None or found.keeps_branch or task.passage.determinant is not None:
            return found
        determinant = clearance(stage_determinants(active.scene, start))
        task = replace(task, passage=replace(task.passage, determinant=determinant))
    return None


def _infeasible(judged: Judged) -> NoSolutionError:
    """The error where a motion was found without some members, and none with them."""
    worst = judged.judgement.certificate.worst
    uncertain = "Narrow the tolerance or relax that limit." if worst.variant else "Relax that limit."
    return NoSolutionError(
        f"No motion found, though there is one of {judged.trajectory.end_time:.3g} s for some of the objects and "
        f"variants: there {describe(worst)}. {uncertain}",
        Reason(MOTION, worst.constraint, worst.subject, excess=worst.use - 1.0),
    )
