"""A motion on a grid with the problem it answers, and how one is solved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType
from typing import Any

from nospill.errors import ModelError
from nospill.judge.tracks import liquid_tracks
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.motion.trajectory import Trajectory
from nospill.planning.active_set import ActiveSet
from nospill.planning.log import Log
from nospill.planning.task import Task
from nospill.robots.kinematics.regularity import determinants, keeps_branch
from nospill.scene.tolerances import corner_scenes
from nospill.transcription.export_samples import export_samples, with_joints_solved
from nospill.transcription.passages import stage_determinants
from nospill.transcription.problem import Backoff, Problem, build_problem
from nospill.transcription.solvers import FEASIBLE, Solution, SolveOptions, row_slack, solve, usable
from nospill.transcription.stages import Stages
from nospill.transcription.trajectory_start import from_trajectory

Options = Mapping[str, Any]
"""Fields of `SolveOptions` that differ from those of the scene."""

BARRIERS = (1e-5, 1e-4, 0.1)
"""First barrier parameters from a start that is nearly optimal, in the order in which they are tried."""
NO_PUSH = 1e-6
"""Scaled distance from its bounds to which such a start is moved."""
_NEAR_AT_START = 0.75
_LEAST_TIME = 10.0


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A motion on a grid; hashed by identity.

    Attributes:
        task: what it is for.
        active: what its problem held.
        solution: the answer.
    """

    task: Task
    active: ActiveSet
    solution: Solution

    @property
    def stages(self) -> Stages:
        """The motion."""
        return self.solution.stages

    @property
    def backoff(self) -> Backoff:
        """Fraction of every budget that was kept from the optimiser."""
        return self.active.backoff

    def problem(self) -> Problem:
        """The problem that the motion answers."""
        return problem_about(self.task, self.active, self.stages)

    @property
    def keeps_branch(self) -> bool:
        """Whether the arm stays on its branch at the nodes, or is led through a singularity on purpose."""
        along = self.task.passage.along
        return along is not None or keeps_branch(stage_determinants(self.active.scene, self.stages))

    @property
    def is_playable(self) -> bool:
        """Whether it does so between the nodes as well."""
        if self.task.passage.along is not None:
            return True
        try:
            joints = exported(self).joint_position
        except ModelError:
            return False
        return keeps_branch(determinants(self.active.scene.robot, joints, self.stages.self_motion))


@lru_cache(maxsize=1)
def exported(candidate: Candidate) -> Trajectory:
    """The samples of a candidate, with the liquids of its problem; kept, since they are read twice.

    Raises:
        ModelError: the joints cannot follow.
    """
    # where joints cross a singularity, no instant of the problem knows on which branch the one before was
    along, stages = candidate.task.passage.along, candidate.stages
    if along is not None:
        stages = with_joints_solved(candidate.active.scene, stages, along)
    return export_samples(candidate.active.scene, stages)


def recorded(candidate: Candidate) -> Trajectory:
    """The samples of a motion with the stated liquids of the whole scene, which is what a plan records.

    Raises:
        ModelError: the joints cannot follow, or the liquids cannot be integrated.
    """
    trajectory, scene = exported(candidate), candidate.task.scene
    if [item.name for item in candidate.active.scene.cargo] == [item.name for item in scene.cargo]:
        return trajectory
    return replace(trajectory, slosh=liquid_tracks(trajectory, scene, {item.name: item.name for item in scene.cargo}))


def problem_about(task: Task, active: ActiveSet, motion: Stages) -> Problem:
    """The problem of the active set on a motion's grid."""
    objects = {member[0] for member in active.members}
    return build_problem(
        active.scene,
        motion.intervals,
        nominal_duration=motion.duration,
        backoff=active.backoff,
        active=active.rows,
        payload=task.payload,
        # several variants of one object come to rest at several instants
        exact_rest=len(objects) == len(active.members),
        self_motion=motion.self_motion,
        least_determinant=task.passage.determinant,
    )


def slack_of(task: Task, active: ActiveSet, motion: Stages) -> dict[RowId, float]:
    """What part of its budget every row leaves on a motion, whether it takes part or not."""
    whole = active.with_rows(active.possible)
    return row_slack(problem_about(task, whole, motion), motion)


def solved(
    task: Task,
    active: ActiveSet,
    start: Stages,
    log: Log,
    options: Options = MappingProxyType({}),
    warm: Solution | None = None,
) -> Candidate:
    """Solve on the grid of a start.

    Args:
        task: what for.
        active: what takes part.
        start: the motion to start from.
        log: counts the effort.
        options: what differs from the scene's.
        warm: an answer of a problem of the same shape, whose multipliers are used.
    """
    planning = task.scene.planning
    with log.phase("build"):
        problem = problem_about(task, active, start)
    with log.phase("solve"):
        usual = SolveOptions(
            max_iterations=planning.max_iterations,
            max_time=min(planning.max_solve_time, max(log.time_left, _LEAST_TIME)),
            progress=log.iteration if log.progress is not None else None,
        )
        solution = solve(problem, start, solver=planning.solver, options=replace(usual, **options), warm=warm)
    log.add(solution)
    return Candidate(task, active, solution)


def near_optimum(barrier: float, iterations: int) -> Options:
    """Options of a solve whose start is nearly optimal: a small first barrier, and no push off the bounds."""
    return {"barrier_start": barrier, "bound_push": NO_PUSH, "max_iterations": iterations}


def with_near_rows(task: Task, active: ActiveSet, start: Stages) -> ActiveSet:
    """The set with the rows that come near their limits on a start whose liquids are at rest."""
    slack = slack_of(task, active, start)
    heights = {key for key in slack if key.constraint == SloshHeight.name}  # which says nothing about these
    return active.with_rows(active.rows | active.near(slack, _NEAR_AT_START) | heights)


def solved_lazily(task: Task, active: ActiveSet, start: Stages, log: Log, options: Options) -> Candidate:
    """Solve; what the answer breaks joins, and it is solved again from there, until it breaks no row."""
    while True:
        candidate = solved(task, active, start, log, options)
        if not usable(candidate.solution):
            return candidate
        slack = slack_of(task, active, candidate.stages)
        broken = active.near(slack, -FEASIBLE)
        if broken <= active.rows:
            return replace(candidate, solution=replace(candidate.solution, slack=slack))
        active, start = active.with_rows(active.rows | broken), candidate.stages
        options = {**options, "barrier_start": BARRIERS[1], "bound_push": NO_PUSH}


def started_from(task: Task, active: ActiveSet, trajectory: Trajectory, intervals: int) -> Stages:
    """A motion of the whole scene as a start for the members of a problem."""
    names = task.names()
    found = dict(trajectory.slosh)
    for corner in corner_scenes(task.scene):
        wanted = {name: names[name, text] for name, text in corner.texts.items() if (name, text) in active.members}
        found |= liquid_tracks(trajectory, corner.scene, wanted) if wanted else {}
    return from_trajectory(active.scene, replace(trajectory, slosh=found), intervals)
