"""From a plan to a file for a controller, and back: the file is judged as its receiver will play it.

What was written is read from the disk again, turned into a motion by the receiver's interpolation, and judged with the
constraints, the tolerances and the code of every other certificate. Nothing is optimised.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from nospill.certificate import Certificate, certify
from nospill.errors import NospillError, PlanFolderError, ScenarioError
from nospill.export import EXPORTERS, Exporter
from nospill.interpolation import HIGHEST_RATE, JointMotion, JointSamples, planned_motion, resampled
from nospill.plans import Plan

USUAL_RATES = (50.0, 100.0, 125.0, 200.0, 250.0, 500.0, 1000.0)
"""Hz; the rates among which one that would do is looked for."""

END_TOLERANCE = 1e-6
"""rad; a file ends where the plan ends."""

EVENNESS = 1e-4
"""Part by which the time between two samples may differ from the mean: nanoseconds are rounded."""

_FINENESS = 8
"""Instants per period at which a motion is compared with the plan."""


@dataclass(frozen=True, slots=True)
class Handover:
    """A file and what its receiver will make of it.

    Attributes:
        path: the file or folder. exporter: its format. rate: samples per second, Hz. samples: how many.
        certificate: of the motion read back.
        joint_deviation: largest difference of a joint from the plan at any time, rad; between samples too.
    """

    path: Path
    exporter: Exporter
    rate: float
    samples: int
    certificate: Certificate
    joint_deviation: float


def exporter_named(name: str) -> Exporter:
    """One exporter of the table.

    Raises:
        ScenarioError: there is none of this name.
    """
    if name not in EXPORTERS:
        raise ScenarioError(f"no format {name!r}; there are {', '.join(EXPORTERS)}")
    return EXPORTERS[name]


def hand_over(plan: Plan, exporter: Exporter, path: Path, *, rate: float | None = None) -> Handover:
    """Write a plan's file, read it back and judge what its receiver will play.

    Args:
        plan: with a scene and a trajectory.
        exporter: the format.
        path: file to write, at once or not at all.
        rate: samples per second, Hz; the plan's when left out.

    Raises:
        ScenarioError: the format does not take this scene or rate.
        PlanFolderError: the disk refuses, or the file does not hold this plan's motion when it is read.
        ModelError: the liquids cannot be integrated along what was read.
    """
    rate = plan.scene.output_rate if rate is None else rate
    _require_fit(plan, exporter, rate)
    exporter.write(resampled(plan.trajectory, rate), plan.scene, path)
    return judge_file(plan, exporter, path)


def judge_file(plan: Plan, exporter: Exporter, path: Path) -> Handover:
    """Judge a file that was written before, as its receiver will play it.

    Raises:
        PlanFolderError: it cannot be read, its samples are too dense to judge or not evenly spaced, or it ends at
            another time or place than the plan.
        ModelError: the liquids cannot be integrated along it.
    """
    samples = exporter.read(path, plan.scene)
    _require_even(samples, path)
    _require_same_end(plan, samples, path)
    motion = exporter.interpolation.motion(samples)
    return Handover(
        path=path,
        exporter=exporter,
        rate=samples.rate,
        samples=len(samples.t),
        certificate=certified(plan, motion),
        joint_deviation=_deviation(plan, samples, motion),
    )


def certified(plan: Plan, motion: JointMotion) -> Certificate:
    """The certificate of a receiver's motion: constraints along it, its tray against the plan's path and record.

    The record is compared at the plan's instants, which at a lower rate lie between the receiver's samples. Speeds and
    accelerations of the record become the receiver's own; where they exceed limits, the constraints say so.
    """
    planned, start = plan.trajectory, plan.trajectory.t[0]
    times = planned.t - start

    def played(t: np.ndarray, order: int = 0, /) -> np.ndarray:
        return motion(t - start, order)

    record = replace(
        planned, joint_position=motion(times), joint_speed=motion(times, 1), joint_acceleration=motion(times, 2)
    )
    return certify(record, plan.scene, motion=played)


def rate_that_would_do(plan: Plan, exporter: Exporter, rates: Sequence[float] = USUAL_RATES) -> float | None:
    """The lowest of some rates, Hz, at which the format's receiver keeps the certificate; None if none does."""
    for rate in rates:
        if exporter.reason_against(plan.scene, rate) is not None:
            continue
        try:
            if certified(plan, exporter.interpolation.motion(resampled(plan.trajectory, rate))).ok:
                return rate
        except NospillError:  # a liquid that leaves its cup: not at this rate
            continue
    return None


def _require_fit(plan: Plan, exporter: Exporter, rate: float) -> None:
    reason = exporter.reason_against(plan.scene, rate)
    if reason is not None:
        raise ScenarioError(f"{exporter.name}: {reason}")


def _require_even(samples: JointSamples, path: Path) -> None:
    """What lies closer together than the judge looks could hide anything."""
    if samples.rate > HIGHEST_RATE * (1.0 + EVENNESS):
        raise PlanFolderError(f"{path}: {samples.rate:g} samples per second; at most {HIGHEST_RATE:g} can be judged")
    uneven = np.abs(np.diff(samples.t) * samples.rate - 1.0)
    row = int(np.argmax(uneven))
    if uneven[row] > EVENNESS:
        raise PlanFolderError(
            f"{path}: samples {row + 1} and {row + 2} are {samples.t[row + 1] - samples.t[row]:.6g} s apart, "
            f"{1.0 / samples.rate:.6g} s in the mean; evenly spaced ones are expected"
        )


def _require_same_end(plan: Plan, samples: JointSamples, path: Path) -> None:
    planned = plan.trajectory
    length, period = float(planned.t[-1] - planned.t[0]), 1.0 / samples.rate
    if not length - END_TOLERANCE * period <= samples.t[-1] <= length + (1.0 + END_TOLERANCE) * period:
        raise PlanFolderError(f"{path}: lasts {samples.t[-1]:.6g} s; the plan lasts {length:.6g} s")
    apart = np.abs(samples.position[-1] - planned.joint_position[-1])
    joint = int(np.argmax(apart))
    if apart[joint] > END_TOLERANCE:
        raise PlanFolderError(
            f"{path}: {planned.joints[joint]} ends {apart[joint]:.4g} rad from where it ends in the plan"
        )


def _deviation(plan: Plan, samples: JointSamples, motion: JointMotion) -> float:
    start = plan.trajectory.t[0]
    t = np.linspace(0.0, samples.t[-1], _FINENESS * max(len(samples.t), len(plan.trajectory.t)))
    return float(np.max(np.abs(motion(t) - planned_motion(plan.trajectory)(start + t))))
