"""Starts on a coarse grid until one converges: the best answer, or the reason why there is none."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from nospill import diagnosis
from nospill.errors import NoSolutionError
from nospill.planning.active_set import ActiveSet
from nospill.planning.attempts import Attempt, attempts
from nospill.planning.candidate import Candidate, solved_lazily, with_near_rows
from nospill.planning.log import Log
from nospill.planning.refinement import to_fine_grid
from nospill.planning.task import Task
from nospill.robots.joint_paths.search import JointPath
from nospill.scene.scene import Scene
from nospill.transcription.passages import passages
from nospill.transcription.solvers import usable
from nospill.transcription.stages import Stages
from nospill.transcription.starting_motions import Start, coarse_start, estimate_duration

_LONG = 0.79
"""Part of the longest motion allowed; where even the estimate takes it, a look at that motion saves a vain search."""

Search = Callable[[Task, JointPath, Log], Candidate]


def search(task: Task, joint_path: JointPath, log: Log) -> Candidate:
    """The best answer on the coarse grid.

    Raises:
        NoSolutionError: there is none; where the search is brief, without much of a reason.
    """
    scene, brief = task.searched_scene, task.passage.brief
    log.starts[:] = [None] * len(log.starts)  # answers on another passage do not compare
    best = last = None
    long = estimate_duration(scene, joint_path) >= _LONG * scene.motion.longest
    if not (long and diagnosis.is_hopeless(scene, joint_path)):
        best, last = best_of(task, joint_path, log, attempts(task, brief=brief or scene.motion.duration is not None))
    if best is not None:
        return best
    if brief:
        raise NoSolutionError("No motion found at once.")
    return Searcher(task, log).last_resort(joint_path, last)


def search_elsewhere(task: Task, joint_path: JointPath, log: Log) -> Candidate:
    """The best answer on the coarse grid of the starts after those that were tried.

    Raises:
        NoSolutionError: there is none.
    """
    found, _ = best_of(task, joint_path, log, attempts(task, brief=False)[len(log.starts) :])
    if found is None:
        raise NoSolutionError("No other motion found.")
    return found


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
        motion = coarse_start(active.scene, joint_path, attempt.start)
        rows = active.possible if attempt.all_rows else active.rows
        active = with_near_rows(active.with_rows(rows), motion)
        last = solved_lazily(active, motion, log, attempt.options)
        active = last.active
        log.starts.append(last.stages.duration if usable(last.solution) else None)
        if usable(last.solution):
            if best is None or last.solution.objective < best.solution.objective:
                best = last
        elif not tried and diagnosis.is_hopeless(scene, joint_path):
            break
    return best, last


def found_motion(task: Task, joint_path: JointPath, log: Log, *, search: Search = search) -> Candidate:
    """The best motion on the fine grid, on a way past the singularities on which the arm keeps its branch.

    Raises:
        NoSolutionError: there is none; names the constraint in the way.
    """
    ways = passages(task.model, joint_path, coarse_start(task.model, joint_path))
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


@dataclass(frozen=True, slots=True)
class Trial:
    """One changed scene along one joint path."""

    active: ActiveSet
    joint_path: JointPath
    log: Log

    @property
    def scene(self) -> Scene:
        """The objects of the problem at their stated numbers, with the least friction."""
        return self.active.scene

    def start(self, start: Start) -> Stages:
        """A smooth starting motion."""
        return coarse_start(self.active.scene, self.joint_path, start)

    def solve(self, start: Stages, *, iterations: int) -> Candidate:
        """The answer from a start."""
        active = with_near_rows(self.active, start)
        return solved_lazily(active, start, self.log, {"max_iterations": iterations})


@dataclass(frozen=True, slots=True)
class Searcher:
    """A search, as the diagnosis of its failure sees it."""

    task: Task
    log: Log

    @property
    def scene(self) -> Scene:
        """What is searched for."""
        return self.task.searched_scene

    @property
    def out_of_time(self) -> bool:
        """Whether the time of the search is up; a trial has a time of its own."""
        return self.log.out_of_time

    def trial(self, scene: Scene, joint_path: JointPath) -> Trial:
        """A changed scene along a joint path; nothing that is learnt of it comes back to the search."""
        task = Task.of(scene, self.task.ignored)
        ways = passages(task.model, joint_path, coarse_start(task.model, joint_path))
        way = ways[min(1, len(ways) - 1)] if self.task.passage.determinant is not None else ways[0]
        task = replace(task, passage=way)
        return Trial(ActiveSet.of(task, joint_path.q).with_rows(()), joint_path, self.log)

    def last_resort(self, joint_path: JointPath, last: Candidate | None) -> Candidate:
        """The motion that the search has overlooked: it is found where the time is left open, and short enough.

        Raises:
            NoSolutionError: there is none; names the constraint in the way.
        """
        found = diagnosis.last_resort(self, joint_path, last)
        assert isinstance(found, Candidate)  # as `Trial.solve` returns it
        self.log.starts.append(found.stages.duration)
        return replace(found, active=ActiveSet.of(self.task, joint_path.q).with_rows(found.active.rows))
