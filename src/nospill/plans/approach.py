"""A plan with the way to its start: found, judged with the plan, judged again, and handed over as a file of its own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from nospill.approach import find_approach, judge_segment, require_ruckig
from nospill.certification.certificate import Judgement
from nospill.certification.full_model import with_full_model
from nospill.certification.verdict import APPROACH
from nospill.certification.wording import describe
from nospill.errors import MOTION, Change, ModelError, NoSolutionError, Reason, ScenarioError
from nospill.export import Exporter
from nospill.laws.constraints.clearance import Clearance
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.motion.resampling import resampled
from nospill.plans.handover import Handover, rate_of, read_samples, require_exportable
from nospill.plans.plan import Plan
from nospill.scene.scene import Scene

_ADVICE = (
    "the tray leans as the joints turn it on a straight line in joint space: "
    'start nearer to the motion, or with tray = "empty" under [approach].'
)

_BETWEEN = (
    "the way is a straight line in joint space and is not led round obstacles: "
    "start from where nothing is between, or move the obstacle."
)


def require_ruckig_if_needed(scene: Scene) -> None:
    """Check, before any long work, that a requested approach can be planned here.

    Raises:
        MissingExtraError: the library ruckig is not installed.
    """
    if scene.approach is not None:
        require_ruckig()


def starts_alike(first: Scene, second: Scene) -> bool:
    """Whether two scenes say the same of where the arm comes from, so that they prefer the same branch."""
    ours, theirs = first.start_near, second.start_near
    return ours is theirs if ours is None or theirs is None else np.array_equal(ours, theirs)


def judged_motion(plan: Plan) -> Judgement:
    """The judgement of a plan's motion, with what the full model sees in addition to it.

    The one at hand from planning, otherwise a new one; never the certificate that a folder holds.

    Raises:
        PlanFolderError: the trajectory does not fit the scene, or is no motion.
        ModelError: the liquids cannot be integrated.
    """
    judgement = plan.evidence
    noted = with_full_model(plan.certificate if plan.judgement else judgement.certificate, plan.trajectory, plan.scene)
    return replace(judgement, certificate=replace(judgement.certificate, full_model=noted.full_model))


def judged(plan: Plan) -> Judgement:
    """The same with the rows about the approach where there is one.

    Raises:
        PlanFolderError: the trajectory does not fit the scene, or is no motion.
        ModelError: the liquids cannot be integrated.
    """
    judgement = judged_motion(plan)
    if plan.approach is None or plan.scene.approach is None:
        return judgement
    rows = judge_segment(plan.approach, plan.scene, plan.scene.approach, plan.trajectory.joint_position[0])
    return replace(judgement, certificate=judgement.certificate.joined(rows))


def with_approach(plan: Plan) -> Plan:
    """The plan with its approach and the rows about it; as it is where the scene asks for none.

    Raises:
        NoSolutionError: there is no approach that the judge certifies; names the constraint in the way.
        MissingExtraError: the library ruckig is not installed.
    """
    rules = plan.scene.approach
    if rules is None:
        return plan
    try:
        judged = find_approach(plan.scene, rules, plan.trajectory.joint_position[0])
    except ModelError as error:
        reason = Reason(MOTION, APPROACH + SloshHeight.name, "cargo", changes=_less(plan))
        raise NoSolutionError(f"No approach found: {error} {_ADVICE}", reason) from error
    worst = judged.certificate.worst
    if not judged.certificate.ok:
        slowly = "" if judged.segment.stretch == 1.0 else f", even {judged.segment.stretch:g} times as slowly"
        in_the_way = worst.constraint == APPROACH + Clearance.name
        changes = () if in_the_way else _less(plan)
        advice = _BETWEEN if in_the_way else _ADVICE
        helps = f" Smallest single change found: {changes[0].text}." if changes else ""
        reason = Reason(MOTION, worst.constraint, worst.subject, None, worst.use - 1.0, changes=changes)
        raise NoSolutionError(f"No approach found: {describe(worst)}{slowly}; {advice}{helps}", reason)
    return replace(plan, approach=judged.segment, certificate=plan.certificate.joined(judged.certificate))


def _less(plan: Plan) -> tuple[Change, ...]:
    """What helps where an approach with the cargo on the tray is not certified: to go there with the tray empty."""
    rules = plan.scene.approach
    if rules is None or not rules.loaded:
        return ()
    empty = find_approach(plan.scene, replace(rules, loaded=False), plan.trajectory.joint_position[0])
    if not empty.certificate.ok:
        return ()
    text = 'approach.tray "empty" instead of "loaded"'
    return (Change("load of the approach", "approach.tray", "empty", text),)


def judge_whole(plan: Plan) -> Judgement:
    """Judge a plan again, its motion and its approach, from the samples and the scene alone.

    Raises:
        ModelError, PlanFolderError: as for `certificate.certify`.
    """
    return judged(replace(plan, judgement=None))


def hand_over_approach(plan: Plan, exporter: Exporter, path: Path, *, rate: float | None = None) -> Handover:
    """Write a plan's approach as a file of its own, read it back and judge what its receiver will play.

    Args:
        plan: with an approach.
        exporter: the format.
        path: file to write, at once or not at all.
        rate: samples per second, Hz; the plan's when left out.

    Raises:
        ScenarioError: the plan has no approach, or the format does not take this scene or rate.
        PlanFolderError: the disk refuses, or the file cannot be read back.
        ModelError: the liquids on the tray cannot be integrated along what was read.
    """
    segment, rules = plan.approach, plan.scene.approach
    if segment is None or rules is None:
        raise ScenarioError(f"{plan.scene.name}: the plan has no approach; plan again with a table [approach]")
    rate = rate_of(plan, exporter, rate)
    require_exportable(plan, exporter, rate)
    exporter.write(resampled(segment.record(), rate), plan.scene, path)
    bare = replace(plan.scene, motion=replace(plan.scene.motion, hold_before=0.0, hold_after=0.0))
    samples = read_samples(exporter, path, bare)
    motion = exporter.interpolation.motion(samples)
    played = replace(segment, samples=samples)
    end = plan.trajectory.joint_position[0]
    return Handover(
        path=path,
        exporter=exporter,
        rate=samples.rate,
        samples=len(samples.t),
        even=True,
        certificate=judge_segment(played, plan.scene, rules, end, motion=motion),
        joint_deviation=Handover.largest_deviation(segment.record(), samples, motion),
    )
