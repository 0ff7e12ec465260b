"""Planning from an earlier answer: how far it breaks the new scene's limits, and how it is solved from there."""

from __future__ import annotations

from nospill.judge.certificate import judge
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.scene_parameters import structure_of
from nospill.planning.active_set import ActiveSet, Key
from nospill.planning.candidate import BARRIERS, Candidate, near_optimum, problem_about, solved, started_from
from nospill.planning.log import Log
from nospill.planning.refinement import REFINE_ITERATIONS, fine_intervals, has_converged
from nospill.planning.task import Task
from nospill.plans.plan import Plan
from nospill.scene.tolerances import is_uncertain
from nospill.transcription.guess import slowed
from nospill.transcription.problem import Problem
from nospill.transcription.solvers import Solution, row_slack
from nospill.transcription.stages import Stages

_WARM_BARRIER = 1e-6
_PUSH_IF_BROKEN = 0.05
_BROKEN_ITERATIONS = 50
_BROKEN = 0.2
_BROKEN_HEIGHT = 0.05
_SLOWEST = 1.5
_BISECTIONS = 6


def restarted(task: Task, earlier: Plan, last: Candidate | None, log: Log) -> Candidate | None:
    """Solve from an earlier plan, with its multipliers where they are at hand; None where neither converges.

    Args:
        task: the new one.
        earlier: plan of a similar scene.
        last: the candidate which that plan was made from.
        log: counts the effort.
    """
    q = earlier.trajectory.joint_position
    if last is not None and not task.ignored:
        active = ActiveSet.of(task, q, last.active.members)
        same = structure_of(active.scene) == structure_of(last.active.scene)
        if same and fine_intervals(active.scene, earlier.duration) == last.stages.intervals:
            active = _cautious(active.with_rows(last.active.rows).with_backoff(last.active.backoff))
            found = _solved_again(task, active, last.stages, log, warm=last.solution)
            if found is not None:
                return found
    with log.phase("certify"):
        judgement = judge(earlier.trajectory, task.scene) if is_uncertain(task.scene) else None
    active = ActiveSet.of(task, q)
    if judgement is not None:
        active = active.joined(task, active.members | active.near_members(judgement), judgement)
    else:
        active = active.without_far(earlier.certificate.rows)
    active = _cautious(active.with_backoff(_recorded_backoff(earlier)))
    start = started_from(task, active, earlier.trajectory, fine_intervals(active.scene, earlier.duration))
    return _solved_again(task, active, start, log, warm=None)


def _cautious(active: ActiveSet) -> ActiveSet:
    """The set with at least the back-off of a restart: one more round of tightening would take longer."""
    return active.with_backoff({key: BY_NAME[key[0]].restart_backoff for key in active.backoff})


def _solved_again(task: Task, active: ActiveSet, start: Stages, log: Log, *, warm: Solution | None) -> Candidate | None:
    """Solve from a motion of an earlier scene, slowed down if the new one has tighter limits."""
    log.tried += 1
    problem = problem_about(task, active, start)
    if is_broken(problem, start):
        start = slow_enough(problem, start)
        options = {"bound_push": _PUSH_IF_BROKEN, "max_iterations": _BROKEN_ITERATIONS, "loose_tolerances": True}
        found = solved(task, active, start, log, options, warm=warm)
        if not found.solution.converged:
            found = solved(task, active, start, log, near_optimum(BARRIERS[1], REFINE_ITERATIONS))
    else:
        barrier = _WARM_BARRIER if warm else BARRIERS[0]
        options = {**near_optimum(barrier, REFINE_ITERATIONS), "loose_tolerances": True}
        found = solved(task, active, start, log, options, warm=warm)
    if not (has_converged(found.solution) and found.keeps_branch):
        return None
    log.durations.append(found.stages.duration)
    return found


def _recorded_backoff(earlier: Plan) -> dict[Key, float]:
    """The back-off that a plan records, by row."""
    found: dict[Key, float] = {}
    for label, value in earlier.report.backoff.items():
        constraint, _, subject = label.partition(" | ")
        found[constraint, subject] = value
    return found


def is_broken(problem: Problem, motion: Stages) -> bool:
    """Whether a motion breaks rows of a problem so far that the multipliers of its own problem are no help.

    The height of a liquid follows from all of the motion before, the rest from the instant: it is harder to mend.
    """
    slack = row_slack(problem, motion)
    return any(value < -(_BROKEN_HEIGHT if key[0] == SloshHeight.name else _BROKEN) for key, value in slack.items())


def slow_enough(problem: Problem, motion: Stages) -> Stages:
    """The motion slowed down as little as keeps the rows of the problem; itself if slowing down does not help.

    From a motion that breaks many rows, the first dozen steps of an interior point method each end at the next bound.

    Args:
        problem: whose rows; how it is scaled does not matter.
        motion: on its grid.
    """

    def keeps(factor: float) -> bool:
        slow = slowed(motion, layout, factor)
        return min(row_slack(problem, slow).values(), default=0.0) >= 0.0

    layout = problem.transcription.layout
    low, high = 1.0, _SLOWEST
    if not keeps(high):
        return motion
    for _ in range(_BISECTIONS):
        middle = (low * high) ** 0.5
        low, high = (low, middle) if keeps(middle) else (middle, high)
    return slowed(motion, layout, high)
