"""Why there is no motion, and the smallest single change that would give one.

The slowest smooth motion tells what is impossible even nearly at rest. Otherwise a limit is in the way of the motion
itself: each suspect, the longest duration first, is given way alone, as little as lets the optimiser find a motion.
What is suggested was found by solving the changed problem, not by extrapolation.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

from nospill.certificate import Certificate, judge
from nospill.constraints import CONSTRAINTS
from nospill.errors import MOTION, Change, ModelError, NoSolutionError, Reason
from nospill.ocp.answer import export_samples
from nospill.ocp.guess import Start, smooth_start
from nospill.ocp.problem import Reserves
from nospill.ocp.stages import Stages
from nospill.plans import describe, shown_unit
from nospill.robots.inverse import JointPath
from nospill.scene import Scene
from nospill.solvers import Solution, usable

_SLOW = 20.0
"""s; a motion of this length is slow enough to tell what is impossible at any speed."""
_SUSPECTS = 2
_TIGHT = 1e-3
_LARGEST = 8.0
"""Budgets are widened up to this many times their size."""
_BISECTIONS = 3
_PATIENCE = 60
_SPARE = 1.02
"""Suggested values go this much beyond the least that was found enough."""


class Searcher(Protocol):
    """What trying a changed task takes; a `planning_run.PlanningRun` is one.

    Attributes:
        scene: the task. reserves: fraction of each budget kept back; a negative one widens it.
    """

    scene: Scene
    reserves: Reserves

    def trial(self, scene: Scene) -> Searcher:
        """A searcher of its own for a scene."""
        ...

    def start(self, joint_path: JointPath) -> Stages:
        """A smooth starting motion."""
        ...

    def solve_near(self, start: Stages, *, iterations: int) -> Solution:
        """Solve from a start."""
        ...


def is_hopeless(scene: Scene, joint_path: JointPath) -> bool:
    """Whether even the slowest smooth motion breaks a limit several times over."""
    verdict = slow_verdict(scene, joint_path)
    return verdict is not None and verdict.worst.worst_margin < -abs(verdict.worst.limit)


def slow_verdict(scene: Scene, joint_path: JointPath) -> Certificate | None:
    """What the judge says of the slowest smooth motion; None if the liquids cannot even be integrated."""
    slow = smooth_start(scene, joint_path, 100, Start(stretch=1e6))
    try:
        verdict = judge(export_samples(scene, slow), scene).certificate
    except ModelError:
        return None
    names = {constraint.name for constraint in CONSTRAINTS}
    rows = tuple(row for row in verdict.rows if row.constraint in names)
    return Certificate(all(row.ok for row in rows), verdict.grid_hz, rows)


def explained(run: Searcher, joint_path: JointPath, last: Solution | None) -> NoSolutionError:
    """The error that says why a search found nothing; `last` is its last attempt, None before the first."""
    scene, limit = run.scene, run.scene.motion.max_duration
    slow = max(limit, _SLOW)
    verdict = slow_verdict(replace(scene, motion=replace(scene.motion, max_duration=slow)), joint_path)
    if verdict is not None and not verdict.ok:
        worst = verdict.worst
        change = _change(scene, worst.constraint, worst.subject, worst.use * _SPARE)
        text = f"No motion found: {describe(worst)} even in a smooth motion of {0.95 * slow:.3g} s. "
        reason = Reason(MOTION, worst.constraint, worst.subject, changes=(change,) if change else ())
        return NoSolutionError(text + _advice([change] if change else []), reason)
    hasty = slow_verdict(scene, joint_path) if limit < _SLOW else verdict
    changes = _found_changes(run, joint_path, last, hasty)
    if changes:
        broken = "" if hasty is None or hasty.ok else f"; in a smooth motion of that length {describe(hasty.worst)}"
        text = f"No motion found: none within max_duration {limit:.3g} s{broken}. "
        return NoSolutionError(text + _advice(changes), Reason(MOTION, "", "", changes=tuple(changes)))
    status = "nothing was tried" if last is None else f"{last.status} after {last.iterations} iterations"
    text = (
        f"No motion found: {status}, although a smooth motion of {0.95 * limit:.3g} s keeps every limit on the way; "
        f'the end condition "{scene.motion.end}" may be out of reach. '
        "Try another end condition, more starts or more intervals."
    )
    return NoSolutionError(text)


def _advice(changes: list[Change]) -> str:
    if not changes:
        return "Relax that limit."
    return "Smallest single change found: " + "; or ".join(change.text for change in changes[:3]) + "."


def _found_changes(
    run: Searcher, joint_path: JointPath, last: Solution | None, hasty: Certificate | None
) -> list[Change]:
    """Single changes with which a motion was found, smallest first."""
    found: list[tuple[float, Change]] = []
    longest = _longer(run, joint_path)
    if longest is not None:
        found.append(longest)
    for name, subject in _suspects(run.scene, last, hasty).items():
        widened = _least_widening(run, joint_path, name)
        if widened is not None:
            change = _change(run.scene, name, subject, (1.0 + widened) * _SPARE)
            if change is not None:
                found.append((widened, change))
    return [change for _, change in sorted(found, key=lambda entry: entry[0])]


def _longer(run: Searcher, joint_path: JointPath) -> tuple[float, Change] | None:
    """How much longer the motion would have to be allowed to be."""
    limit = run.scene.motion.max_duration
    roomy = replace(run.scene, motion=replace(run.scene.motion, max_duration=min(_LARGEST * limit, 600.0)))
    trial = run.trial(roomy)
    solution = trial.solve_near(trial.start(joint_path), iterations=_PATIENCE)
    if not usable(solution) or solution.stages.duration <= limit:
        return None
    needed = solution.stages.duration * _SPARE
    text = f"max_duration {needed:.3g} s instead of {limit:.3g} s"
    return needed / limit - 1.0, Change("max_duration", "motion.max_duration", needed, text)


def _suspects(scene: Scene, last: Solution | None, hasty: Certificate | None) -> dict[str, str]:
    """Constraints that may be in the way, worst first, each with the subject that is worst off.

    Those the last attempt breaks or uses up, and those that a smooth motion of the longest duration breaks.
    """
    found: dict[str, tuple[float, str]] = {}
    for row in () if hasty is None else hasty.rows:
        if not row.ok and row.use > found.get(row.constraint, (0.0, ""))[0]:
            found[row.constraint] = row.use, row.subject
    subjects = {constraint.name: constraint.subjects(scene) for constraint in CONSTRAINTS}
    for (name, index), slack in sorted([] if last is None else last.slack.items(), key=lambda item: item[1]):
        if slack < _TIGHT and name not in found:
            found[name] = 1.0 - slack, subjects[name][index]
    worst_first = sorted(found.items(), key=lambda item: -item[1][0])
    named = [(name, subject) for name, (_, subject) in worst_first if name in _KEYS]
    return dict(named[:_SUSPECTS])


def _least_widening(run: Searcher, joint_path: JointPath, name: str) -> float | None:
    """Least share by which a constraint's budgets have to grow for a motion to be found; None: no growth helps."""

    def works(share: float) -> bool:
        trial = run.trial(run.scene)
        for key in trial.reserves:
            if key[0] == name:
                trial.reserves[key] = -share
        return usable(trial.solve_near(trial.start(joint_path), iterations=_PATIENCE))

    low, high = 0.0, 0.25
    while not works(high):
        low, high = high, 2.0 * high
        if high > _LARGEST:
            return None
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if works(middle) else (middle, high)
    return high


@dataclass(frozen=True, slots=True)
class _Key:
    """Which key of the scenario widens a constraint: its name for people, its place, its value now, the unit."""

    what: str
    place: str
    now: Callable[[Scene, int], float]
    unit: str


def _per_joint(limit: str) -> Callable[[Scene, int], float]:
    def now(scene: Scene, joint: int) -> float:
        values = getattr(scene.robot, limit)
        return float(values[joint])

    return now


def _fill_limit(scene: Scene, index: int) -> float:
    filling = [cargo.filling for cargo in scene.cargo if cargo.filling][index]
    return filling.max_slosh_height


_KEYS: dict[str, _Key] = {
    "slosh height": _Key("max_slosh_height", "cargo.max_slosh_height", _fill_limit, "m"),
    "residual height": _Key(
        "residual_fraction", "motion.residual_fraction", lambda scene, _: scene.motion.residual_fraction, "of the limit"
    ),
    "slip": _Key("friction", "tray.friction", lambda scene, index: scene.cargo[index].friction, ""),
    "twist": _Key("friction", "tray.friction", lambda scene, index: scene.cargo[index].friction, ""),
    "joint speed": _Key("limits.speed", "robot.limits.speed", _per_joint("max_speed"), "rad/s"),
    "joint acceleration": _Key(
        "limits.acceleration", "robot.limits.acceleration", _per_joint("max_acceleration"), "rad/s^2"
    ),
    "joint jerk": _Key("limits.jerk", "robot.limits.jerk", _per_joint("max_jerk"), "rad/s^3"),
    "joint torque": _Key("limits.torque", "robot.limits.torque", _per_joint("max_torque"), "N m"),
    "tilt": _Key("max_tilt", "motion.max_tilt", lambda scene, _: scene.motion.max_tilt, "rad"),
    "path jerk": _Key(
        "path_jerk_limit", "motion.path_jerk_limit", lambda scene, _: scene.motion.path_jerk_limit, "1/s^3"
    ),
    "tilt jerk": _Key(
        "tilt_jerk_limit", "motion.tilt_jerk_limit", lambda scene, _: scene.motion.tilt_jerk_limit, "rad/s^3"
    ),
}
"""Constraint -> the key whose value its budget is proportional to. Tip and lift are shapes and weights: no key."""


def _change(scene: Scene, constraint: str, subject: str, factor: float) -> Change | None:
    """The change of a scenario that makes a constraint's budget `factor` times as large."""
    key = _KEYS.get(constraint)
    if key is None:
        return None
    index = next(item.subjects(scene) for item in CONSTRAINTS if item.name == constraint).index(subject)
    now = key.now(scene, index)
    scale, unit = shown_unit(key.unit) if key.unit in ("m", "rad", "rad/s") else (1.0, key.unit)
    values = " instead of ".join(f"{scale * value:.3g} {unit}".rstrip() for value in (now * factor, now))
    return Change(f"{constraint} of {subject}", key.place, now * factor, f"{key.what} {values} ({subject})")
