"""Why a search found no motion, not even with the time left open: impossible at any speed, unsolved, out of time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from nospill.certification.verdict import Row
from nospill.diagnosis.changes import advice
from nospill.diagnosis.least_relaxation import SPARE, wide_enough
from nospill.diagnosis.quasi_static import longer_time, path_place, quasi_static_motion, with_time, without_time
from nospill.diagnosis.reach import helpful_changes
from nospill.diagnosis.relaxations import relaxations_of
from nospill.diagnosis.search import SLOW, Answer, Trials, is_possible
from nospill.diagnosis.singularity import Singularity, at_singularity, nearest_singularity
from nospill.errors import MOTION, NOT_CONVERGED, ROBOT, Change, NoSolutionError, Reason
from nospill.laws.constraints.clearance import Clearance
from nospill.path_search.candidates import has_found_path
from nospill.path_search.standing import advice_on, can_be_advised, helpful_moves
from nospill.robots.joint_paths.no_joint_path import place_in_words
from nospill.robots.kinematics.redundancy import redundant_joint
from nospill.robots.kinematics.regularity import determinants, keeps_branch
from nospill.scene.scene import Scene
from nospill.transcription.solvers import Solution

_REST_FIRST = " Or let the motion before come to its end, or to one of its stops (ns.stops), and plan on from there."


def not_found(trials: Trials, last: Answer | None) -> NoSolutionError:
    """The error where not even with the time left open a motion was found."""
    scene, limit = trials.run.scene, trials.limit
    if last is not None and last.solution.solve_time_s >= 0.99 * scene.planning.max_solve_time:
        return _no_time_to_solve(trials, last.solution)
    _require_regular(trials)
    slow = max(limit, SLOW)
    judged = quasi_static_motion(with_time(scene, slow), trials.joint_path)
    if judged is not None and not judged[0].ok:
        worst = judged[0].worst
        changes = [*longer_time(trials, worst.use), *_smooth_enough(trials, worst, slow)]
        at_s = path_place(judged[1], worst.at_s)
        singular = at_singularity(scene, trials.joint_path, worst.constraint, at_s)
        if singular is not None:
            finding = f"{without_time(worst)}, even in a smooth motion of {0.95 * slow:.3g} s"
            return _singular(trials, singular, finding, worst.use - 1.0, changes)
        said = f"{without_time(worst)} at {place_in_words(scene.path, at_s)}"
        if worst.constraint == Clearance.name and has_found_path(scene):
            text = f"No way found: on the one with most slack {said}, and random searches found no clear one. "
            text += advice(changes, "Move the obstacle, the ends of the path or the arm's base.")
        elif worst.constraint == Clearance.name and can_be_advised(scene, worst.subject):
            changes = [*helpful_moves(scene)]
            text = f"No motion found: {said}, even in a smooth motion of {0.95 * slow:.3g} s; "
            text += advice_on(worst.subject, tuple(changes))
        elif scene.initial_state is not None and not scene.motion.stop:
            text = f"No motion found that goes on from this state: {said} in a smooth one. "
            text += advice(changes, "Relax that limit.") + _REST_FIRST
        else:
            text = f"No motion found: {said}, even in a smooth motion of {0.95 * slow:.3g} s. "
            text += advice(changes, "Relax that limit.")
        return NoSolutionError(
            text,
            Reason(MOTION, worst.constraint, worst.subject, at_s, worst.use - 1.0, changes=tuple(changes)),
        )
    status = "no start was solved"
    if last is not None:
        status = f"{last.solution.status} after {last.solution.iterations} iterations"
    singular = None if scene.path.joint_curve else nearest_singularity(scene.robot, trials.joint_path)
    if singular is not None:
        return _singular(trials, singular, status)
    return NoSolutionError(
        f"No motion found: {status}, although a smooth motion of {0.95 * slow:.3g} s keeps every limit on the way; "
        f'the end condition "{scene.motion.end}" may be out of reach{_nearest(last)}. '
        "Try another end condition, more starts or more intervals.",
        Reason(NOT_CONVERGED, "planning", "solver"),
    )


def ways_round(trials: Trials, at_s: float) -> tuple[Change, ...]:
    """Single changes, each tried, with which the arm keeps away from a singularity and a motion is found."""
    scene = trials.run.scene
    reason = Reason(ROBOT, "singularity", scene.robot.name, at_s)
    return helpful_changes(scene, reason, partial(is_possible, trials.run))


def _singular(
    trials: Trials, singular: Singularity, finding: str, excess: float | None = None, changes: Sequence[Change] = ()
) -> NoSolutionError:
    """The error for a singularity near the path; `finding` says what is wrong there."""
    scene, found = trials.run.scene, (*ways_round(trials, singular.s), *changes)
    return NoSolutionError(
        f"No motion found: the path passes {singular.in_words(scene.path)}; {finding}. "
        + advice(found, "Move the path or change its yaw there."),
        Reason(MOTION, "singularity", scene.robot.name, singular.s, excess, changes=found),
    )


def _require_regular(trials: Trials) -> None:
    """Raise NoSolutionError if the arm passes a singularity on its way, with what leads it past."""
    scene, joint_path = trials.run.scene, trials.joint_path
    if redundant_joint(scene.robot) is not None or scene.path.joint_curve is not None:
        return
    values = determinants(scene.robot, joint_path.q, None)
    if keeps_branch(values):
        return
    at_s = float(joint_path.s[int(np.argmin(np.abs(values)))])
    changes = ways_round(trials, at_s)
    raise NoSolutionError(
        f"No motion found: robot {scene.robot.name!r} passes a singularity near {place_in_words(scene.path, at_s)}, "
        "where it would have to stop or to turn joints in no time. "
        + advice(changes, "Move the path or change its yaw there."),
        Reason(ROBOT, "singularity", scene.robot.name, at_s, changes=changes),
    )


def _smooth_enough(trials: Trials, worst: Row, slow: float) -> list[Change]:
    """Changes with which the slowest smooth motion itself keeps every limit, else those found by solving."""
    scene, share = trials.run.scene, worst.use * SPARE - 1.0
    for relaxation in relaxations_of(scene, worst.constraint, worst.subject, {}):
        if share <= relaxation.most:
            judged = quasi_static_motion(with_time(relaxation.scene(share), slow), trials.joint_path)
            if judged is not None and judged[0].ok:
                return [relaxation.change(share)]
    return [change for _, change in wide_enough(trials, worst.constraint, worst.subject, worst.use - 1.0)]


def no_time_to_plan(scene: Scene, last: Answer | None) -> NoSolutionError:
    """The error for a search that was ended; says what its last attempt breaks most."""
    nearest = _nearest(last)
    slower = "state a longer motion.duration" if scene.motion.duration is None else "a longer motion.duration"
    further = f"{slower}, relax that limit or take another end condition" if nearest else slower
    return NoSolutionError(
        f"No motion found within planning.max_plan_time {scene.planning.max_plan_time:.3g} s{nearest}. "
        f"Give it more time, {further}.",
        Reason(NOT_CONVERGED, "planning", "max_plan_time"),
    )


def _nearest(last: Answer | None) -> str:
    """What the last attempt breaks most, as the end of a sentence; nothing where there was none."""
    if last is None or not last.solution.slack:
        return ""
    (name, subject), least = min(last.solution.slack.items(), key=lambda entry: entry[1])
    does = "breaks" if least < 0.0 else "is no motion yet and comes nearest to"
    return f"; the last one tried {does} the limit on {name} of {subject}"


def _no_time_to_solve(trials: Trials, last: Solution) -> NoSolutionError:
    scene, usual = trials.run.scene, 120.0
    now = scene.planning.max_solve_time
    patient = replace(scene, planning=replace(scene.planning, max_solve_time=usual))
    motion = trials.fastest(patient)
    text = f"max_solve_time {usual:.4g} s instead of {now:.3g} s"
    change = Change("solver", "planning.max_solve_time", usual, text)
    changes = (change,) if motion is not None and motion.duration <= trials.limit else ()
    return NoSolutionError(
        f"No motion found: {last.status} ({now:.3g} s, {last.iterations} iterations). "
        + advice(changes, "Give it more time."),
        Reason(NOT_CONVERGED, "planning", "max_solve_time", changes=changes),
    )
