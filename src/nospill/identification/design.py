"""The most informative test motion for damping, fill and lag: D-optimal over a family of trapezoids, and certified.

The information that a record has of its numbers is the inverse of their covariance, J^T J over the variance of the
noise. The motion with the largest product of determinants is looked for: of fill and damping of every liquid, clock and
gauge being unknown too, and of delay and lag of every joint. Motions are taken in the order of what they tell, and the
first that the judge certifies is the answer.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from nospill.certification.certificate import judge
from nospill.certification.tracks import with_recorded_modes
from nospill.errors import ModelError, NoSolutionError, ScenarioError
from nospill.identification.estimates import Estimate
from nospill.identification.liquid_fit import IDENTIFIABLE as LIQUIDS_TOLD
from nospill.identification.liquid_law import NUMBERS, LiquidLaw
from nospill.motion.control import followed
from nospill.motion.interpolation import JointMotion
from nospill.plans.plan import Plan, judged_plan
from nospill.plans.records import PlanningReport
from nospill.robots.joint_paths.search import JointPath, branch_in_words, joint_paths, preferred_path
from nospill.scenario import scene_from_table
from nospill.scene.controller import Controller
from nospill.scene.scene import Scene
from nospill.transcription.trapezoids import trapezoid_trajectory

RAMPS = (2, 3, 4)
"""Of the family: 27ths of the time in each third of speeding up."""
SLOWEST, _GROWTH = 2.5, 1.05
"""Of the family: durations from the shortest that the joints allow to so many times it, and from one to the next."""
_BASE = 4.0
"""s; duration at which each member is computed, to be played faster or slower."""
_JOINT_RATE, _AFTER = 500.0, 0.3
"""Hz, and s of rest after the motion: of the joints' log."""
_LAG, _LAG_STEP = 0.01, 1e-4
"""s; the lag about which the motion is judged, and the difference that gives the slope by it."""
_LEAST_TRAVEL = 0.01
"""rad; a joint that moves by less tells nothing."""
_IDENTIFIABLE = 2e-3
"""s; half width of an interval of delay or lag above which it is not identifiable."""


@dataclass(frozen=True, slots=True)
class Records:
    """What will be recorded.

    Attributes:
        rest: how long the liquids are filmed after the motion, s.
        rate: frames a second.
        height_noise: standard deviation of a height, m.
        joint_noise: of a joint's position, rad.
    """

    rest: float = 10.0
    rate: float = 60.0
    height_noise: float = 5e-4
    joint_noise: float = 1e-5


@dataclass(frozen=True, slots=True, eq=False)
class Design:
    """The most informative test motion.

    Attributes:
        plan: the motion with its certificate; its limit of the height after the end is that of the whole motion.
        expected: what is learnt from it: stated values, and the deviations that noise leaves.
        tried: how many motions of the family were looked at.
        refused: how many that tell more were not certified.
    """

    plan: Plan
    expected: tuple[Estimate, ...]
    tried: int
    refused: int


@dataclass(frozen=True, slots=True, eq=False)
class _Member:
    """One motion of the family: its duration in s, its ramp, the value of what it tells, the expected deviations."""

    duration: float
    ramp: int
    value: float
    expected: tuple[Estimate, ...]


def optimal_experiment(scene: Scene, records: Records | None = None) -> Design:
    """Find the motion.

    Args:
        scene: as of `test_scene`.
        records: what will be recorded.

    Raises:
        ScenarioError: nothing holds a liquid.
        NoSolutionError: no motion of the family is certified.
    """
    records = records or Records()
    if not any(cargo.filling for cargo in scene.cargo):
        raise ScenarioError("cargo: nothing holds a liquid; a test of damping and fill needs one")
    way = preferred_path(joint_paths(scene.robot, scene.path, tool=scene.tray.tool), scene.robot, scene.start_near)
    members = sorted(_members(scene, way, records), key=lambda member: -member.value)
    for refused, member in enumerate(members):
        plan = _certify(scene, way, member)
        if plan is not None:
            return Design(plan, member.expected, len(members), refused)
    raise NoSolutionError(
        f"none of {len(members)} motions along the path keeps every limit; give a longer path, or wider limits"
    )


def experiment_scene(scene: Scene) -> Scene:
    """A scene for the test: a level tray, and liquids that may swing on up to the limit of their height."""
    given = scene.source.get("motion")
    kept = dict(given) if isinstance(given, Mapping) else {}
    for key in ("duration", "path_jerk_weight", "tilt_jerk_weight"):
        kept.pop(key, None)
    motion = kept | {"tilt": "fixed", "end": "residual", "residual_fraction": 1.0}
    return scene_from_table({**scene.source, "motion": motion}, name=f"{scene.name}-test")


def _certify(scene: Scene, way: JointPath, member: _Member) -> Plan | None:
    """The plan of a motion; None where the judge does not certify it."""
    try:
        trajectory = trapezoid_trajectory(scene, way, member.duration, member.ramp)
        judgement = judge(trajectory, scene)
    except ModelError:
        return None  # too fast for the liquids to be integrated, or for the joints
    if not judgement.certificate.ok:
        return None
    report = PlanningReport.empty("chosen from a family of trapezoids")
    report = replace(report, branch=branch_in_words(trajectory.joint_position[0]))
    return judged_plan(scene, with_recorded_modes(trajectory, scene), judgement, report)


def _members(scene: Scene, way: JointPath, records: Records) -> Iterator[_Member]:
    for ramp in RAMPS:
        base = trapezoid_trajectory(scene, way, _BASE, ramp).motion
        duration = _shortest(scene, base)
        last = SLOWEST * duration
        while duration <= last:
            motion = _stretch(base, duration)
            expected = _expected_information(scene, motion, duration, records)
            if expected is not None:
                yield _Member(duration, ramp, *expected)
            duration *= _GROWTH


def _shortest(scene: Scene, base: JointMotion) -> float:
    """Duration at which the joints reach a limit of speed or acceleration, s."""
    t = np.linspace(0.0, _BASE, 801)
    found = _BASE * float(np.max(np.abs(base(t, 1)) / scene.robot.max_speed))
    if scene.robot.max_acceleration is not None:
        fastest = float(np.max(np.abs(base(t, 2)) / scene.robot.max_acceleration))
        found = max(found, _BASE * np.sqrt(fastest))
    return found


def _stretch(base: JointMotion, duration: float) -> JointMotion:
    """The same joint path in another time."""
    pace = _BASE / duration

    def motion(t: np.ndarray, order: int = 0, /) -> np.ndarray:
        return base(t * pace, order) * pace**order

    return motion


def _expected_information(
    scene: Scene, motion: JointMotion, duration: float, records: Records
) -> tuple[float, tuple[Estimate, ...]] | None:
    """Logarithm of the determinants, and deviations; None where a liquid rises above its limit."""
    value, estimates = 0.0, []
    for cargo in scene.cargo:
        if cargo.filling is None:
            continue
        law = LiquidLaw(motion, replace(scene, cargo=(cargo,)), 0.0, duration + records.rest)
        t = np.arange(0.0, duration + records.rest, 1.0 / records.rate)
        try:
            height, slopes = law.with_slopes(0.0, 0.0, t)
        except ModelError:
            return None
        if np.max(height) > cargo.filling.max_slosh_height:
            return None
        covariance = _inverse(slopes.T @ slopes / records.height_noise**2)
        liquid_numbers = [NUMBERS.index(name) for name in ("fill", "damping")]
        value -= float(np.linalg.slogdet(covariance[np.ix_(liquid_numbers, liquid_numbers)])[1])
        first = cargo.filling.modes.slowest
        fill, ratio = cargo.filling.liquid_height, first.damping
        deviation = np.sqrt(np.diag(covariance))[liquid_numbers]
        estimates.append(Estimate("fill", cargo.name, "m", fill, float(deviation[0]), LIQUIDS_TOLD["fill"]))
        widest_identifiable = LIQUIDS_TOLD["damping"] * ratio
        estimates.append(Estimate("damping", cargo.name, "1", ratio, ratio * float(deviation[1]), widest_identifiable))
    for joint, name in enumerate(scene.robot.joints):
        covariance = _of_joint(motion, joint, duration, records)
        if covariance is not None:
            value -= float(np.linalg.slogdet(covariance)[1])
            deviation = np.sqrt(np.diag(covariance))
            estimates += [
                Estimate(what, name, "s", 0.0, float(liquid_numbers), _IDENTIFIABLE)
                for what, liquid_numbers in zip(("delay", "lag"), deviation, strict=True)
            ]
    return value, tuple(estimates)


def _of_joint(motion: JointMotion, joint: int, duration: float, records: Records) -> np.ndarray | None:
    """Covariance of delay and lag of one joint, (2, 2) s^2; None where it hardly moves."""
    t = np.arange(0.0, duration + _AFTER, 1.0 / _JOINT_RATE)
    if np.ptp(motion(t)[:, joint]) < _LEAST_TRAVEL:
        return None

    def own(at: np.ndarray, order: int = 0, /) -> np.ndarray:
        return motion(at, order)[:, joint : joint + 1]

    here, beyond = (
        followed(own, Controller(np.zeros(1), np.array([lag])), 0.0, duration) for lag in (_LAG, _LAG + _LAG_STEP)
    )
    slopes = np.column_stack([-here(t, 1)[:, 0], (beyond(t)[:, 0] - here(t)[:, 0]) / _LAG_STEP])
    return _inverse(slopes.T @ slopes / records.joint_noise**2)


def _inverse(information: np.ndarray) -> np.ndarray:
    scale = 1.0 / np.sqrt(np.diag(information))
    return np.linalg.inv(information * np.outer(scale, scale)) * np.outer(scale, scale)
