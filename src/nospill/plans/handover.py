"""From a plan to a file for a controller, and back: the file is judged as its receiver will play it.

What was written is read from the disk again, turned into a motion by the receiver's interpolation, and judged with the
constraints, the tolerances and the code of every other certificate. Nothing is optimised.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from nospill.errors import NospillError, PlanFolderError, ScenarioError
from nospill.export import EXPORTERS, Exporter
from nospill.judge.certificate import certify
from nospill.judge.verdict import Certificate
from nospill.motion.control import commanded_at, followed
from nospill.motion.holds import held_samples, hold_periods
from nospill.motion.interpolation import JointMotion, JointSamples
from nospill.motion.resampling import HIGHEST_RATE, interpolated
from nospill.motion.trajectory import Trajectory
from nospill.plans.plan import Plan
from nospill.scene.scene import Scene

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
        path: the file or folder.
        exporter: its format.
        rate: samples per second, Hz.
        samples: how many.
        certificate: of the motion read back.
        joint_deviation: largest difference of a joint from the plan at any time, rad; between samples too.
    """

    path: Path
    exporter: Exporter
    rate: float
    samples: int
    certificate: Certificate
    joint_deviation: float

    @staticmethod
    def largest_deviation(planned: Trajectory, samples: JointSamples, motion: JointMotion, lead: float = 0.0) -> float:
        """How far the joints of a file are from a record's at any time, rad; between samples too.

        Args:
            planned: the record.
            samples: of the file, times from 0.
            motion: what its receiver makes of them.
            lead: the file's time at which the record begins, s.
        """
        start = planned.t[0]
        t = np.linspace(0.0, samples.t[-1], _FINENESS * max(len(samples.t), len(planned.t)))
        return float(np.max(np.abs(motion(t) - planned.motion(start + t - lead))))


def exporter_named(name: str) -> Exporter:
    """One exporter of the table.

    Raises:
        ScenarioError: there is none of this name.
    """
    if name not in EXPORTERS:
        raise ScenarioError(f"no format {name!r}; there are {', '.join(EXPORTERS)}")
    return EXPORTERS[name]


def in_frame(exporter: Exporter, frame: str | None) -> Exporter:
    """The exporter of poses in a frame; as it is for None.

    Raises:
        ScenarioError: the format holds joints, or there is no such frame.
    """
    if frame is None:
        return exporter
    if not exporter.framed:
        raise ScenarioError(f"{exporter.name}: holds joints, which need no frame; leave --frame out")
    if frame not in exporter.framed:
        raise ScenarioError(f"{exporter.name}: no frame {frame!r}; there are {', '.join(exporter.framed)}")
    return exporter.framed[frame]


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
    require_exportable(plan, exporter, rate)
    exporter.write(_samples(plan, rate), plan.scene, path)
    return judge_file(plan, exporter, path)


def judge_file(plan: Plan, exporter: Exporter, path: Path) -> Handover:
    """Judge a file that was written before, as its receiver will play it.

    Raises:
        PlanFolderError: it cannot be read, its samples are too dense to judge or not evenly spaced, or it ends at
            another time or place than the plan.
        ModelError: the liquids cannot be integrated along it.
    """
    samples = read_samples(exporter, path, plan.scene)
    _require_same_end(plan, samples, path)
    motion, lead = exporter.interpolation.motion(samples), _lead(plan, samples)
    return Handover(
        path=path,
        exporter=exporter,
        rate=samples.rate,
        samples=len(samples.t),
        certificate=certified(plan, samples, motion),
        joint_deviation=Handover.largest_deviation(plan.trajectory, samples, _done(plan, samples, motion), lead),
    )


def _samples(plan: Plan, rate: float) -> JointSamples:
    """What a file holds: the command, with its holds."""
    return held_samples(commanded_at(plan.trajectory, plan.scene.controller, rate), plan.scene.motion)


def _done(plan: Plan, samples: JointSamples, motion: JointMotion) -> JointMotion:
    """What a record of the file is about: what the joints do where the command compensates, else the command itself."""
    controller = plan.scene.controller
    if controller is None or not controller.compensate:
        return motion
    return followed(motion, controller, float(samples.t[0]), float(samples.t[-1]))


def read_samples(exporter: Exporter, path: Path, scene: Scene) -> JointSamples:
    """The samples of a file, evenly spaced and not too dense to be judged.

    Raises:
        PlanFolderError: they are not, or the file cannot be read.
    """
    samples = exporter.read(path, scene)
    _require_even(samples, path)
    return samples


def _lead(plan: Plan, samples: JointSamples) -> float:
    """Time in a file at which the plan's motion begins, s."""
    return hold_periods(plan.scene.motion, round(samples.rate, 3))[0] / samples.rate


def certified(plan: Plan, samples: JointSamples, motion: JointMotion) -> Certificate:
    """The certificate of a receiver's motion: constraints along it, its tray against the plan's path and record.

    The record is at the file's own rate, since that is what the receiver's differences are of; below the plan's rate,
    at the least multiple of it that is not lower. Between the plan's samples its path and pose are splines. Speeds and
    accelerations of the record become the receiver's own; where they exceed limits, the constraints say so.

    Args:
        plan: the plan.
        samples: of the file, with its holds.
        motion: what the receiver makes of them.
    """
    planned, lead = plan.trajectory, _lead(plan, samples)
    every = math.ceil(planned.rate / samples.rate * (1.0 - EVENNESS))
    count = (len(samples.t) - 1) * every + 1
    times = np.linspace(samples.t[0], samples.t[-1], count)
    t = times - lead + planned.t[0]

    def played(t: np.ndarray, order: int = 0, /) -> np.ndarray:
        return motion(t - planned.t[0] + lead, order)

    done = _done(plan, samples, motion)
    record = replace(
        interpolated(planned, t),
        joint_position=done(times),
        joint_speed=done(times, 1),
        joint_acceleration=done(times, 2),
    )
    # the holds are in the file, and its samples come at its own rate
    rules = replace(plan.scene.motion, hold_before=0.0, hold_after=0.0)
    return certify(record, replace(plan.scene, motion=rules, output_rate=record.rate), motion=played)


def rate_that_would_do(plan: Plan, exporter: Exporter, rates: Sequence[float] = USUAL_RATES) -> float | None:
    """The lowest of some rates, Hz, at which the format's receiver keeps the certificate; None if none does."""
    for rate in rates:
        if exporter.reason_against(plan.scene, rate) is not None:
            continue
        try:
            samples = _samples(plan, rate)
            if certified(plan, samples, exporter.interpolation.motion(samples)).ok:
                return rate
        except NospillError:  # a liquid that leaves its cup: not at this rate
            continue
    return None


def require_exportable(plan: Plan, exporter: Exporter, rate: float) -> None:
    """Refuse a scene or a rate that a format does not take.

    Raises:
        ScenarioError: it does not; says why.
    """
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
    period = 1.0 / samples.rate
    held = period * sum(hold_periods(plan.scene.motion, round(samples.rate, 3)))
    controller = plan.scene.controller
    longer = controller.spread if controller is not None and controller.compensate else 0.0
    length = float(planned.t[-1] - planned.t[0]) + held + longer
    if not length - END_TOLERANCE * period <= samples.t[-1] <= length + (1.0 + END_TOLERANCE) * period:
        raise PlanFolderError(f"{path}: lasts {samples.t[-1]:.6g} s; the plan lasts {length:.6g} s")
    apart = np.abs(samples.position[-1] - planned.joint_position[-1])
    joint = int(np.argmax(apart))
    if apart[joint] > END_TOLERANCE:
        raise PlanFolderError(
            f"{path}: {planned.joints[joint]} ends {apart[joint]:.4g} rad from where it ends in the plan"
        )
