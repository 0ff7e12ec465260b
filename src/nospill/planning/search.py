"""Starts on a coarse grid until one converges: the best answer, or the reason why there is none."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

from nospill import diagnosis
from nospill.diagnosis import Answer, Searcher, Trial
from nospill.errors import NoSolutionError
from nospill.planning.active_set import ActiveSet
from nospill.planning.attempts import Attempt, attempts, first_attempts
from nospill.planning.candidate import Candidate, solve_lazily, with_near_rows
from nospill.planning.log import Log
from nospill.planning.refinement import to_fine_grid
from nospill.planning.task import Task
from nospill.robots.joint_paths.search import JointPath
from nospill.scene.scene import Scene
from nospill.transcription.passages import passages
from nospill.transcription.solvers import usable
from nospill.transcription.stages import Stages
from nospill.transcription.starting_motions import coarse_start, estimate_duration

_LONG = 0.79
"""Part of the longest motion allowed; where even the estimate takes it, a look at that motion saves a vain search."""


@dataclass(frozen=True, slots=True)
class PassageSearch:
    """The search on one passage of the arm's singularities: made once, and gone on with where it was left.

    Attributes:
        task: with that passage.
        joint_path: along which is searched.
        attempts: that have not been made yet.
    """

    task: Task
    joint_path: JointPath
    attempts: Iterator[Attempt]

    def first(self, log: Log) -> Candidate:
        """The best answer on the coarse grid.

        Raises:
            NoSolutionError: there is none; where the search is brief, without much of a reason.
        """
        task, joint_path, scene = self.task, self.joint_path, self.task.searched_scene
        log.passage_begins()
        best = last = None
        long = estimate_duration(scene, joint_path) >= _LONG * scene.motion.longest
        if not (long and diagnosis.is_hopeless(scene, joint_path)):
            brief = task.passage.brief or scene.motion.duration is not None
            tries = islice(self.attempts, first_attempts(task)) if brief else self.attempts
            best, last = best_of(task, joint_path, log, tries)
        if best is not None:
            return best
        if task.passage.brief:
            raise NoSolutionError("No motion found at once.")
        return _overlooked_motion(task, joint_path, last, log)

    def further(self, log: Log) -> Candidate:
        """The best answer on the coarse grid of the attempts that are left.

        Raises:
            NoSolutionError: there is none.
        """
        found, _ = best_of(self.task, self.joint_path, log, self.attempts)
        if found is None:
            raise NoSolutionError("No other motion found.")
        return found


Search = Callable[[PassageSearch, Log], Candidate]


def passage_searches(task: Task, joint_path: JointPath) -> tuple[PassageSearch, ...]:
    """A search on each passage of the singularities along a joint path, in the order in which they are made."""
    ways = passages(task.model, joint_path, coarse_start(task.model, joint_path))
    tasks = [replace(task, passage=way) for way in ways]
    return tuple(PassageSearch(own, joint_path, iter(attempts(own))) for own in tasks)


def best_of(
    task: Task, joint_path: JointPath, log: Log, tries: Iterable[Attempt]
) -> tuple[Candidate | None, Candidate | None]:
    """The best answer and the last one of several attempts, None where there is none.

    The first answer ends it, or the best of as many starts as the scenario compares; no further attempt is drawn then.
    """
    scene = task.searched_scene
    active = ActiveSet.of(task, joint_path.q).with_rows(())
    best: Candidate | None = None
    last: Candidate | None = None
    for tried, attempt in enumerate(tries, start=1):
        motion = coarse_start(active.scene, joint_path, attempt.start)
        rows = active.possible if attempt.all_rows else active.rows
        active = with_near_rows(active.with_rows(rows), motion)
        last = solve_lazily(active, motion, log, attempt.options)
        active = last.active
        log.starts.append(last.stages.duration if usable(last.solution) else None)
        if usable(last.solution):
            if best is None or last.solution.objective < best.solution.objective:
                best = last
        elif tried == 1 and diagnosis.is_hopeless(scene, joint_path):
            break
        if log.out_of_time or (best is not None and tried >= scene.planning.starts):
            break
    return best, last


def find_motion(searches: Sequence[PassageSearch], log: Log, search: Search = PassageSearch.first) -> Candidate:
    """The best motion on the fine grid, on a way past the singularities on which the arm keeps its branch.

    Args:
        searches: on each passage.
        log: of the call.
        search: what is made of each; `PassageSearch.further` for the attempts that are left.

    Raises:
        NoSolutionError: there is none; names the constraint in the way.
    """
    *first, last = searches
    for attempt in first:
        passage = attempt.task.passage
        try:
            coarse = search(attempt, log)
        except NoSolutionError:
            if not passage.brief:
                raise
            continue
        if coarse.keeps_branch or passage.brief:
            fine = to_fine_grid(coarse, log)
            if fine.is_playable:
                return fine
    return to_fine_grid(search(last, log), log)


def searcher(task: Task, log: Log) -> Searcher:
    """A search, as the diagnosis of its failure sees it: nothing that is learnt of a changed scene comes back to it."""

    def trial(scene: Scene, joint_path: JointPath) -> Trial:
        changed = Task.of(scene, task.ignored)
        ways = passages(changed.model, joint_path, coarse_start(changed.model, joint_path))
        way = ways[min(1, len(ways) - 1)] if task.passage.determinant is not None else ways[0]
        active = ActiveSet.of(replace(changed, passage=way), joint_path.q).with_rows(())

        def solve(start: Stages, iterations: int) -> Answer:
            found = solve_lazily(with_near_rows(active, start), start, log, {"max_iterations": iterations})
            return Answer(found.solution, found.problem)

        return Trial(active.scene, solve)

    return Searcher(task.searched_scene, trial, lambda: log.out_of_time)


def _overlooked_motion(task: Task, joint_path: JointPath, last: Candidate | None, log: Log) -> Candidate:
    """The motion that the search has overlooked: it is found where the time is left open, and short enough.

    Raises:
        NoSolutionError: there is none; names the constraint in the way.
    """
    tried = last and Answer(last.solution, last.problem)
    motion = diagnosis.last_resort(searcher(task, log), joint_path, tried)
    log.starts.append(motion.solution.stages.duration)
    active = ActiveSet.of(task, joint_path.q).with_rows(place.row for place in motion.problem.places)
    return Candidate(active, motion.solution, motion.problem)
