"""A free path planned from the plan before: along its way, moved to the new ends."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from nospill import diagnosis
from nospill.errors import ModelError, NoSolutionError
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.clearance import Clearance
from nospill.laws.scene_parameters import structure_of
from nospill.path_search.candidates import has_found_path, has_free_path
from nospill.path_search.moved_way import same_surroundings, way_of
from nospill.planning.active_set import ActiveSet
from nospill.planning.candidate import Candidate, problem_about, solve_lazily
from nospill.planning.log import Log
from nospill.planning.next_set import relax_within_flow
from nospill.planning.refinement import Judged, to_fine_grid
from nospill.planning.shortening import certify_by_refinement
from nospill.planning.smoothness import Smoothness
from nospill.planning.task import Task
from nospill.planning.warm_start import NOT_CERTIFIED, NOT_CONVERGED, cautious, restart, restart_nearby
from nospill.plans.approach import starts_alike
from nospill.plans.plan import Plan
from nospill.scene.scene import Scene
from nospill.transcription.resampling import resolving_intervals
from nospill.transcription.solvers import usable
from nospill.transcription.solvers.options import BARRIERS, near_optimum
from nospill.transcription.stages import Stages, node_positions
from nospill.transcription.starting_motions import COARSE_SWING, COARSEST
from nospill.transcription.time_scaling import slow_enough
from nospill.transcription.trajectory_start import from_trajectory, on_moved_path

NO_WAY = "the way before does not lead there"
_COARSE_ITERATIONS = 150
_WORTH_A_SOLVE = 4e-3
"""Part of its duration that less back-off must save a certified motion for another solve: a loop
has little from less."""


def of_one_structure(first: Scene, second: Scene) -> bool:
    """Whether two scenes are of one structure but for limits given from Python, which add rows alone.

    Of free paths whatever way they take: the second leaves it open.
    """
    ours, theirs = (
        structure_of(scene.with_constraints(()) if scene.constraints else scene) for scene in (first, second)
    )
    if has_free_path(second) and (has_free_path(first) or has_found_path(first)):
        ours = replace(ours, spans=theirs.spans, degree=theirs.degree)
    return ours == theirs


def along_way_before(
    open_scene: Scene, earlier: Plan, last: Candidate | None, ignored: Collection[str], log: Log
) -> Judged | None:
    """A certified motion from an earlier plan along its way; None where there is none, and the log says why.

    Uncertified where the time is up.
    """
    with log.phase("way"):
        scene = way_of(earlier.scene, open_scene) if of_one_structure(earlier.scene, open_scene) else None
    if scene is None or not starts_alike(earlier.scene, scene):
        log.not_warm = NO_WAY
        return None
    diagnosis.require_bearable_lean(scene, diagnosis.MOST_LEAN)
    task = Task.of(scene, ignored)
    try:
        if same_surroundings(earlier.scene, scene):
            candidate = restart(task, earlier, last, log)
        else:
            candidate = restart_nearby(task, earlier, last, log) or _from_coarse_grid(task, earlier, log)
        judged = candidate and certify_by_refinement(candidate, log, worth=_WORTH_A_SOLVE, relaxing=relax_within_flow)
    except (ModelError, NoSolutionError, np.linalg.LinAlgError):
        judged = candidate = None
    if judged and (judged.judgement.certificate.ok or log.out_of_time):
        return judged
    log.not_warm = NOT_CONVERGED if candidate is None else NOT_CERTIFIED
    return None


def _from_coarse_grid(task: Task, earlier: Plan, log: Log) -> Candidate | None:
    """The motion of an earlier plan along its moved way, solved on the coarse grid with one mode, then on the fine one.

    None where that leads nowhere.
    """
    active = ActiveSet.of(task, earlier.trajectory.joint_position)
    start = _moved(task, active.scene, earlier)
    active = cautious(
        ActiveSet.of(task, node_positions(active.scene, start))
        .without_far(earlier.certificate.rows)
        .with_backoff({RowId.of(label): value for label, value in earlier.report.backoff.items()})
    )
    active = replace(
        active, expected=earlier.duration, smoothness=Smoothness(earlier.report.jerk_weight_factor).elsewhere
    )
    with log.phase("build", "coarse"):  # how slowly does not depend on the planes, which take as long as a solve
        alone = active.with_rows(row for row in active.rows if row.constraint != Clearance.name)
        start = slow_enough(problem_about(alone, start), start)
    coarse = solve_lazily(active, start, log, near_optimum(BARRIERS[1], _COARSE_ITERATIONS))
    succeeded = usable(coarse.solution) and coarse.keeps_branch
    log.starts.append(coarse.stages.duration if succeeded else None)
    if not succeeded:
        return None
    fine = to_fine_grid(coarse, log)
    return fine if fine.is_playable else None


def _moved(task: Task, scene: Scene, earlier: Plan) -> Stages:
    """The motion of an earlier plan on the coarse grid, along the way of a problem's scene as it was along its own."""
    trajectory, planning = earlier.trajectory, task.scene.planning
    fewest = resolving_intervals(scene, trajectory.end_time, COARSE_SWING)
    intervals = max(COARSEST, planning.intervals // 4, fewest)
    before = replace(scene, path=earlier.scene.path)
    return on_moved_path(from_trajectory(before, trajectory, intervals), before, scene)
