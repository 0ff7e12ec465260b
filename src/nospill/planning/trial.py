"""What the diagnosis of a failed search may try: changed scenes, solved with the rows that come near."""

from __future__ import annotations

from dataclasses import dataclass, replace

from nospill import diagnosis
from nospill.planning.active_set import ActiveSet
from nospill.planning.candidate import Candidate, solved_lazily, with_near_rows
from nospill.planning.log import Log
from nospill.planning.task import Task, starting_motion
from nospill.robots.joint_paths.search import JointPath
from nospill.scene.scene import Scene
from nospill.transcription.passages import passages
from nospill.transcription.stages import Stages
from nospill.transcription.starting_motions import Start


@dataclass(frozen=True, slots=True)
class Trial:
    """One changed scene along one joint path."""

    task: Task
    active: ActiveSet
    joint_path: JointPath
    log: Log

    @property
    def scene(self) -> Scene:
        """The objects of the problem at their stated numbers, with the least friction."""
        return self.active.scene

    def start(self, start: Start) -> Stages:
        """A smooth starting motion."""
        return starting_motion(self.active.scene, self.joint_path, start)

    def solve(self, start: Stages, *, iterations: int) -> Candidate:
        """The answer from a start."""
        active = with_near_rows(self.task, self.active, start)
        return solved_lazily(self.task, active, start, self.log, {"max_iterations": iterations})


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
        ways = passages(scene, joint_path, starting_motion(scene, joint_path))
        way = ways[min(1, len(ways) - 1)] if self.task.passage.determinant is not None else ways[0]
        task = replace(task, passage=way)
        return Trial(task, ActiveSet.of(task, joint_path.q).with_rows(()), joint_path, self.log)

    def last_resort(self, joint_path: JointPath, last: Candidate | None) -> Candidate:
        """The motion that the search has overlooked: it is found where the time is left open, and short enough.

        Raises:
            NoSolutionError: there is none; names the constraint in the way.
        """
        found = diagnosis.last_resort(self, joint_path, last)
        assert isinstance(found, Candidate)  # as `Trial.solve` returns it
        self.log.durations.append(found.stages.duration)
        active = ActiveSet.of(self.task, joint_path.q)
        return Candidate(self.task, active.with_rows(found.active.rows), found.solution)
