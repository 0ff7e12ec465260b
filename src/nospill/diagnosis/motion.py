"""Why a search found no motion: impossible standing still, not within the time, or not found.

What is suggested was found by solving the changed task, not by extrapolation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from nospill.diagnosis.changes import advice
from nospill.diagnosis.leaning import require_bearable_lean
from nospill.diagnosis.least_relaxation import is_helped, least_share
from nospill.diagnosis.not_found import no_time_to_plan, not_found, ways_round
from nospill.diagnosis.options import Option, smaller_turn
from nospill.diagnosis.quasi_static import require_possible_at_rest
from nospill.diagnosis.relaxation import Relaxation
from nospill.diagnosis.relaxations import relaxations_of
from nospill.diagnosis.search import WITHIN, Answer, Found, Searcher, Trials, first_share
from nospill.diagnosis.singularity import at_singularity
from nospill.errors import MOTION, NOT_CONVERGED, Change, NoSolutionError, Reason
from nospill.laws.constraints.joint_jerk import JointJerk
from nospill.laws.constraints.residual_height import EndDisplacement, ResidualHeight
from nospill.robots.joint_paths.no_joint_path import place_in_words
from nospill.robots.joint_paths.search import JointPath, preferred_path, try_joint_paths
from nospill.scene.scene import EndCondition, Scene

_TIME_SPARE, _JERK_SPARE = 1.04, 1.08
"""What `SPARE` is, for the duration: the fine grid and the judge take something on top; most where joint jerks bind,
which go beyond by up to a fifth between the nodes."""
_TURN_BISECTIONS = 3
_MOST_TRIED = 4
_RESIDUAL, _STILL = ResidualHeight.name, EndDisplacement.name
_FAINT = 0.01
"""A constraint of less sensitivity than this does not hold the motion back."""
_SWITCH = 0.25
"""Another end condition counts as much as a limit that grows by this part."""
_MILDER: dict[EndCondition, tuple[EndCondition, ...]] = {
    "still": ("published", "residual"),
    "published": ("residual",),
    "residual": (),
}


def last_resort(run: Searcher, joint_path: JointPath, last: Answer | None) -> Answer:
    """The motion that a search has overlooked: it is found where the time is left open, and needs no more than allowed.

    Args:
        run: the search.
        joint_path: along which it searched.
        last: its last attempt, None before the first.

    Raises:
        NoSolutionError: there is none either; says why, and the smallest change that helps.
    """
    trials = Trials(run, joint_path)
    require_bearable_lean(run.scene)
    require_possible_at_rest(trials)
    if run.out_of_time():
        raise no_time_to_plan(run.scene, last)
    motion = trials.fastest(run.scene, enough=trials.limit)
    if motion is not None and motion.duration <= trials.limit:
        if run.scene.motion.duration is None:
            return motion.answer
        raise _faster_only(run.scene.motion.duration, motion)
    if motion is not None:
        raise _too_slow(trials, motion)
    raise not_found(trials, last)


def _faster_only(duration: float, found: Found) -> NoSolutionError:
    """The error for a duration in which no motion was found, though a shorter one was."""
    text = f"leave out duration: {found.duration:.3g} s instead of {duration:.3g} s"
    change = Change("duration", "motion.duration", found.duration, text)
    return NoSolutionError(
        f"No motion found that takes {duration:.3g} s, though one of {found.duration:.3g} s was. "
        "Leave out motion.duration, or give another.",
        Reason(NOT_CONVERGED, "duration", "motion", None, None, changes=(change,)),
    )


# --- in motion -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Culprit:
    """A constraint that holds a motion back, with the subject that does most.

    Attributes:
        constraint: its name.
        subject: the subject.
        elasticity: sum over the subjects, as in `Sensitivity`.
        at_s: where on the path that subject does most.
    """

    constraint: str
    subject: str
    elasticity: float
    at_s: float


def _too_slow(trials: Trials, motion: Found) -> NoSolutionError:
    """The error for a task whose fastest motion takes longer than it may."""
    scene, limit = trials.run.scene, trials.limit
    culprits = _with_residual(scene, _culprits(motion))
    sensitivities = {key: sensitivity.elasticity for key, sensitivity in motion.sensitivities.items()}
    options: list[tuple[float, Relaxation, float]] = []
    for culprit in culprits:
        for relaxation in relaxations_of(scene, culprit.constraint, culprit.subject, sensitivities):
            guess = first_share(motion.duration, limit, culprit.elasticity)
            options.append((min(guess, relaxation.most), relaxation, guess))
    helped: list[tuple[float, Change]] = []
    for share, relaxation, _ in sorted(options, key=lambda option: option[2])[:_MOST_TRIED]:
        if not trials.over and not is_helped(helped, relaxation):
            enough = least_share(trials, relaxation, motion, share)
            if enough is not None:
                helped.append((enough, relaxation.change(enough)))
    helped += _other_end(trials, motion)
    helped += _less_turn(trials)
    helped.sort(key=lambda entry: entry[0])
    named = _limiting_constraint(helped, culprits)
    singular = at_singularity(scene, trials.joint_path, culprits[0].constraint, culprits[0].at_s) if culprits else None
    needed = motion.duration * max(
        [_TIME_SPARE, *(_JERK_SPARE for item in culprits if item.constraint == JointJerk.name)]
    )
    key = "max_duration" if scene.motion.duration is None else "duration"
    text = f"{key} {needed:.3g} s instead of {limit:.3g} s"
    helped.append((needed / limit - 1.0, Change(key, f"motion.{key}", needed, text)))
    changes = [change for _, change in sorted(helped, key=lambda entry: entry[0])]
    held = ""
    reason = Reason(MOTION, key, "motion", None, motion.duration / limit - 1.0)
    if singular is not None:
        held = f", held back by {singular.in_words(scene.path)}"
        reason = replace(reason, constraint="singularity", subject=scene.robot.name, at_s=singular.s)
        changes = [*ways_round(trials, singular.s), *changes]
    elif named is not None:
        near = place_in_words(scene.path, named.at_s)
        held = f", held back by {named.constraint} of {named.subject}, most near {near}"
        reason = replace(reason, constraint=named.constraint, subject=named.subject, at_s=named.at_s)
    return NoSolutionError(
        f"No motion found: none within {key} {limit:.3g} s; "
        f"the fastest found takes {motion.duration:.3g} s{held}. " + advice(changes, ""),
        replace(reason, changes=tuple(changes)),
    )


def _culprits(motion: Found) -> list[_Culprit]:
    """The constraints that hold a motion back, strongest first, each with the subject that does most."""
    by_constraint: dict[str, list[tuple[float, str, float]]] = {}
    for (name, subject), sensitivity in motion.sensitivities.items():
        by_constraint.setdefault(name, []).append((sensitivity.elasticity, subject, sensitivity.at_s))
    culprits = []
    for name, members in by_constraint.items():
        total = sum(max(sensitivity, 0.0) for sensitivity, _, _ in members)
        _, subject, at_s = max(members)
        if total > _FAINT:
            culprits.append(_Culprit(name, subject, total, at_s))
    return sorted(culprits, key=lambda culprit: -culprit.elasticity)


def _with_residual(scene: Scene, culprits: list[_Culprit]) -> list[_Culprit]:
    """The residual height among the culprits where liquids have to settle.

    How long settling takes hardly depends on how far: its sensitivity is small even where nothing else
    holds the motion back.
    """
    slowest = _slowest_liquid(scene)
    if slowest is None or scene.motion.end != "residual" or any(item.constraint == _RESIDUAL for item in culprits):
        return culprits
    return [*culprits, _Culprit(_RESIDUAL, slowest, _FAINT, 1.0)]


def _slowest_liquid(scene: Scene) -> str | None:
    """The object whose liquid swings most slowly, and so takes longest to settle."""
    swings = {item.name: item.filling.modes.slowest.frequency for item in scene.cargo if item.filling is not None}
    return min(swings, key=lambda name: swings[name]) if swings else None


def _limiting_constraint(helped: list[tuple[float, Change]], culprits: list[_Culprit]) -> _Culprit | None:
    """The constraint that the message names: that of the smallest change, else that of most sensitivity."""
    change = next((change for _, change in helped if change.constraint), None)
    if change is None:
        return culprits[0] if culprits else None
    own = (item for item in culprits if (item.constraint, item.subject) == (change.constraint, change.subject))
    return next(own, _Culprit(change.constraint, change.subject, 0.0, 1.0))  # or what a milder end condition leaves out


def _other_end(trials: Trials, motion: Found) -> list[tuple[float, Change]]:
    """A milder end condition, where it makes the motion fast enough."""
    scene = trials.run.scene
    slowest = _slowest_liquid(scene)
    if slowest is None:
        return []
    for end in _MILDER[scene.motion.end]:
        if trials.over:
            break
        trial = trials.fastest(replace(scene, motion=replace(scene.motion, end=end)), near=motion.stages)
        if trial is not None and trial.duration <= WITHIN * trials.limit:
            text = f'end "{end}" instead of "{scene.motion.end}"'
            return [(_SWITCH, Change.of_limit(_STILL, slowest, "motion.end", end, text))]
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
    paths = try_joint_paths(moved.robot, moved.path, tool=moved.tool).paths
    if not paths or trials.over:
        return False
    best = preferred_path(paths, scene.robot, scene.start_near)
    found = trials.fastest(replace(scene, path=moved.path), joint_path=best)
    return found is not None and found.duration <= WITHIN * trials.limit
