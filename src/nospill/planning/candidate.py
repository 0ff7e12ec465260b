"""A motion on a grid with what its problem held, and how one is solved."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache, partial
from types import MappingProxyType

from nospill.errors import ModelError
from nospill.laws.constraints.base import RowId
from nospill.motion.trajectory import Trajectory
from nospill.path_search.moved_way import same_surroundings
from nospill.planning.active_set import ActiveSet
from nospill.planning.log import Log
from nospill.transcription.clearance_planes import Planes, separating
from nospill.transcription.export_samples import export_samples
from nospill.transcription.late_sums import late_sums
from nospill.transcription.margins_along import with_margins
from nospill.transcription.passages import keeps_branch_at_nodes, keeps_branch_between
from nospill.transcription.problem import Problem, build_problem
from nospill.transcription.solvers import FEASIBLE, Solution, SolveOptions, carried_over, row_slack, solve, usable
from nospill.transcription.solvers.options import BARRIERS, LOOSE, TIGHT, Options, near_optimum
from nospill.transcription.stages import Stages, node_positions
from nospill.transcription.starting_motions import HIDDEN_AT_START
from nospill.transcription.weights import jerk_cost_dominates

_NEAR_AT_START, _LEAST_TIME = 0.75, 10.0


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A motion on a grid; hashed by identity.

    Attributes:
        active: what its problem held.
        solution: the answer.
        problem: that was solved.
    """

    active: ActiveSet
    solution: Solution
    problem: Problem

    @property
    def stages(self) -> Stages:
        """The motion."""
        return self.solution.stages

    @property
    def has_converged(self) -> bool:
        """Whether the solver converged to an answer that is feasible."""
        return usable(self.solution) and self.solution.converged

    @property
    def planes(self) -> Planes:
        """That keep bodies apart on it."""
        return self.problem.planes_at(self.solution.variables)

    @property
    def keeps_branch(self) -> bool:
        """Whether the arm stays on its branch at the nodes, or is led through a singularity on purpose."""
        return self.active.task.passage.along is not None or keeps_branch_at_nodes(self.active.scene, self.stages)

    @property
    def is_playable(self) -> bool:
        """Whether it does so between the nodes as well."""
        if self.active.task.passage.along is not None:
            return True
        try:
            return keeps_branch_between(self.active.scene, self.stages, exported(self).joint_position)
        except ModelError:
            return False


@lru_cache(maxsize=1)
def exported(candidate: Candidate) -> Trajectory:
    """The samples of a candidate, with the liquids of its problem; kept, since they are read twice.

    Raises:
        ModelError: the joints cannot follow.
    """
    return export_samples(candidate.active.scene, candidate.stages, candidate.active.task.passage.along)


def problem_about(active: ActiveSet, motion: Stages, planes: Planes | None = None) -> Problem:
    """The problem of the active set on a motion's grid, with some planes between bodies or those found about it."""
    objects, q = {name for name, _ in active.members}, node_positions(active.scene, motion)
    problem = build_problem(
        active.scene,
        motion.intervals,
        nominal_duration=active.expected or motion.duration,
        jerk_weight_factor=active.smoothness.factor,
        backoff=active.backoff,
        active=active.rows,
        payload=active.task.payload,
        exact_rest=len(objects) == len(active.members),
        self_motion=motion.self_motion,
        least_determinant=active.task.passage.determinant,
        planes=planes or separating(active.task.scene, active.rows, q, active.everywhere),
        sums=late_sums(active.scene, motion) if active.smoothness.stilled else None,
    )
    return with_margins(problem, motion, active.margins) if active.margins else problem


def planes_like(before: Candidate, active: ActiveSet) -> Planes | None:
    """The planes of an earlier motion about the bodies of another scene; None where other rows or intervals have some.

    None as well where something else stands around.
    """
    if before.active.everywhere != active.everywhere or not before.problem.planes.pairs:
        return None
    if not same_surroundings(before.active.task.scene, active.task.scene):
        return None
    q = node_positions(before.active.scene, before.stages)
    return separating(active.task.scene, active.rows, q, active.everywhere, before.planes)


def slack_of(active: ActiveSet, motion: Stages) -> dict[RowId, float]:
    """What part of its budget every row leaves on a motion, whether it takes part or not."""
    of_clearance = active.task.clearance_slack(node_positions(active.scene, motion))
    of_table = row_slack(problem_about(active.with_rows(active.possible - of_clearance.keys()), motion), motion)
    return of_table | {row: slack - active.backoff[row] for row, slack in of_clearance.items()}


def with_near_rows(active: ActiveSet, start: Stages) -> ActiveSet:
    """The set with the rows that come near their limits on a start, and those of which it says nothing."""
    slack = slack_of(active, start)
    hidden = {row for row in slack if row.constraint in HIDDEN_AT_START}
    return active.with_rows(active.rows | active.near(slack, _NEAR_AT_START) | hidden)


def solved(
    active: ActiveSet,
    start: Stages,
    log: Log,
    options: Options = MappingProxyType({}),
    warm: Candidate | None = None,
    problem: Problem | None = None,
    *,
    tightens: bool = False,
) -> Candidate:
    """Solve on a start's grid with the multipliers of `warm`; where both are of one task, its planes.

    Of a problem of another shape on the same grid those that both have.

    `problem` is the one about the start, where it is at hand; `tightens` says that a judged motion asks for it. Where
    the weights of a longer motion hold the answer back, it is solved again from there with its own.
    """
    planning = active.scene.planning
    stage = "tighten" if tightens else "fine" if start.intervals >= planning.intervals else "coarse"
    with log.phase("build", stage):
        alike = warm is not None and warm.active.task is active.task and warm.active.everywhere == active.everywhere
        planes = warm.planes if warm and alike else None
        problem = problem or problem_about(active, start, planes)
    with log.phase("solve", stage):
        usual = SolveOptions(
            max_iterations=planning.max_iterations,
            max_time=min(planning.max_solve_time, max(log.time_left, _LEAST_TIME)),
            # with modes an iteration takes four times as long, and back-off counts more; on planes further ones follow
            tolerances=LOOSE if active.refined or (stage == "coarse" and problem.planes.groups) else TIGHT,
            progress=partial(log.iteration, stage) if log.progress is not None else None,
        )
        known = warm and _suited(warm, problem)
        solution = solve(problem, start, options=replace(usual, **options), warm=known)
    log.solutions.append(replace(solution, pivot_order=None))  # as large as the factor
    expected, duration = active.expected or start.duration, solution.stages.duration
    if usable(solution) and jerk_cost_dominates(active.scene, expected, duration):
        options = {**options, **near_optimum(BARRIERS[1])}
        again = solved(replace(active, expected=duration), solution.stages, log, options, tightens=tightens)
        if usable(again.solution):
            return again
    return Candidate(active, solution, problem)


def _suited(warm: Candidate, problem: Problem) -> Solution | None:
    """An answer whose multipliers suit another problem; None where too little is alike."""
    if warm.solution.multipliers_for(problem) is not None:
        return warm.solution
    return carried_over(warm.solution, warm.problem, problem)


def solve_lazily(active: ActiveSet, start: Stages, log: Log, options: Options) -> Candidate:
    """Solve; what the answer breaks joins, and it is solved again from there, until it breaks no row."""
    while True:
        candidate = solved(active, start, log, options)
        if not usable(candidate.solution):
            return candidate
        active, slack = candidate.active, slack_of(candidate.active, candidate.stages)
        broken = active.near(slack, -FEASIBLE)
        joining, touching = broken - active.rows, broken & active.task.around_solids
        if not joining and touching <= active.everywhere:
            return replace(candidate, solution=replace(candidate.solution, slack=slack))
        if joining:  # with it what is near its limit, or each would ask for one more solve; planes cost more than that
            joining |= active.near(slack) - active.rows - active.task.around_solids
        active = replace(active.with_rows(active.rows | joining), everywhere=active.everywhere | (touching - joining))
        # where bodies touch, from the start again: no plane leads out of the middle of an obstacle
        if not touching:
            start, options = candidate.stages, {**options, **near_optimum(BARRIERS[1])}
