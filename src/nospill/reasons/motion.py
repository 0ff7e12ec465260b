"""Why a search found no motion: impossible standing still, not within the time, or not found.

What is suggested was found by solving the changed task, not by extrapolation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from nospill.certificate import Certificate, Row, judge
from nospill.constraints import CONSTRAINTS
from nospill.constraints.joint_jerk import JointJerk
from nospill.constraints.residual_height import EndDisplacement, ResidualHeight
from nospill.errors import MOTION, NOT_CONVERGED, REST, ROBOT, Change, ModelError, NoSolutionError, Reason
from nospill.ocp.answer import export_samples
from nospill.ocp.guess import Start, smooth_start
from nospill.ocp.problem import build_problem
from nospill.plans import describe
from nospill.reasons.changes import advice
from nospill.reasons.levers import Lever, levers_of
from nospill.reasons.reach import Option, helpful_changes, smaller_turn
from nospill.reasons.search import WITHIN, Found, Searcher, Trials, first_share
from nospill.robots.inverse import JointPath, preferred_path, try_joint_paths
from nospill.robots.redundancy import redundant_joint
from nospill.robots.regularity import determinants, keeps_branch
from nospill.scene import EndCondition, Scene
from nospill.solvers import Solution, row_slack
from nospill.trajectory import Trajectory

_SLOW = 20.0
"""s; a motion of this length is slow enough to tell what is impossible at any speed."""
_STANDING = 1e5
"""s; in a motion of this length nothing moves to speak of."""
_SPARE = 1.015
"""Suggested values go this much beyond the least that was found enough."""
_TIME_SPARE, _JERK_SPARE = 1.04, 1.08
"""The same for the duration: the fine grid and the judge take something on top; most where joint jerks bind, which go
beyond by up to a fifth between the nodes."""
_TURN_BISECTIONS = 3
_CONFIRMATIONS = 3
_SOLVES = 5
"""Of one lever, at most."""
_VAIN = 2
"""So many solves without a motion, and a lever is given up."""
_CLOSE = 0.95
"""A lever is wide enough, and no wider than it has to be, where the motion takes this part of the time allowed."""
_LEVERS = 4
_RESIDUAL, _STILL = ResidualHeight.name, EndDisplacement.name
_FAINT = 0.01
"""What pulls less than this does not hold the motion back."""
_SWITCH = 0.25
"""Another end condition counts as much as a limit that grows by this part."""
_MILDER: dict[EndCondition, tuple[EndCondition, ...]] = {
    "still": ("published", "residual"),
    "published": ("residual",),
    "residual": (),
}


def is_hopeless(scene: Scene, joint_path: JointPath) -> bool:
    """Whether even the slowest smooth motion breaks a limit several times over."""
    judged = _slow_motion(scene, joint_path)
    return judged is not None and judged[0].worst.worst_margin < -abs(judged[0].worst.limit)


def last_resort(run: Searcher, joint_path: JointPath, last: Solution | None) -> Solution:
    """The motion that a search has overlooked: it is found where the time is left open, and needs no more than allowed.

    Args:
        run: the search.
        joint_path: along which it searched.
        last: its last attempt, None before the first.

    Raises:
        NoSolutionError: there is none either; says why, and the smallest change that helps.
    """
    trials = Trials(run, joint_path)
    _require_possible_at_rest(trials)
    found = trials.fastest(run.scene, enough=trials.limit)
    if found is not None and found.duration <= trials.limit:
        return found.solution
    if found is not None:
        raise _too_slow(trials, found)
    raise _never(trials, last)


# --- standing still ------------------------------------------------------------------------------------------------


def _require_possible_at_rest(trials: Trials) -> None:
    """Raise NoSolutionError if a limit is broken somewhere on the path even by standing there with a level tray."""
    scene, joint_path = trials.run.scene, trials.joint_path
    key = _broken_at_rest(scene, joint_path)
    if key is None:
        return
    judged = _slow_motion(_with_time(scene, max(trials.limit, _SLOW)), joint_path)
    subject = next(item.subjects(scene) for item in CONSTRAINTS if item.name == key[0])[key[1]]
    rows = () if judged is None else judged[0].rows
    row = next((row for row in rows if (row.constraint, row.subject) == (key[0], subject)), None)
    use = 1.1 if row is None else max(row.use, 1.0)
    changes = [change for _, change in _wide_enough(trials, key[0], subject, use - 1.0)]
    at_s = None if row is None or judged is None else _path_place(judged[1], row.at_s)
    told = f"{key[0]} of {subject} is over its limit" if row is None else _timeless(row)
    where = "" if at_s is None else f" at s = {at_s:.2f} of the path"
    raise NoSolutionError(
        f"No motion found: {told} even standing still{where}. "
        + advice(changes, "Relax that limit or lighten the load."),
        Reason(REST, key[0], subject, at_s, use - 1.0, changes=tuple(changes)),
    )


def _broken_at_rest(scene: Scene, joint_path: JointPath) -> tuple[str, int] | None:
    """The row that standing along the path with a level tray breaks most; None where it keeps all."""
    still = smooth_start(_with_time(scene, _STANDING), joint_path, 50, Start(stretch=1e9))
    problem = build_problem(
        replace(scene, motion=replace(scene.motion, end="residual")),
        still.intervals,
        nominal_duration=still.duration,
        reserves={},
        self_motion=still.self_motion,
    )
    slack = {key: value for key, value in row_slack(problem, still).items() if value < 0.0 and key[0] != "tilt"}
    return min(slack, key=lambda key: slack[key]) if slack else None


# --- in motion -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Culprit:
    """What holds a motion back."""

    constraint: str
    subject: str
    elasticity: float
    at_s: float


def _too_slow(trials: Trials, found: Found) -> NoSolutionError:
    """The error for a task whose fastest motion takes longer than it may."""
    scene, limit = trials.run.scene, trials.limit
    culprits = _with_residual(scene, _culprits(scene, found))
    pulls = {key: pull.elasticity for key, pull in found.pulls.items()}
    options: list[tuple[float, Lever, float]] = []
    for culprit in culprits:
        for lever in levers_of(scene, culprit.constraint, culprit.subject, pulls):
            guess = first_share(found.duration, limit, culprit.elasticity)
            options.append((min(guess, lever.most), lever, guess))
    helped: list[tuple[float, Change]] = []
    for share, lever, _ in sorted(options, key=lambda option: option[2])[:_LEVERS]:
        if not trials.over and not _is_helped(helped, lever):
            enough = _least_share(trials, lever, found, share)
            if enough is not None:
                helped.append((enough, lever.change(enough)))
    helped += _other_end(trials, found)
    helped += _less_turn(trials)
    helped.sort(key=lambda entry: entry[0])
    named = _named(helped, culprits)
    needed = found.duration * max(
        [_TIME_SPARE, *(_JERK_SPARE for item in culprits if item.constraint == JointJerk.name)]
    )
    text = f"max_duration {needed:.3g} s instead of {limit:.3g} s"
    helped.append((needed / limit - 1.0, Change("max_duration", "motion.max_duration", needed, text)))
    changes = [change for _, change in sorted(helped, key=lambda entry: entry[0])]
    held = f", held back by {named.constraint} of {named.subject} (most near s = {named.at_s:.2f})" if named else ""
    return NoSolutionError(
        f"No motion found: none within max_duration {limit:.3g} s; "
        f"the fastest found takes {found.duration:.3g} s{held}. " + advice(changes, ""),
        Reason(
            MOTION,
            named.constraint if named else "max_duration",
            named.subject if named else "motion",
            named.at_s if named else None,
            found.duration / limit - 1.0,
            changes=tuple(changes),
        ),
    )


def _culprits(scene: Scene, found: Found) -> list[_Culprit]:
    """The constraints that hold a motion back, strongest first, each with the subject that does most."""
    families: dict[str, list[tuple[float, int, float]]] = {}
    for (name, index), pull in found.pulls.items():
        families.setdefault(name, []).append((pull.elasticity, index, pull.at_s))
    subjects = {constraint.name: constraint.subjects(scene) for constraint in CONSTRAINTS}
    culprits = []
    for name, members in families.items():
        total = sum(max(pull, 0.0) for pull, _, _ in members)
        _, index, at_s = max(members)
        if total > _FAINT:
            culprits.append(_Culprit(name, subjects[name][index], total, at_s))
    return sorted(culprits, key=lambda culprit: -culprit.elasticity)


def _with_residual(scene: Scene, culprits: list[_Culprit]) -> list[_Culprit]:
    """The residual height among the culprits where liquids have to settle.

    How long settling takes hardly depends on how far: its pull is faint even where nothing else holds the motion back.
    """
    slowest = _slowest_liquid(scene)
    if slowest is None or scene.motion.end != "residual" or any(item.constraint == _RESIDUAL for item in culprits):
        return culprits
    return [*culprits, _Culprit(_RESIDUAL, slowest, _FAINT, 1.0)]


def _slowest_liquid(scene: Scene) -> str | None:
    """The object whose liquid swings most slowly, and so takes longest to settle."""
    swings = {
        item.name: min(mode.frequency for mode in item.filling.modes.oscillators)
        for item in scene.cargo
        if item.filling is not None
    }
    return min(swings, key=lambda name: swings[name]) if swings else None


def _is_helped(helped: list[tuple[float, Change]], lever: Lever) -> bool:
    """Whether the same key helps already, with another choice of whose values grow."""
    place = lever.change(0.0).place
    return any(change.place == place for _, change in helped)


def _named(helped: list[tuple[float, Change]], culprits: list[_Culprit]) -> _Culprit | None:
    """What the message names: what the smallest change speaks of, else what pulls most."""
    for _, change in helped:
        for culprit in culprits:
            if change.what == f"{culprit.constraint} of {culprit.subject}":
                return culprit
        if change.place == "motion.end":
            return _Culprit(_STILL, change.what.removeprefix(f"{_STILL} of "), 0.0, 1.0)
    return culprits[0] if culprits else None


def _least_share(trials: Trials, lever: Lever, found: Found, share: float) -> float | None:
    """Least share of a lever that makes the fastest motion fast enough, by secants in logarithms; None: none does."""
    limit, best = trials.limit, None
    points = [(0.0, found.duration)]
    for _ in range(_SOLVES):
        trial = _with_lever(trials, lever, share, found)
        if trial is not None:
            points.append((share, trial.duration))
            if trial.duration <= WITHIN * limit:
                best = share if best is None else min(best, share)
        fits = trial is not None and _CLOSE * limit <= trial.duration <= WITHIN * limit
        saturated = len(points) > 2 and best is None and points[-1][1] > 0.999 * points[-2][1]
        if fits or saturated or trials.over or (best is None and share >= lever.most):
            break
        wider = 1.5 * share + 0.05 if trial is None else _next_share(points, 0.5 * (WITHIN + _CLOSE) * limit)
        share = min(wider, lever.most)
    return None if best is None else _confirmed(trials, lever, min(best * _SPARE, lever.most))


def _confirmed(trials: Trials, lever: Lever, share: float) -> float | None:
    """The share with which a motion is found from nothing too, as a user will who writes it into the file."""
    for _ in range(_CONFIRMATIONS):
        trial = trials.fastest(lever.scene(share))
        if trial is not None and trial.duration <= WITHIN * trials.limit:
            return share
        if trials.over or share >= lever.most:
            return None
        share = min(1.2 * share + 0.02, lever.most)
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


def _with_lever(
    trials: Trials, lever: Lever, share: float, near: Found | None, longest: float | None = None
) -> Found | None:
    stages = None if near is None else near.solution.stages
    return trials.fastest(lever.scene(share), near=stages, longest=longest)


def _other_end(trials: Trials, found: Found) -> list[tuple[float, Change]]:
    """A milder end condition, where it makes the motion fast enough."""
    scene = trials.run.scene
    slowest = _slowest_liquid(scene)
    for end in _MILDER[scene.motion.end] if slowest is not None else ():
        if trials.over:
            break
        trial = trials.fastest(replace(scene, motion=replace(scene.motion, end=end)), near=found.solution.stages)
        if trial is not None and trial.duration <= WITHIN * trials.limit:
            text = f'end "{end}" instead of "{scene.motion.end}"'
            return [(_SWITCH, Change(f"{_STILL} of {slowest}", "motion.end", end, text))]
    return []


def _less_turn(trials: Trials) -> list[tuple[float, Change]]:
    """A smaller turn of the tray along the path, where that makes the motion fast enough."""
    scene = trials.run.scene
    for option in smaller_turn(scene):
        low, high = 0.0, option.amounts[-1]
        if not _is_fast_enough(trials, option, high):
            return []
        for _ in range(_TURN_BISECTIONS):
            middle = 0.5 * (low + high)
            if _is_fast_enough(trials, option, middle):
                high = middle
            else:
                low = middle
        return [(high * option.size, option.change(high))]
    return []


def _is_fast_enough(trials: Trials, option: Option, amount: float) -> bool:
    scene, moved = trials.run.scene, option.moved(amount)
    paths = try_joint_paths(moved.robot, moved.path, tool_position=moved.tool_position, tool_yaw=moved.tool_yaw).paths
    if not paths or trials.over:
        return False
    best = preferred_path(paths, scene.robot, scene.start_near)
    found = trials.fastest(replace(scene, path=moved.path), joint_path=best)
    return found is not None and found.duration <= WITHIN * trials.limit


def _wide_enough(trials: Trials, constraint: str, subject: str, share: float) -> list[tuple[float, Change]]:
    """Levers of a constraint that make a motion possible where none was found at any speed, smallest first."""
    index = next(item.subjects(trials.run.scene) for item in CONSTRAINTS if item.name == constraint).index(subject)
    helped: list[tuple[float, Change]] = []
    for lever in levers_of(trials.run.scene, constraint, subject, {(constraint, index): 1.0}):
        if _is_helped(helped, lever):
            continue
        high = min(share * _SPARE + 0.01, lever.most)
        trial, vain = None, 0
        for _ in range(_SOLVES):
            if trials.over or vain == _VAIN:
                break
            trial = _with_lever(trials, lever, high, None, max(trials.limit, _SLOW))
            if trial is not None and trial.duration <= WITHIN * trials.limit:
                break
            if high >= lever.most:
                trial = None
                break
            if trial is None:
                vain += 1
                high = min(1.3 * high + 0.02, lever.most)
            else:
                enough = _least_share(trials, lever, trial, min(1.5 * high + 0.1, lever.most))
                if enough is not None:
                    helped.append((enough, lever.change(enough)))
                trial = None
                break
        if trial is not None:
            helped.append((high, lever.change(high)))
    return sorted(helped, key=lambda entry: entry[0])


# --- at no speed, or not found -------------------------------------------------------------------------------------


def _never(trials: Trials, last: Solution | None) -> NoSolutionError:
    """The error where not even with the time left open a motion was found."""
    scene, limit = trials.run.scene, trials.limit
    if last is not None and last.solve_time_s >= 0.99 * scene.planning.max_solve_time:
        return _no_time_to_solve(trials, last)
    _require_regular(trials)
    slow = max(limit, _SLOW)
    judged = _slow_motion(_with_time(scene, slow), trials.joint_path)
    if judged is not None and not judged[0].ok:
        worst = judged[0].worst
        changes = _smooth_enough(trials, worst, slow)
        at_s = _path_place(judged[1], worst.at_s)
        return NoSolutionError(
            f"No motion found: {_timeless(worst)} at s = {at_s:.2f} of the path, "
            f"even in a smooth motion of {0.95 * slow:.3g} s. " + advice(changes, "Relax that limit."),
            Reason(MOTION, worst.constraint, worst.subject, at_s, worst.use - 1.0, changes=tuple(changes)),
        )
    status = "no start was solved" if last is None else f"{last.status} after {last.iterations} iterations"
    return NoSolutionError(
        f"No motion found: {status}, although a smooth motion of {0.95 * slow:.3g} s keeps every limit on the way; "
        f'the end condition "{scene.motion.end}" may be out of reach. '
        "Try another end condition, more starts or more intervals.",
        Reason(NOT_CONVERGED, "planning", "solver"),
    )


def _require_regular(trials: Trials) -> None:
    """Raise NoSolutionError if the arm passes a singularity on its way, with what leads it past."""
    scene, joint_path = trials.run.scene, trials.joint_path
    if redundant_joint(scene.robot) is not None:
        return
    values = determinants(scene.robot, joint_path.q, None)
    if keeps_branch(values):
        return
    at_s = float(joint_path.s[int(np.argmin(np.abs(values)))])
    reason = Reason(ROBOT, "singularity", scene.robot.name, at_s)
    changes = helpful_changes(scene, reason, trials.run.is_possible)
    raise NoSolutionError(
        f"No motion found: robot {scene.robot.name!r} passes a singularity near s = {at_s:.2f} of the path, where it "
        "would have to stop or to turn joints in no time. " + advice(changes, "Move the path or change its yaw there."),
        replace(reason, changes=changes),
    )


def _smooth_enough(trials: Trials, worst: Row, slow: float) -> list[Change]:
    """Changes with which the slowest smooth motion itself keeps every limit, else those found by solving."""
    scene, share = trials.run.scene, worst.use * _SPARE - 1.0
    for lever in levers_of(scene, worst.constraint, worst.subject, {}):
        if share <= lever.most:
            judged = _slow_motion(_with_time(lever.scene(share), slow), trials.joint_path)
            if judged is not None and judged[0].ok:
                return [lever.change(share)]
    return [change for _, change in _wide_enough(trials, worst.constraint, worst.subject, worst.use - 1.0)]


def _no_time_to_solve(trials: Trials, last: Solution) -> NoSolutionError:
    scene, usual = trials.run.scene, 120.0
    now = scene.planning.max_solve_time
    patient = replace(scene, planning=replace(scene.planning, max_solve_time=usual))
    found = trials.fastest(patient)
    text = f"max_solve_time {usual:.4g} s instead of {now:.3g} s"
    change = Change("solver", "planning.max_solve_time", usual, text)
    changes = (change,) if found is not None and found.duration <= trials.limit else ()
    return NoSolutionError(
        f"No motion found: {last.status} ({now:.3g} s, {last.iterations} iterations). "
        + advice(changes, "Give it more time."),
        Reason(NOT_CONVERGED, "planning", "max_solve_time", changes=changes),
    )


def _with_time(scene: Scene, max_duration: float) -> Scene:
    return replace(scene, motion=replace(scene.motion, max_duration=max_duration))


def _slow_motion(scene: Scene, joint_path: JointPath) -> tuple[Certificate, Trajectory] | None:
    """What the judge says of the slowest smooth motion, and that motion; None if its liquids cannot be integrated."""
    trajectory = export_samples(scene, smooth_start(scene, joint_path, 100, Start(stretch=1e6)))
    try:
        verdict = judge(trajectory, scene).certificate
    except ModelError:
        return None
    names = {constraint.name for constraint in CONSTRAINTS}
    rows: tuple[Row, ...] = tuple(row for row in verdict.rows if row.constraint in names)
    return Certificate(all(row.ok for row in rows), verdict.grid_hz, rows), trajectory


def _timeless(row: Row) -> str:
    """What is wrong, without the time at which the slow motion was there."""
    return describe(row).removesuffix(f" at t = {row.at_s:.3f} s")


def _path_place(trajectory: Trajectory, t: float) -> float:
    """Path parameter of a motion at a time, s."""
    return float(np.interp(t, trajectory.t, trajectory.s))
