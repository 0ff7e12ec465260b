"""How far a relaxation has to go: the least share of it with which a motion is found that is fast enough."""

from __future__ import annotations

import math

from nospill.diagnosis.relaxation import Relaxation
from nospill.diagnosis.relaxations import relaxations_of
from nospill.diagnosis.search import SLOW, WITHIN, Found, Trials
from nospill.errors import Change
from nospill.laws.constraints.base import RowId

SPARE = 1.015
"""Suggested values go this much beyond the least that was found enough."""
_CONFIRMATIONS = 3
_SOLVES = 5
"""Of one relaxation, at most."""
_VAIN = 2
"""So many solves without a motion, and a relaxation is given up."""
_CLOSE = 0.95
"""A relaxation is wide enough, and no wider than it has to be, where the motion takes this part of the time allowed."""


def is_helped(helped: list[tuple[float, Change]], relaxation: Relaxation) -> bool:
    """Whether the same key helps already, with another choice of whose values grow."""
    place = relaxation.change(0.0).place
    return any(change.place == place for _, change in helped)


def least_share(trials: Trials, relaxation: Relaxation, motion: Found, share: float) -> float | None:
    """Least share of a relaxation that makes the fastest motion fast enough, by secants in logarithms; else None."""
    limit, best = trials.limit, None
    points = [(0.0, motion.duration)]
    for _ in range(_SOLVES):
        trial = _with_relaxation(trials, relaxation, share, motion)
        if trial is not None:
            points.append((share, trial.duration))
            if trial.duration <= WITHIN * limit:
                best = share if best is None else min(best, share)
        fits = trial is not None and _CLOSE * limit <= trial.duration <= WITHIN * limit
        saturated = len(points) > 2 and best is None and points[-1][1] > 0.999 * points[-2][1]
        if fits or saturated or trials.over or (best is None and share >= relaxation.most):
            break
        wider = 1.5 * share + 0.05 if trial is None else _next_share(points, 0.5 * (WITHIN + _CLOSE) * limit)
        share = min(wider, relaxation.most)
    return None if best is None else _confirm(trials, relaxation, min(best * SPARE, relaxation.most))


def _confirm(trials: Trials, relaxation: Relaxation, share: float) -> float | None:
    """The share with which a motion is found from nothing too, as a user will who writes it into the file."""
    for _ in range(_CONFIRMATIONS):
        trial = trials.fastest(relaxation.scene(share))
        if trial is not None and trial.duration <= WITHIN * trials.limit:
            return share
        if trials.over or share >= relaxation.most:
            return None
        share = min(1.2 * share + 0.02, relaxation.most)
    return None


def _next_share(points: list[tuple[float, float]], wanted: float) -> float:
    """Where the line through the two points nearest to the wanted duration, in logarithms, meets it."""
    (a, first), (b, second) = sorted(points, key=lambda point: abs(math.log(point[1] / wanted)))[:2]
    low, high = sorted((math.log1p(a), math.log1p(b)))
    slope = math.log(second / first) / (math.log1p(b) - math.log1p(a)) if a != b else 0.0
    if slope > -1e-3:
        return 2.0 * max(a, b) + 0.1
    aim = math.log1p(a) + math.log(wanted / first) / slope
    return math.expm1(min(max(aim, 0.3 * low), high + 1.5))


def _with_relaxation(
    trials: Trials, relaxation: Relaxation, share: float, near: Found | None, longest: float | None = None
) -> Found | None:
    stages = None if near is None else near.stages
    return trials.fastest(relaxation.scene(share), near=stages, longest=longest)


def wide_enough(trials: Trials, constraint: str, subject: str, share: float) -> list[tuple[float, Change]]:
    """Levers of a constraint that make a motion possible where none was found at any speed, smallest first."""
    helped: list[tuple[float, Change]] = []
    for relaxation in relaxations_of(trials.run.scene, constraint, subject, {RowId(constraint, subject): 1.0}):
        if not is_helped(helped, relaxation):
            enough = _share_for_any(trials, relaxation, min(share * SPARE + 0.01, relaxation.most))
            if enough is not None:
                helped.append((enough, relaxation.change(enough)))
    return sorted(helped, key=lambda entry: entry[0])


def _share_for_any(trials: Trials, relaxation: Relaxation, share: float) -> float | None:
    """Least share of a relaxation, grown from a first one until there is a motion at all; None: there is none."""
    for _ in range(_VAIN):
        if trials.over:
            break
        trial = _with_relaxation(trials, relaxation, share, None, max(trials.limit, SLOW))
        if trial is not None and trial.duration <= WITHIN * trials.limit:
            return share
        if share >= relaxation.most:
            break
        if trial is not None:
            return least_share(trials, relaxation, trial, min(1.5 * share + 0.1, relaxation.most))
        share = min(1.3 * share + 0.02, relaxation.most)
    return None
