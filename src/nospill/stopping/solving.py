"""One stop after the other: the fastest motion to rest along what is left of the path, certified.

Each is solved on a coarse grid from the one before it, 20 ms earlier; its exported samples are judged as any motion. A
row that the judge rejects gets more back-off, as much as it was over, a few times over. From afar a stop is looked for
from what is left of the plan, which keeps every limit; where that leads nowhere from smooth motions to rest of several
durations: liquids have an optimum in each of their swings.

A stop is in a hurry: weights that a scenario states for the smoothness of its motion are left out, under which stops of
`matrix-liquid` took half as long again. Its liquids need not be calm, they may swing on below `max_slosh_height`; so
what they do to their cups is judged for a while after the end too.

A stop by published equations whose objects would not stay by the whole physics is solved by that, from afar.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from nospill.certification.wording import describe
from nospill.errors import ModelError, NoSolutionError
from nospill.laws.constraints.base import RowId, liquid_names
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.path_search.free_path import paths_along
from nospill.planning.active_set import ActiveSet
from nospill.planning.candidate import problem_about
from nospill.planning.task import Task
from nospill.plans.plan import Plan
from nospill.plans.state import MotionState
from nospill.plans.stops import NO_BOUND, Stop
from nospill.robots.joint_paths.search import JointPath, path_through
from nospill.scene.scene import Fidelity, Scene
from nospill.stopping.bounds import bound_of
from nospill.stopping.splices import Splice
from nospill.stopping.tightening import broken, faded, gentler, tightened
from nospill.stopping.verdicts import Verdict, looked_at, swinging_on
from nospill.transcription.export_samples import export_samples
from nospill.transcription.margins_along import Margin
from nospill.transcription.solvers import solve
from nospill.transcription.solvers.options import SolveOptions, Tolerances
from nospill.transcription.solvers.solution import Solution
from nospill.transcription.stages import Stages
from nospill.transcription.starting_motions import motion_to_rest
from nospill.transcription.trajectory_start import from_trajectory

_PARTS = (0.5, 1.0, 0.3)
"""Of what is left of the plan: durations of the smooth motions from which a stop is looked for from afar."""
_INTERVALS = 24
"""Of the grid of a search from instant to instant, chosen by its stops: with 22 two stops of `shelf-to-table` are
missed, with 25 `matrix-liquid-tilt` stops later."""
_TIGHTENED = 16
"""How often back-off and margins are raised; what is nearly certified is solved again in a few steps."""
_PACE = 1.2
"""What back-off and margins are raised by grows with each round by this factor."""
_OF_SUM = 0.3
"""First back-off of a residual height of several modes: the judge sums them, the optimiser adds their squares."""
_MODES = 2
"""Most modes of a liquid in the problem of a stop: with three an iteration takes half as long again."""
_BACKOFF_KEPT = 0.8
"""Part of the back-off beyond the first one with which the stop from the next instant begins: all of it never fell."""
_LEAST_BARRIER = 2e-5
"""The barrier is not adapted to less: that takes a third of the steps, and answers so near their limits are further
from certified."""
_TOLERANCES = Tolerances(stationarity=1e-3, violation=1e-5, complementarity=4e-5, linear_system=1e-6, refinements=0)
"""Every answer is judged, and tightened where need be: the last iterations shorten it by parts in 10,000."""
_FIRST_TOLERANCES = replace(_TOLERANCES, stationarity=3e-3, violation=1e-4, complementarity=5e-5)
"""Of the first answer from an instant, which hardly ever is certified: what is tightened starts from it."""
_SMOOTH, _NEAR = (1e-2, 1e-3), (None, 5e-4)
"""First barrier, and how far from its bounds a motion is moved: stops and the rest of a plan keep them, or nearly, and
the barrier is adapted; smooth motions do not."""
_WARM_ITERATIONS, _COLD_ITERATIONS, _MOST_TIME = 50, 100, 30.0
_SAME = 1e-3
"""Ratio of two durations, less 1, up to which the motions count as the same."""
_LEVEL = 1e-4
"""rad; of the tray at rest, about which what swings on is bounded: no row of a certificate looks at it."""
_SOONER = 0.99
"""Of what is left of the plan; a stop that takes longer is no gain over it."""


@dataclass(frozen=True, slots=True)
class Found:
    """A certified stop with what the next one is solved from.

    Attributes:
        stop: the motion.
        solution: of its problem, with back-off and margins.
        fidelity: of that problem.
        stays: whether its objects stay by the whole physics.
    """

    stop: Stop
    solution: Solution
    backoff: dict[RowId, float] = field(repr=False)
    margins: dict[RowId, Margin] = field(repr=False)
    fidelity: Fidelity
    stays: bool


def stop_from(
    plan: Plan,
    state: MotionState,
    joint_path: JointPath,
    before: Found | None,
    *,
    residual: float = 1.0,
    afresh_above: float = math.inf,
    lead: MotionState | None = None,
) -> tuple[Stop, Found | None]:
    """The fastest certified stop that was found from a state; what is left of the plan where none is sooner.

    Args:
        plan: certified.
        state: of the plan.
        joint_path: the arm's way along the path.
        before: the stop from the instant before, from which this one is solved.
        residual: how high liquids may swing on, over max_slosh_height.
        afresh_above: s, duration of the stop found so from which one is looked for from afar too, the faster is taken;
            with 0 that comes first, and the stop before is followed only as long as that may be sooner.
        lead: the state `splices.BEFORE` samples earlier, from which on plan and stop are judged together.

    Returns:
        The stop; and what the next one is solved from, None where nothing was solved.
    """
    began, left = time.perf_counter(), plan.duration - state.t
    scene = stopping_scene(plan.scene, state, residual)
    splice = None if lead is None else splice_at(plan, state, lead, residual)
    found, sooner = None, _SOONER * left
    if before is None or afresh_above <= 0.0:
        found = _staying(found_from_afar(scene, state, joint_path, left, sooner, splice))
    if before is not None:
        most = left if found is None else found.stop.duration
        found = _following(scene, state, before, most, splice) or found
        if afresh_above > 0.0 and (found is None or found.stop.duration > afresh_above):
            most = sooner if found is None else min(found.stop.duration, sooner)
            found = _staying(found_from_afar(scene, state, joint_path, left, most, splice)) or found
    seconds = time.perf_counter() - began
    if found is None or found.stop.duration > sooner:
        return replace(rest_of_plan(plan, state, residual), seconds=seconds), found
    return replace(found.stop, seconds=seconds, bound=bound_of(scene, state)), found


def rest_of_plan(plan: Plan, state: MotionState, residual: float = 1.0) -> Stop:
    """What is left of a plan from a state as a stop, which it always is."""
    left = plan.duration - state.t
    return Stop(
        t=state.t,
        duration=left,
        left=left,
        end=float(state.rest.s[-1]),
        origin="rest of the plan",
        nearest=describe(plan.certificate.worst),
        trajectory=state.rest,
        seconds=0.0,
        bound=bound_of(stopping_scene(plan.scene, state, residual), state),
    )


def stopping_scene(scene: Scene, state: MotionState, residual: float = 1.0) -> Scene:
    """The scene of a stop from a state, after which liquids may swing on to a part of their limits: to compute with."""
    cargo = tuple(
        item
        if item.filling is None
        else replace(item, filling=replace(item.filling, initial_swing=state.swings[item.name]))
        for item in scene.cargo
    )
    return replace(
        scene,
        cargo=cargo,
        initial_state=state.arm,
        motion=replace(
            scene.motion,
            stop=True,
            duration=None,
            end="residual",
            residual_fraction=residual,
            hold_before=0.0,
            hold_after=0.0,
        ),
        planning=replace(scene.planning, path_jerk_weight=None, tilt_jerk_weight=None),
    )


def splice_at(plan: Plan, state: MotionState, lead: MotionState, residual: float = 1.0) -> Splice:
    """Where a stop takes over from a plan in a state, seen from one a little earlier."""
    return Splice(plan.trajectory, state.t, lead, swinging_on(stopping_scene(plan.scene, lead, residual)))


def found_from_afar(
    scene: Scene,
    state: MotionState,
    joint_path: JointPath,
    left: float,
    most: float | None = None,
    splice: Splice | None = None,
    *,
    of_plan: bool = False,
) -> Found | None:
    """The first certified stop that is found from smooth motions, at most as long as `left`, s; None where none is.

    Where objects stay in none of those that the equations of the scene give, it is solved by the whole physics; where
    they stay in none of these either, it is a stop that says so (`Found.stays`). What takes longer than `most`, s, is
    given up before it is certified; that is `left` by default. What is left of the plan is where it starts from, too,
    where a splice is given or `of_plan`.
    """
    most = left if most is None else most
    found = _from_smooth_motions(scene, scene.fidelity, state, joint_path, left, most, splice, of_plan)
    if found is None or found.stays:
        return found
    return _from_smooth_motions(scene, "full", state, joint_path, left, most, splice, of_plan) or found


def _staying(found: Found | None) -> Found | None:
    return found if found is not None and found.stays else None


def _from_smooth_motions(
    scene: Scene,
    fidelity: Fidelity,
    state: MotionState,
    joint_path: JointPath,
    left: float,
    most: float,
    splice: Splice | None,
    of_plan: bool,
) -> Found | None:
    """The first certified stop whose objects stay, by problems of some fidelity; where none is the last certified one.

    First from what is left of the plan: where a splice is given, that converges, and no stop follows, none is looked
    for further. Where two motions lead to the same one before anything is tightened, the second one is left out: the
    same would follow.
    """
    task, known, last = Task.of(replace(scene, fidelity=fidelity)), list[float](), None
    for start, begin in _from_afar(task, state, joint_path, left, of_plan=of_plan or splice is not None):
        active = _first(task, state)
        first = _solved(active, start, None, begin, _FIRST_TOLERANCES)
        duration = first.stages.duration
        if not first.converged or any(abs(duration / other - 1.0) < _SAME for other in known):
            continue
        known.append(duration)
        found = _certified(scene, state, active, first, most, splice)
        if found is not None and found.stays:
            return found
        if found is None and begin is _NEAR and splice is not None:
            return None
        last = found or last
    return last


def _following(scene: Scene, state: MotionState, before: Found, most: float, splice: Splice | None) -> Found | None:
    """The certified stop that is found from another one, by the same equations, and takes at most so long, s."""
    active = _first(Task.of(replace(scene, fidelity=before.fidelity)), state)
    known = {
        row: first + _BACKOFF_KEPT * (before.backoff[row] - first)
        for row, first in active.backoff.items()
        if row in before.backoff
    }
    active = replace(active.with_backoff(known), margins=faded(before.margins))
    solution = _solved(active, before.solution.stages, before.solution, tolerances=_FIRST_TOLERANCES)
    found = _certified(scene, state, active, solution, most, splice)
    return found if found is not None and found.stays else None


def joint_path_of(plan: Plan) -> JointPath:
    """The arm's way along the path of a plan.

    Raises:
        NoSolutionError: there is none.
    """
    paths = paths_along(plan.scene)
    if not paths:
        raise NoSolutionError(f"{plan.scene.name}: no joint path leads along its path")
    return path_through(paths, 0.0, plan.trajectory.joint_position[0])


def _from_afar(
    task: Task, state: MotionState, joint_path: JointPath, left: float, *, of_plan: bool
) -> Iterator[tuple[Stages, tuple[float | None, float]]]:
    """Motions from which a stop is looked for, with `_NEAR` or `_SMOOTH`; of a plan what is left of it first."""
    model = _first(task, state).scene
    if of_plan:
        yield from_trajectory(model, state.rest, _INTERVALS), _NEAR
    for part in _PARTS:
        yield motion_to_rest(model, state.arm, joint_path, _INTERVALS, part * left), _SMOOTH


def _first(task: Task, state: MotionState) -> ActiveSet:
    """What takes part, with its first back-off: every liquid with the modes that a stop's problem carries."""
    refined = frozenset(liquid_names(task.scene) if task.scene.planned_modes > 1 else ())
    modes = min(_MODES, task.scene.planned_modes)
    active = ActiveSet.of(task, state.rest.joint_position, refined=refined, modes=modes)
    sums = {row: _OF_SUM for row in active.possible if row.constraint == ResidualHeight.name and refined}
    return active.with_backoff(sums)


def _solved(
    active: ActiveSet,
    start: Stages,
    warm: Solution | None,
    begin: tuple[float | None, float] = _NEAR,
    tolerances: Tolerances = _TOLERANCES,
) -> Solution:
    """The answer from a motion, with the multipliers of another problem where there is one."""
    options = SolveOptions(
        max_iterations=_COLD_ITERATIONS if warm is None else _WARM_ITERATIONS,
        max_time=_MOST_TIME,
        tolerances=tolerances,
        kkt_error_globalization=True,
        barrier_start=begin[0],
        least_barrier=_LEAST_BARRIER,
        bound_push=begin[1],
    )
    expecting = replace(active, expected=max(start.duration, 0.1))
    return solve(problem_about(expecting, start), start, options=options, warm=warm)


def _certified(
    scene: Scene, state: MotionState, active: ActiveSet, solution: Solution, most: float, splice: Splice | None
) -> Found | None:
    """The stop that follows from an answer, its back-off raised until it is certified; None where that fails.

    Args:
        scene: of the stop.
        state: from which it begins.
        active: of the problem that is answered, by the equations of the scene or by the whole physics.
        solution: its answer.
        most: s, that it may take at most: back-off makes it longer, so that what already takes longer is given up.
        splice: where it takes over from the plan; None where no motion leads there.
    """
    for number in range(_TIGHTENED):
        if not solution.converged or solution.stages.duration > most:
            return None
        verdict = _exported(active.scene, scene, solution.stages, splice)
        if verdict is None:
            return None
        record, judgement, over = verdict.record, verdict.judgement, verdict.at_splice
        if verdict.ok and np.max(np.abs(record.tilt[-1])) <= _LEVEL:
            stop = Stop(
                t=state.t,
                duration=record.end_time,
                left=state.rest.end_time,
                end=float(record.s[-1]),
                origin="solved",
                nearest=describe(judgement.certificate.worst),
                trajectory=record,
                seconds=0.0,
                bound=NO_BOUND,
                doubted=verdict.doubted,
            )
            fidelity = active.scene.fidelity
            return Found(stop, solution, dict(active.backoff), dict(active.margins), fidelity, verdict.stays)
        tighter = gentler(active, over, judgement) if over else active
        if tighter is active:
            tighter = tightened(active, broken(active, judgement), judgement, _PACE**number)
        if tighter is active:
            return None
        active, solution = tighter, _solved(tighter, solution.stages, solution)
    return None


def _exported(model: Scene, scene: Scene, stages: Stages, splice: Splice | None) -> Verdict | None:
    """The verdict on the exported samples; None where the joints cannot follow."""
    try:
        record = export_samples(model, stages)
    except (ModelError, np.linalg.LinAlgError):
        return None
    return looked_at(record, swinging_on(scene), splice)
