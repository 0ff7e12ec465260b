"""A certified motion made shorter: with less back-off, with lighter jerks, while the certificate holds."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

from nospill.certification.certificate import Judgement, judge_motion
from nospill.errors import ModelError, NoSolutionError
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.planning.active_set import ActiveSet
from nospill.planning.candidate import Candidate
from nospill.planning.log import Log
from nospill.planning.next_set import lighten, lighten_by_flow, relax
from nospill.planning.refinement import (
    Judged,
    of_other_rows,
    refine_until_certified,
    solve_from,
    start_from,
    tighten,
)
from nospill.transcription.sensitivity import saving_of
from nospill.transcription.solvers.options import NEAR_OPTIMUM

_WORTH_A_SOLVE = 1e-3
"""Part of its duration that less back-off must save a certified motion, to the first order, for another solve."""
_WORTH_OVER_BAND, _WORTH_LIGHTER = 5e-3, 0.01
"""The same over a band of arms or a range of speeds, where a row that gets some back asks for two more rounds; where a
flow judges, or jerks weigh less."""
_HEAVIER = 3.0
"""Times that jerks weigh more from which a motion relaxed, which then leaves too much by the flow, is given up."""
_LIGHTENED = 3
"""Times that a certified motion gets back what it does not need, at most."""


def certify_by_refinement(
    candidate: Candidate,
    log: Log,
    *,
    worth: float = _WORTH_A_SOLVE,
    relaxing: Callable[[ActiveSet, Judgement], ActiveSet] = relax,
) -> Judged:
    """Judge everything, solve some, add what is violated, until the certificate holds with a margin for a finer grid.

    A certified motion is solved once more with less back-off, as `relaxing` has it, where the multipliers say that it
    is worth that: so much of its duration, or more. Then with lighter jerks, while the flow leaves far less than its
    limit.

    Raises:
        NoSolutionError: the motion cannot be played, or there is none with what joined the problem.
    """
    judged = _by_smoothness(refine_until_certified(candidate, log), log)
    judged = _relaxed(_lightened(judged, log), log, worth, relaxing)
    return _with_whole_verdict(_lightened_by_flow(judged, log), log)


def _with_whole_verdict(judged: Judged, log: Log) -> Judged:
    """The same with all that a judge looks at, where rounds have ended with a row broken at a first look."""
    scene = judged.candidate.active.task.scene
    if judged.judgement.certificate.ok or (scene.tracking is None and not scene.motion.speeds):
        return judged
    with log.phase("certify"), suppress(ModelError):  # an arm whose liquids have no answer: what is broken stands
        return replace(judged, judgement=judge_motion(judged.trajectory, scene))
    return judged


def _by_smoothness(judged: Judged, log: Log) -> Judged:
    """A motion that leaves too much after the end by the nonlinear flow, smoothed instead; itself where that fails."""
    active, rows = judged.candidate.active, judged.judgement.certificate.rows
    if log.out_of_time or all(row.ok or row.constraint != ResidualHeight.name for row in rows):
        return judged
    smooth = active.without_driven(judged.judgement)
    if smooth is not active:
        with suppress(NoSolutionError):
            start = start_from(smooth, judged.trajectory, log, judged.candidate.stages)
            again = solve_from(smooth, start, log, of_other_rows(smooth, start)[:1])
            refined = again and refine_until_certified(again, log)
            if refined and refined.judgement.certificate.ok:
                return refined
    return judged


def _relaxed(judged: Judged, log: Log, least: float, relaxing: Callable[[ActiveSet, Judgement], ActiveSet]) -> Judged:
    """A certified motion solved once more with less back-off, where that is worth it; the shorter of both."""
    last, end = judged.candidate, judged.trajectory.end_time
    if not judged.judgement.certificate.ok or not last.has_converged or log.out_of_time:
        return judged
    relaxed = relaxing(last.active, judged.judgement)
    by_flow = bool(last.active.task.may_be_driven)
    over_band = bool(last.active.margins or last.active.task.scene.motion.speeds)
    worth = max(least, _WORTH_OVER_BAND if over_band else 0.0, _WORTH_LIGHTER if by_flow else 0.0)
    if saving_of(last.problem, last.solution, relaxed.backoff) > worth * end:
        with suppress(NoSolutionError):
            again = tighten(last, relaxed, log)
            heaviest = _HEAVIER * last.active.smoothness.factor if by_flow else math.inf
            refined = again and refine_until_certified(again, log, below=end, heaviest=heaviest)
            if refined and refined.judgement.certificate.ok and refined.trajectory.end_time < end:
                return refined
    return judged


def _lightened(judged: Judged, log: Log) -> Judged:
    """A certified motion whose jerks weigh more than it needs, refined again from less while that shortens it."""
    for _ in range(_LIGHTENED if judged.candidate.active.margins else 1):
        active = judged.candidate.active
        lighter = lighten(active, judged.judgement) if judged.judgement.certificate.ok else active
        shorter = None if lighter is active else _shorter(judged, lighter, log)
        if shorter is None or _is_as_long(shorter, judged):
            return shorter or judged
        judged = shorter
    return judged


def _lightened_by_flow(judged: Judged, log: Log) -> Judged:
    """The same of a motion of which the flow leaves far less than its limit."""
    for _ in range(_LIGHTENED):
        active = judged.candidate.active
        lighter = lighten_by_flow(active, judged.judgement) if judged.judgement.certificate.ok else active
        shorter = None if lighter is active else _shorter(judged, lighter, log, heaviest=active.smoothness.factor)
        if shorter is None or _is_as_long(shorter, judged):
            return shorter or judged
        judged = shorter
    return judged


def _shorter(judged: Judged, lighter: ActiveSet, log: Log, *, heaviest: float = math.inf) -> Judged | None:
    """A certified motion refined again from jerks that weigh less; None where it is no shorter then."""
    if log.out_of_time:
        return None
    active, end = judged.candidate.active, judged.trajectory.end_time
    with suppress(NoSolutionError):
        if lighter.scene is active.scene:
            again = tighten(judged.candidate, lighter, log, afresh=False)
        else:
            start = start_from(lighter, judged.trajectory, log, judged.candidate.stages)
            again = solve_from(lighter, start, log, NEAR_OPTIMUM[:1])
        refined = again and refine_until_certified(again, log, below=end, heaviest=heaviest)
        if refined and refined.judgement.certificate.ok and refined.trajectory.end_time < end:
            return refined
    return None


def _is_as_long(shorter: Judged, before: Judged) -> bool:
    """Whether a motion is shorter by too little for another solve."""
    return shorter.trajectory.end_time > (1.0 - _WORTH_LIGHTER) * before.trajectory.end_time
