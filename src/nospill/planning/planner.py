"""From a scene to a plan: joint path, search on a coarse grid, refinement until the certificate holds."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import nullcontext
from dataclasses import replace

from nospill import diagnosis
from nospill.certification.limiting import longest_held
from nospill.certification.tracks import with_recorded_modes
from nospill.certification.wording import finding
from nospill.compiled.codegen import compiles_afterwards
from nospill.core.blas_threads import one_blas_thread
from nospill.errors import NoSolutionError, ScenarioError
from nospill.laws.constraints.base import Constraint
from nospill.path_search.base_yaw import base_yaw_text, choose_base_yaw, has_free_base
from nospill.path_search.branches import require_free_ends
from nospill.path_search.candidates import has_free_path
from nospill.path_search.direct_way import blocked_direct_way
from nospill.path_search.end_yaws import choose_end_yaws, end_yaws_text, free_ends
from nospill.path_search.free_path import fastest_clear_path, paths_along
from nospill.path_search.standing import advised_free_paths, require_standing_room
from nospill.planning.candidate import Candidate
from nospill.planning.fallbacks import REST_INSTEAD, fallbacks, on_path_instead
from nospill.planning.first_order import duration_change
from nospill.planning.log import Log, OnProgress
from nospill.planning.log import PlanningProgress as PlanningProgress
from nospill.planning.refinement import Judged
from nospill.planning.request import (
    begun_in,
    earlier_plan,
    ignored_constraints,
    requested_scene,
    rest_along,
)
from nospill.planning.search import PassageSearch, Search, find_motion, passage_searches, searcher
from nospill.planning.shortening import certify_by_refinement
from nospill.planning.task import Task
from nospill.planning.tracking_margins import require_band
from nospill.planning.warm_start import (
    NOT_CERTIFIED,
    NOT_CONVERGED,
    going_elsewhere,
    going_on,
    restart,
    restart_on_branch,
    start_off_path,
    what_is_left,
)
from nospill.planning.way_before import along_way_before, of_one_structure
from nospill.planning.widest_range import range_reached
from nospill.plans.approach import require_ruckig_if_needed, starts_alike, with_approach
from nospill.plans.plan import Plan, judged_plan
from nospill.plans.state import MotionState, start_moved
from nospill.robots.joint_paths.search import JointPath, branch_in_words, path_through, preferred_path
from nospill.scenario.loading import ScenarioSource
from nospill.scene.scene import Scene
from nospill.transcription.sensitivity import savings

_AS_LONG, _SHORT = 1.001, 0.25
"""Ratio to what is left of a motion up to which one that goes on from it counts as no longer; s, of which hardly any
stop is sooner, and none is looked for from afar."""


def plan(
    scene: Scene | ScenarioSource,
    *,
    constraints: Iterable[Constraint] | None = None,
    warm: Plan | None = None,
    start: MotionState | None = None,
    stop: bool = False,
    ignore: Collection[str] | str = (),
    progress: OnProgress | None = None,
) -> Plan:
    """Find the fastest motion of a scene and certify it.

    Args:
        scene: the task, or what `load` takes.
        constraints: limits of your own classes, added to those of the scenario; the plan's scene has them from then on.
        warm: an earlier plan of a similar scene (same robot, tilt and liquids), from which to start instead of
            searching; where that leads nowhere, the search is made all the same.
        start: the state that the motion goes on from, as `plan.state_at(0.7)` gives it; at rest when left out. Without
            `warm`, what is left of that plan is where its solution starts from.
        stop: whether the motion from that state may come to rest anywhere on its path, level and as soon as it can.
        ignore: names of constraints that the optimiser leaves out, to see what they cost. The certificate leaves out
            none.
        progress: called with where planning stands.

    Returns:
        The plan; its status is "uncertified" if a row still fails after the last tightening.

    Raises:
        ScenarioError: no valid scenario describes the scene, or none that begins in that state; the robot cannot follow
            the path, `ignore` names no constraint, or one of `constraints` is none, is about nothing in the scene or
            fails.
        NoSolutionError: no start led to a motion, no approach to it, or no branch of the arm past the obstacles; names
            what is in the way.
        MissingExtraError: the scene has an approach and ruckig is not installed.
    """
    asked, warm = requested_scene(scene, constraints), earlier_plan(warm)
    scene = begun_in(asked, start, stop=stop)
    ignored = ignored_constraints(ignore, scene)
    moved = "" if start is None else start_moved(asked, start)
    return _plan(scene, warm=warm, start=start, last=None, ignore=ignored, progress=progress, moved=moved)[0]


@one_blas_thread()
@compiles_afterwards
def _plan(
    scene: Scene,
    *,
    warm: Plan | None,
    last: Candidate | None,
    ignore: Collection[str],
    progress: OnProgress | None,
    start: MotionState | None = None,
    moved: str = "",
) -> tuple[Plan, Candidate]:
    """`plan`, with the candidate that the next one may start from; `moved` is `start_moved` of what was asked for."""
    require_ruckig_if_needed(scene)
    if scene.motion.stoppable is not None:
        raise ScenarioError(
            f"{scene.name}: motion.stoppable is looked for by nospill plan and ns.plan_stoppable(scene) alone, "
            "which plan several times; leave it out here"
        )
    log = Log(progress, scene.planning.max_plan_time)
    base_is_free = has_free_base(scene)
    if base_is_free:
        with log.phase("base yaw"), diagnosis.advised(scene, lambda scene: searcher(Task.of(scene, ignore), log)):
            scene = choose_base_yaw(scene)
    free = free_ends(scene)
    if free:
        with log.phase("yaw of the ends"):
            scene = choose_end_yaws(scene)
    with log.phase("ends"):
        if scene.obstacles:
            require_free_ends(scene)
        require_standing_room(scene)
    open_scene, instead = scene, ""
    tried = warm is not None and scene.initial_state is None and has_free_path(scene)
    judged = along_way_before(scene, warm, last, ignore, log) if warm is not None and tried else None
    if judged is None:
        scene, judged, instead = _searched(scene, None if tried else warm, last, ignore, start, log)
    else:
        scene = judged.candidate.active.task.scene
    task = judged.candidate.active.task
    require_band(scene, judged.judgement, ended=log.out_of_time)
    reached = range_reached(judged.trajectory, judged.judgement, task)
    taken = (instead,) if instead == REST_INSTEAD else fallbacks(judged.candidate, log, instead, reached)
    report = log.report(
        judged.candidate.solution.status,
        backoff=judged.candidate.active.increased(),
        jerk_weight_factor=judged.candidate.active.smoothness.factor,
        branch=branch_in_words(judged.trajectory.joint_position[0]),
        base_yaw=base_yaw_text(scene) if base_is_free else None,
        end_yaws=end_yaws_text(scene, free) if free else None,
        blocked_way=blocked_direct_way(open_scene, scene),
        fallbacks=(moved, *taken) if moved else taken,
        warm=warm is not None and not log.not_warm,
    )
    planned = judged_plan(scene, with_recorded_modes(judged.trajectory, scene), judged.judgement, report)
    answer, limits = judged.candidate, longest_held(planned.maxima.time_at_limit)
    saved = savings(answer.problem, answer.solution, limits) if answer.has_converged else {}
    with log.phase("approach") if scene.approach is not None else nullcontext():
        planned = with_approach(planned)
    report = replace(report, savings=saved, plan_time=time.perf_counter() - log.began, phases=dict(log.phases))
    return replace(planned, report=report), judged.candidate


def _searched(
    open_scene: Scene,
    warm: Plan | None,
    last: Candidate | None,
    ignore: Collection[str],
    start: MotionState | None,
    log: Log,
) -> tuple[Scene, Judged, str]:
    """The scene with its way, its motion, and what that stands in the place of; raises what `plan` does."""
    scene = open_scene
    if has_free_path(scene):
        with log.phase("way"), diagnosis.advised(scene, lambda scene: searcher(Task.of(scene, ignore), log)):
            scene = fastest_clear_path(open_scene)
    diagnosis.require_bearable_lean(scene, diagnosis.MOST_LEAN)
    task = Task.of(scene, ignore)
    compared = warm is None and scene.motion.duration is None and not task.ignored
    rest = rest_along(scene, start)
    left = what_is_left(task, rest, log) if rest is not None and compared else None
    judged, instead = _first_certified(_offers(task, warm, start, last, left, log), log)
    if left is not None and judged.trajectory.end_time > _AS_LONG * left.trajectory.end_time:
        judged, instead = left, REST_INSTEAD
    return scene, judged, instead


def _offers(
    task: Task,
    warm: Plan | None,
    begun: MotionState | None,
    last: Candidate | None,
    left: Judged | None,
    log: Log,
) -> Iterator[Candidate | Judged | NoSolutionError]:
    """Motions on the fine grid, each for when the one before is not certified; raises what `plan` does.

    Of a motion that goes on from a state `left` is what is left of the one before, where that is certified.

    Where the tray may leave its path, errors of searches are among them, and last is the motion on the path itself,
    which is judged already.
    """
    scene = task.scene
    alike = warm is not None and starts_alike(warm.scene, scene)  # else its branch may be another
    if warm is not None and alike:
        candidate = restart(task, warm, last, log)
        yield from _warm(candidate, log)
        if candidate is not None and log.out_of_time:
            return
    rest = rest_along(scene, begun)
    if warm is None and rest is not None and (candidate := going_on(task, rest, log)) is not None:
        yield candidate
        if log.out_of_time:
            return
    if left is not None and (not scene.motion.stop or left.trajectory.end_time < _SHORT):
        yield left
    with log.phase("kinematics"), diagnosis.advised(scene, lambda scene: searcher(Task.of(scene, task.ignored), log)):
        paths = advised_free_paths(scene, paths_along(scene))
    state = scene.initial_state
    if state is None:
        joint_path = preferred_path(paths, scene.robot, scene.start_near)
    else:
        joint_path = path_through(paths, state.s, state.joints[0])
    if warm is not None and not alike:
        candidate = restart_on_branch(task, warm, joint_path, log)
        yield from _warm(candidate, log)
        if candidate is not None and log.out_of_time:
            return
    searches = passage_searches(task, joint_path)
    if scene.motion.leaves_path:
        yield from _off_path(task, joint_path, searches, begun, log)
        if left is not None:
            yield left
        return
    if left is not None:  # a stop may be sooner than that
        yield _find_or_explain(searches, log, PassageSearch.first)
        yield left
        return
    yield find_motion(searches, log)
    if not log.out_of_time:
        yield find_motion(searches, log, PassageSearch.further)


def _warm(candidate: Candidate | None, log: Log) -> Iterator[Candidate]:
    """A candidate from an earlier plan where there is one; whoever asks for more was not served by it."""
    if candidate is not None:
        yield candidate
    if candidate is None or not log.out_of_time:
        log.not_warm = NOT_CONVERGED if candidate is None else NOT_CERTIFIED


def _off_path(
    task: Task, joint_path: JointPath, searches: Sequence[PassageSearch], begun: MotionState | None, log: Log
) -> Iterator[Candidate | Judged | NoSolutionError]:
    """`_offers` where the tray may leave its path: the motion on the path is a start, and taken where all else fails.

    A motion that goes on from a state leaves the path at once: there it is what is left of the motion before, bent.

    Raises:
        NoSolutionError: there is no motion on the path either.
    """
    yield _find_or_explain(searches, log, PassageSearch.first)
    if log.out_of_time:
        return
    if task.scene.initial_state is not None:
        if begun is not None and not task.scene.motion.stop:
            yield from going_elsewhere(task, begun.rest, log)
        if not log.out_of_time:
            yield _find_or_explain(searches, log, PassageSearch.further)
        return
    given = certify_by_refinement(find_motion(passage_searches(task.on_path, joint_path), log), log)
    if (again := start_off_path(task, given, log)) is not None:
        yield again
    if not log.out_of_time:
        yield _find_or_explain(searches, log, PassageSearch.further)
    yield given


def _find_or_explain(searches: Sequence[PassageSearch], log: Log, search: Search) -> Candidate | NoSolutionError:
    try:
        return find_motion(searches, log, search)
    except NoSolutionError as error:
        return error


def _first_certified(offers: Iterator[Candidate | Judged | NoSolutionError], log: Log) -> tuple[Judged, str]:
    """The first motion that is certified after refinement, the first of all where none is; raises what `plan` does.

    With it, where it is the motion on the path in the place of a faster one, the sentence that says so.
    """
    judged: list[Judged] = []
    failures: list[NoSolutionError] = []
    why = ""
    try:
        for offer in offers:
            try:
                if isinstance(offer, NoSolutionError):
                    raise offer
                one = offer if isinstance(offer, Judged) else certify_by_refinement(offer, log)
            except NoSolutionError as error:  # it cannot be played: the next one may be
                failures.append(error)
                why = why or str(error)
                continue
            if one.judgement.certificate.ok:
                if one is not offer:
                    return one, ""
                return one, REST_INSTEAD if one.trajectory.in_motion else on_path_instead(why)
            judged.append(one)
            why = why or finding(one.judgement.certificate)
            if one.candidate.active.task.ignored or one.candidate.active.task.scene.tracking is not None:
                break  # another start does not make an arm less late
    except NoSolutionError as error:
        failures.append(error)
    if not judged:
        raise failures[0]
    return judged[0], ""


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
        similar = self.last is not None and of_one_structure(self.last.scene, scene)
        planned, self._candidate = _plan(
            scene, warm=self.last if similar else None, last=self._candidate, ignore=(), progress=progress
        )
        if self.last is not None and not similar:
            planned = replace(
                planned, report=replace(planned.report, not_warm="the scene before is of another structure")
            )
        self.last = planned
        return planned

    def duration_change(self, scene: Scene | ScenarioSource) -> float:
        """Seconds by which the last motion would be longer in another scene, to the first order; no motion is planned.

        The multipliers say it, as they say what a wider limit saves. The way found for a free path and the planes
        between bodies stay as they are.

        Raises:
            ScenarioError: nothing was planned here yet, or the scene has other objects, liquids or rules.
        """
        if self._candidate is None:
            raise ScenarioError("nothing was planned before; call plan first")
        return duration_change(self._candidate, requested_scene(scene, self.constraints))
