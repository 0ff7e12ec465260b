"""Starts on a coarse grid until one converges: the best answer, or the reason why there is none."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from nospill import diagnosis
from nospill.errors import NoSolutionError
from nospill.planning.active_set import ActiveSet
from nospill.planning.candidate import Candidate, solved_lazily, with_near_rows
from nospill.planning.log import Log
from nospill.planning.refinement import to_fine_grid
from nospill.planning.starts import Attempt, attempts
from nospill.planning.task import Task, starting_motion
from nospill.planning.trial import Searcher
from nospill.robots.joint_paths.search import JointPath
from nospill.transcription.passages import passages
from nospill.transcription.solvers import usable
from nospill.transcription.starting_motions import estimate_duration

_LONG = 0.79
"""Part of the longest motion allowed; where even the estimate takes it, a look at that motion saves a vain search."""

Search = Callable[[Task, JointPath, Log], Candidate]


def search(task: Task, joint_path: JointPath, log: Log) -> Candidate:
    """The best answer on the coarse grid.

    Raises:
        NoSolutionError: there is none; where the search is brief, without much of a reason.
    """
    scene, brief = task.searched_scene, task.passage.brief
    log.durations.clear()
    best = last = None
    long = estimate_duration(scene, joint_path) >= _LONG * scene.motion.max_duration
    if not (long and diagnosis.is_hopeless(scene, joint_path)):
        best, last = best_of(task, joint_path, log, attempts(scene, brief=brief))
    if best is not None:
        return best
    if brief:
        raise NoSolutionError("No motion found at once.")
    return Searcher(task, log).last_resort(joint_path, last)


def best_of(
    task: Task, joint_path: JointPath, log: Log, tries: Sequence[Attempt]
) -> tuple[Candidate | None, Candidate | None]:
    """The best answer and the last one of several starts, None where there is none.

    The first answer ends it, or the best of as many starts as the scenario compares.
    """
    scene = task.searched_scene
    active = ActiveSet.of(task, joint_path.q).with_rows(())
    best: Candidate | None = None
    last: Candidate | None = None
    for tried, attempt in enumerate(tries):
        if (tried >= scene.planning.starts and best is not None) or (tried and log.out_of_time):
            break
        motion = starting_motion(active.scene, joint_path, attempt.start)
        rows = active.possible if attempt.all_rows else active.rows
        active = with_near_rows(task, active.with_rows(rows), motion)
        options = {
            "max_iterations": attempt.iterations,
            "kkt_error_globalization": attempt.kkt_error_globalization,
        }
        last = solved_lazily(task, active, motion, log, options)
        active = last.active
        log.tried += 1
        if usable(last.solution):
            log.durations.append(last.stages.duration)
            if best is None or last.solution.objective < best.solution.objective:
                best = last
        elif best is None and diagnosis.is_hopeless(scene, joint_path):
            break
    return best, last


def found_motion(task: Task, joint_path: JointPath, log: Log, *, search: Search = search) -> Candidate:
    """The best motion on the fine grid, on a way past the singularities on which the arm keeps its branch.

    Args:
        task: what for.
        joint_path: along which.
        log: counts the effort.
        search: finds the answer on the coarse grid.

    Raises:
        NoSolutionError: there is none; names the constraint in the way.
    """
    ways = passages(task.scene, joint_path, starting_motion(task.scene, joint_path))
    *first, last = (replace(task, passage=passage) for passage in ways)
    for way in first:
        try:
            coarse = search(way, joint_path, log)
        except NoSolutionError:
            if not way.passage.brief:
                raise
            continue
        if coarse.keeps_branch or way.passage.brief:
            fine = to_fine_grid(coarse, log)
            if fine.is_playable:
                return fine
    return to_fine_grid(search(last, joint_path, log), log)
