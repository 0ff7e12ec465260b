"""From a scene to a plan: joint path, search on a coarse grid, refinement until the certificate holds."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Iterator
from contextlib import nullcontext, suppress
from dataclasses import replace

from nospill import diagnosis
from nospill.compiled.codegen import compiles_afterwards
from nospill.errors import NoSolutionError
from nospill.judge.limiting import longest_held
from nospill.judge.tracks import with_recorded_modes
from nospill.laws.constraints.base import Constraint
from nospill.laws.scene_parameters import structure_of
from nospill.path_search.base_yaw import base_yaw_text, choose_base_yaw, has_free_base
from nospill.path_search.branches import free_paths
from nospill.path_search.candidates import has_free_path
from nospill.path_search.free_path import fastest_clear_path, paths_along
from nospill.planning.candidate import Candidate
from nospill.planning.log import Log, OnProgress
from nospill.planning.log import PlanningProgress as PlanningProgress
from nospill.planning.refinement import Judged, certified_by_refinement
from nospill.planning.request import earlier_plan, ignored_constraints, requested_scene
from nospill.planning.search import PassageSearch, found_motion, passage_searches, searcher
from nospill.planning.task import Task
from nospill.planning.warm_start import restarted, restarted_on, started_beside
from nospill.plans.approach import require_ruckig_if_needed, starts_alike, with_approach
from nospill.plans.plan import Plan, judged_plan
from nospill.robots.joint_paths.search import branch_in_words, preferred_path
from nospill.scenario.loading import ScenarioSource
from nospill.scene.scene import Scene
from nospill.transcription.sensitivity import savings


def plan(
    scene: Scene | ScenarioSource,
    *,
    constraints: Iterable[Constraint] | None = None,
    warm: Plan | None = None,
    ignore: Collection[str] | str = (),
    progress: OnProgress | None = None,
) -> Plan:
    """Find the fastest motion of a scene and certify it.

    Args:
        scene: the task, or what `load` takes.
        constraints: limits of your own classes, beside those of the scenario; the plan's scene has them from then on.
        warm: an earlier plan of a similar scene (same robot, tilt and liquids), from which to start instead of
            searching; where that leads nowhere, the search is made all the same.
        ignore: names of constraints that the optimiser leaves out, to see what they cost. The certificate leaves out
            none.
        progress: called with where planning stands.

    Returns:
        The plan; its status is "uncertified" if a row still fails after the last tightening.

    Raises:
        ScenarioError: no valid scenario describes the scene, the robot cannot follow the path, `ignore` names no
            constraint, or one of `constraints` is none, is about nothing in the scene or fails.
        NoSolutionError: no start led to a motion, no approach to it, or no branch of the arm past the obstacles; names
            what is in the way.
        MissingExtraError: the scene has an approach and ruckig is not installed, or obstacles and coal is not.
    """
    scene, warm = requested_scene(scene, constraints), earlier_plan(warm)
    ignored = ignored_constraints(ignore, scene)
    return _planned(scene, warm=warm, last=None, ignore=ignored, progress=progress)[0]


@compiles_afterwards
def _planned(
    scene: Scene, *, warm: Plan | None, last: Candidate | None, ignore: Collection[str], progress: OnProgress | None
) -> tuple[Plan, Candidate]:
    """`plan`, with the candidate that the next one may start from."""
    require_ruckig_if_needed(scene)
    log = Log(progress, scene.planning.max_plan_time)
    base_is_free = has_free_base(scene)
    if base_is_free:
        with log.phase("base yaw"), diagnosis.advised(scene, lambda scene: searcher(Task.of(scene, ignore), log)):
            scene = choose_base_yaw(scene)
    if has_free_path(scene):
        with log.phase("way"), diagnosis.advised(scene, lambda scene: searcher(Task.of(scene, ignore), log)):
            scene = fastest_clear_path(scene)
    task = Task.of(scene, ignore)
    judged = _first_certified(_candidates(task, warm, last, log), log)
    report = log.report(
        judged.candidate.solution.status,
        backoff=judged.candidate.active.increased(),
        jerk_weight_factor=judged.candidate.active.jerk_weight_factor,
        branch=branch_in_words(judged.trajectory.joint_position[0]),
        base_yaw=base_yaw_text(scene) if base_is_free else None,
    )
    found = judged_plan(scene, with_recorded_modes(judged.trajectory, scene), judged.judgement, report)
    answer, limits = judged.candidate, longest_held(found.maxima.time_at_limit)
    saved = savings(answer.problem, answer.solution, limits) if answer.has_converged else {}
    with log.phase("approach") if scene.approach is not None else nullcontext():
        found = with_approach(found)
    report = replace(report, savings=saved, plan_time=time.perf_counter() - log.began, phases=dict(log.phases))
    return replace(found, report=report), judged.candidate


def _candidates(task: Task, warm: Plan | None, last: Candidate | None, log: Log) -> Iterator[Candidate]:
    """Motions on the fine grid, each for when the one before is not certified; raises what `plan` does."""
    scene = task.scene
    alike = warm is not None and starts_alike(warm.scene, scene)  # else its branch may be another
    if warm is not None and alike and (found := restarted(task, warm, last, log)) is not None:
        yield found
    with log.phase("kinematics"), diagnosis.advised(scene, lambda scene: searcher(Task.of(scene, task.ignored), log)):
        paths = free_paths(scene, paths_along(scene))
    joint_path = preferred_path(paths, scene.robot, scene.start_near)
    if warm is not None and not alike and (found := restarted_on(task, warm, joint_path, log)) is not None:
        yield found
    searches = passage_searches(task, joint_path)
    with suppress(NoSolutionError) if scene.motion.leaves_path else nullcontext():
        yield found_motion(searches, log)
    if scene.motion.leaves_path:  # the motion on the path is a start, and what is left where no other is certified
        on_path = passage_searches(task.on_path, joint_path)
        given = certified_by_refinement(found_motion(on_path, log), log)
        again = started_beside(task, given, log)
        yield from (found for found in (again, given.candidate) if found is not None)
    yield found_motion(searches, log, PassageSearch.further)


def _first_certified(candidates: Iterator[Candidate], log: Log) -> Judged:
    """The first motion that is certified after refinement, the first of all where none is; raises what `plan` does."""
    judged: list[Judged] = []
    failures: list[NoSolutionError] = []
    try:
        for candidate in candidates:
            try:
                judged.append(certified_by_refinement(candidate, log))
            except NoSolutionError as error:  # it cannot be played: the next one may be
                failures.append(error)
            certified = any(one.judgement.certificate.ok for one in judged)
            if certified or candidate.active.task.ignored or log.out_of_time:
                break
    except NoSolutionError as error:
        failures.append(error)
    if not judged:
        raise failures[0]
    return judged[-1] if judged[-1].judgement.certificate.ok else judged[0]


class Planner:
    """Plans scene after scene, each from the answer before where the structure is the same, limits given here apart.

    Not thread-safe: one per thread.
    """

    def __init__(self, last: Plan | None = None, *, constraints: Iterable[Constraint] | None = None) -> None:
        """Start with nothing, or with an earlier plan (for example `load_plan(folder)`).

        Args:
            last: the earlier plan.
            constraints: of every plan that is not given its own, as in `plan`.
        """
        self.last = earlier_plan(last)
        self.constraints = None if constraints is None else tuple(constraints)
        self._candidate: Candidate | None = None

    def plan(
        self,
        scene: Scene | ScenarioSource,
        *,
        constraints: Iterable[Constraint] | None = None,
        progress: OnProgress | None = None,
    ) -> Plan:
        """`plan(scene)`, warm from the last plan if that was of the same structure; raises the same."""
        scene = requested_scene(scene, self.constraints if constraints is None else constraints)
        similar = self.last is not None and _alike(self.last.scene, scene)
        self.last, self._candidate = _planned(
            scene, warm=self.last if similar else None, last=self._candidate, ignore=(), progress=progress
        )
        return self.last


def _alike(first: Scene, second: Scene) -> bool:
    """Whether two scenes are of one structure but for limits given from Python, which add rows alone."""
    ours, theirs = (
        structure_of(scene.with_constraints(()) if scene.constraints else scene) for scene in (first, second)
    )
    return ours == theirs
