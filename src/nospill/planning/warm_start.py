"""Planning from an earlier answer: how far it breaks the new scene's limits, and how it is solved from there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from nospill.certification.certificate import judge, judge_motion
from nospill.certification.tracks import judged_tracks
from nospill.errors import ModelError
from nospill.laws.constraints import by_name
from nospill.laws.constraints.base import RowId, liquid_names
from nospill.laws.constraints.clearance import Clearance
from nospill.laws.scene_parameters import structure_of
from nospill.motion.trajectory import Trajectory
from nospill.planning.active_set import ActiveSet
from nospill.planning.candidate import Candidate, planes_like, problem_about, solved
from nospill.planning.log import Log
from nospill.planning.refinement import REFINE_ITERATIONS, Judged, start_from
from nospill.planning.smoothness import Smoothness
from nospill.planning.task import Task
from nospill.plans.plan import Plan
from nospill.robots.joint_paths.search import JointPath
from nospill.scene.tolerances import has_variants
from nospill.transcription.resampling import fine_intervals
from nospill.transcription.solvers.options import BARRIERS, LOOSEST, Options, near_adapted, near_optimum
from nospill.transcription.stages import Stages
from nospill.transcription.time_scaling import is_broken, slow_enough
from nospill.transcription.trajectory_start import bent, on_branch, on_moved_path

NOT_CONVERGED = "no solve from the motion before converged"
NOT_CERTIFIED = "not certified from the motion before"
_OTHER_GRID = 0.1
"""Part of its intervals by which a grid is another one: a motion may have become longer than the coarse one whose
duration chose it, and its multipliers are worth more than a few intervals."""
_WARM: Options = {"kkt_error_globalization": True, "bound_push": 5e-4, "max_iterations": 50, "tolerances": LOOSEST}
_SLOWED: Options = {**_WARM, "bound_push": 3e-3}
_NEARBY_ITERATIONS = 40
"""Along a moved way, with a barrier that is adapted: what takes longer is reached sooner from the coarse grid."""


def restart(task: Task, earlier: Plan, last: Candidate | None, log: Log) -> Candidate | None:
    """Solve from an earlier plan of a similar scene; None where that does not converge.

    `last` is the candidate that plan was made from: its multipliers are used where it is at hand.
    """
    active = None if last is None else _as_before(task, earlier, last)
    candidate = None if last is None or active is None else _solve_again(active, last.stages, log, warm=last)
    return candidate or _restart_from(task, earlier, earlier.trajectory, log)


def restart_nearby(task: Task, earlier: Plan, last: Candidate | None, log: Log) -> Candidate | None:
    """The same along a way that was moved, where the motion breaks no row by much there; else None."""
    active = None if last is None else _as_before(task, earlier, last)
    if last is None or active is None:
        return None
    start = on_moved_path(last.stages, earlier.scene, active.scene)
    alone = active.with_rows(row for row in active.rows if row.constraint != Clearance.name)
    if is_broken(problem_about(alone, start), start):
        return None
    with log.phase("build", "fine"):
        problem = problem_about(active, start, planes_like(last, active))
    return _succeeded(solved(active, start, log, near_adapted(_NEARBY_ITERATIONS), last, problem), log)


def _as_before(task: Task, earlier: Plan, last: Candidate) -> ActiveSet | None:
    """What was active in the last problem of an earlier plan; None where another problem has another shape."""
    if task.ignored:
        return None
    q = earlier.trajectory.joint_position
    active = ActiveSet.of(task, q, last.active.members, last.active.refined, last.active.modes)
    ours, theirs = structure_of(active.scene), structure_of(last.active.scene)
    same = ours == replace(theirs, spans=ours.spans, degree=ours.degree)  # its variables and rows are the same
    intervals = last.stages.intervals
    if not same or abs(fine_intervals(active.scene, earlier.duration) - intervals) > _OTHER_GRID * intervals:
        return None
    active = cautious(active.with_rows(last.active.rows).with_backoff(last.active.backoff))
    return replace(
        active,
        everywhere=last.active.everywhere,
        expected=earlier.duration,
        smoothness=last.active.smoothness,
    )


def restart_on_branch(task: Task, earlier: Plan, joint_path: JointPath, log: Log) -> Candidate | None:
    """Solve from the motion of an earlier plan's tray with the arm on another branch; None as `restart`."""
    try:
        moved = on_branch(earlier.trajectory, earlier.scene, task.scene, joint_path)
    except ModelError:
        return None
    return _restart_from(task, earlier, moved, log)


def _restart_from(task: Task, earlier: Plan, motion: Trajectory, log: Log) -> Candidate | None:
    """Solve from the motion of an earlier plan, or one whose tray moves alike, with what its limits say."""
    with log.phase("certify"):
        judgement = judge(motion, task.scene) if has_variants(task.scene) else None
    refined = frozenset(liquid_names(task.scene) if task.scene.planned_modes > 1 else ())
    active = ActiveSet.of(task, motion.joint_position, refined=refined)
    if judgement is not None:
        active = active.joined(active.members | active.near_members(judgement), refined, judgement)
    else:
        active = active.without_far(earlier.certificate.rows)
    active = cautious(active.with_backoff({RowId.of(label): value for label, value in earlier.report.backoff.items()}))
    active = replace(active, expected=earlier.duration, smoothness=Smoothness(earlier.report.jerk_weight_factor))
    return _solve_again(active, start_from(active, motion, log), log, warm=None)


def going_on(task: Task, rest: Trajectory, log: Log) -> Candidate | None:
    """Solve from what is left of the motion that this one goes on from; None where that does not converge."""
    refined = frozenset(liquid_names(task.scene) if task.scene.planned_modes > 1 else ())
    active = cautious(ActiveSet.of(task, rest.joint_position, refined=refined))
    active = replace(active, expected=rest.end_time)
    return _solve_again(active, start_from(active, rest, log), log, warm=None)


def going_elsewhere(task: Task, rest: Trajectory, log: Log) -> Iterator[Candidate]:
    """Solved from what is left of the motion before, bent to another goal, or followed by a motion to there."""
    for afterwards in (False, True):
        try:
            candidate = going_on(task, bent(rest, task.scene, afterwards=afterwards), log)
        except (ModelError, np.linalg.LinAlgError):
            continue
        if candidate is not None:
            yield candidate


def what_is_left(task: Task, rest: Trajectory, log: Log) -> Judged | None:
    """What is left of the motion that this one goes on from, with the problem about it; None where it is not certified.

    A motion to the same end that is certified needs no search from afar, should the solve from it lead nowhere.
    """
    with log.phase("certify"):
        judgement = judge_motion(rest, task.scene)  # its liquids may be others than those of the motion before
    if not judgement.certificate.ok:
        return None
    rest = replace(rest, slosh=judged_tracks(rest, task.scene, judgement.replay, judgement.traces))
    active = ActiveSet.of(task, rest.joint_position)
    candidate = solved(active, start_from(active, rest, log), log, {"max_iterations": 0})
    return Judged(candidate, rest, judgement)


def start_off_path(task: Task, given: Judged, log: Log) -> Candidate | None:
    """Solve from a motion on the path, where the tray may leave it; None where that does not converge."""
    before = given.candidate.active
    active = ActiveSet.of(task, given.trajectory.joint_position, before.members, before.refined)
    active = cautious(active.without_far(given.judgement.certificate.rows).with_backoff(before.backoff))
    active = replace(active, expected=given.trajectory.end_time)
    return _solve_again(active, start_from(active, given.trajectory, log), log, warm=None)


def cautious(active: ActiveSet) -> ActiveSet:
    """The set with at least the back-off of a restart: one more round of tightening would take longer."""
    known = by_name(active.scene)
    return active.with_backoff({key: known[key.constraint].restart_backoff for key in active.backoff})


def _solve_again(active: ActiveSet, start: Stages, log: Log, *, warm: Candidate | None) -> Candidate | None:
    """Solve from a motion of an earlier scene, slowed down if the new one has tighter limits."""
    with log.phase("build", "fine"):
        problem = problem_about(active, start, warm and planes_like(warm, active))
    broken = is_broken(problem, start)
    if broken:
        start = slow_enough(problem, start)
    candidate = solved(active, start, log, _SLOWED if broken else _WARM, warm, problem)
    if not candidate.solution.converged:
        candidate = solved(active, start, log, near_optimum(BARRIERS[1], REFINE_ITERATIONS), problem=problem)
    return _succeeded(candidate, log)


def _succeeded(candidate: Candidate, log: Log) -> Candidate | None:
    """A candidate where it has converged on its branch, else None; its end time is in the log."""
    succeeded = candidate.has_converged and candidate.keeps_branch
    log.starts.append(candidate.stages.duration if succeeded else None)
    return candidate if succeeded else None
