"""From a plan to a file for a controller, and back: the file is judged as its receiver will play it.

What was written is read from the disk again, turned into a motion by the receiver's interpolation, and judged with the
constraints, the tolerances and the code of every other certificate. Nothing is optimised.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from nospill.certification.verdict import Certificate
from nospill.core.suggestions import nearest
from nospill.errors import NospillError, PlanFolderError, ScenarioError
from nospill.export import EXPORTERS, Exporter
from nospill.motion.holds import hold_periods
from nospill.motion.interpolation import JointMotion, JointSamples
from nospill.motion.resampling import HIGHEST_RATE
from nospill.motion.trajectory import Trajectory
from nospill.plans.plan import Plan
from nospill.plans.played import EVENNESS, certified, done_by, evenly_spaced, fewest_certified, lead_of, planned_samples
from nospill.scene.scene import Scene

USUAL_RATES = (50.0, 100.0, 125.0, 200.0, 250.0, 500.0, 1000.0)
"""Hz; the rates among which one that would do is looked for."""

END_TOLERANCE = 1e-6
"""rad; a file ends where the plan ends."""

_PROGRAMS = {"krl": "csv --profile rsi-4ms", "rapid": "csv --profile egm"}
"""Languages whose controllers plan their own motion between points, and the format that states every position."""

_FINENESS = 8
"""Instants per period at which a motion is compared with the plan."""


@dataclass(frozen=True, slots=True)
class Handover:
    """A file and what its receiver will make of it.

    Attributes:
        path: the file or folder.
        exporter: its format.
        rate: samples per second, Hz; in the mean where they are not evenly spaced.
        samples: how many.
        even: whether they are evenly spaced.
        certificate: of the motion read back.
        joint_deviation: largest difference of a joint from the plan at any time, rad; between samples too.
    """

    path: Path
    exporter: Exporter
    rate: float
    samples: int
    even: bool
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
    instead = _PROGRAMS.get(name.lower())
    if instead is not None:
        raise ScenarioError(
            f"no format {name!r}: its controller plans a motion of its own between points, which nothing certifies; "
            f"use --format {instead}"
        )
    if name not in EXPORTERS:
        near = nearest(name, EXPORTERS) or next((one for one in EXPORTERS if one.startswith(name[:2].lower())), None)
        hint = f"; did you mean {near!r}?" if near else ""
        raise ScenarioError(f"no format {name!r}; there are {', '.join(EXPORTERS)}{hint}")
    return EXPORTERS[name]


def with_options(exporter: Exporter, options: Mapping[str, object]) -> Exporter:
    """The format with what is chosen about it.

    Args:
        exporter: the format.
        options: by name; None where nothing is chosen.

    Raises:
        ScenarioError: the format has no such option, or an option no such value.
    """
    chosen = {name: value for name, value in options.items() if value is not None}
    if not chosen:
        return exporter
    for name in chosen:
        if name not in exporter.options:
            offered = f"its options are --{', --'.join(exporter.options)}" if exporter.options else "it has no options"
            raise ScenarioError(f"{exporter.name}: no option --{name}; {offered}")
    assert exporter.with_options is not None
    return exporter.with_options(**chosen)


def hand_over(
    plan: Plan,
    exporter: Exporter | str,
    path: str | Path,
    *,
    rate: float | None = None,
    points: int | None = None,
    **options: object,
) -> Handover:
    """Write a plan's file, read it back and judge what its receiver will play.

    Args:
        plan: with a scene and a trajectory.
        exporter: the format or its name, as "urscript"; `nospill export --list` has them.
        path: file to write, at once or not at all.
        rate: samples per second, Hz; the format's usual one or the plan's when left out.
        points: how many samples there may be at most; then they are the fewest, unevenly spaced, that stay certified,
            of the plan's own. Those of `[controller]` when left out, for a format of uneven samples.
        options: of the format, as `with_options` takes them: gain=300 of "urscript".

    Raises:
        ScenarioError: no format has this name or these options, or it does not take this scene, rate or uneven samples;
            or more samples are needed.
        PlanFolderError: the disk refuses, or the file does not hold this plan's motion when it is read.
        ModelError: the liquids cannot be integrated along what was read.
    """
    exporter = with_options(exporter_named(exporter) if isinstance(exporter, str) else exporter, options)
    path = Path(path)
    if points is not None and rate is not None:
        raise ScenarioError(f"{exporter.name}: few points are some of the plan's own; leave --rate or --points out")
    rate = rate_of(plan, exporter, rate)
    require_exportable(plan, exporter, rate)
    samples = planned_samples(plan, rate)
    taken = None if plan.scene.controller is None else plan.scene.controller.points
    if points is not None:
        samples = fewest_certified(plan, exporter, samples, points, "--points")
    elif taken is not None and exporter.uneven and len(samples.t) > taken:
        samples = fewest_certified(plan, exporter, samples, taken, "controller.points")
    exporter.write(samples, plan.scene, path)
    return judge_exported_file(plan, exporter, path)


def rate_of(plan: Plan, exporter: Exporter, rate: float | None) -> float:
    """The rate asked for, else the one that the format is usually read at, else the plan's, Hz."""
    usual = plan.scene.output_rate if exporter.usual_rate is None else exporter.usual_rate
    return usual if rate is None else rate


def judge_exported_file(plan: Plan, exporter: Exporter, path: Path) -> Handover:
    """Judge a file that was written before, as its receiver will play it.

    Raises:
        PlanFolderError: it cannot be read, its samples are too dense to judge or not evenly spaced, or it ends at
            another time or place than the plan.
        ModelError: the liquids cannot be integrated along it.
    """
    samples = read_samples(exporter, path, plan.scene)
    _require_same_end(plan, samples, path)
    motion, lead = exporter.interpolation.motion(samples), lead_of(plan, samples)
    return Handover(
        path=path,
        exporter=exporter,
        rate=samples.rate,
        samples=len(samples.t),
        even=evenly_spaced(samples),
        certificate=certified(plan, samples, motion),
        joint_deviation=Handover.largest_deviation(plan.trajectory, samples, done_by(plan, samples, motion), lead),
    )


def read_samples(exporter: Exporter, path: Path, scene: Scene) -> JointSamples:
    """The samples of a file, not too dense to be judged, and evenly spaced where the receiver wants that.

    Raises:
        PlanFolderError: they are not, or the file cannot be read.
    """
    samples = exporter.read(path, scene)
    _require_judgeable(samples, path, may_be_uneven=exporter.uneven)
    return samples


def rate_that_would_do(plan: Plan, exporter: Exporter, rates: Sequence[float] = USUAL_RATES) -> float | None:
    """The lowest of some rates, Hz, at which the format's receiver keeps the certificate; None if none does."""
    for rate in rates:
        if exporter.reason_against(plan.scene, rate) is not None:
            continue
        try:
            samples = planned_samples(plan, rate)
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


def _require_judgeable(samples: JointSamples, path: Path, *, may_be_uneven: bool) -> None:
    """What lies closer together than the judge looks could hide anything."""
    if samples.rate > HIGHEST_RATE * (1.0 + EVENNESS):
        raise PlanFolderError(f"{path}: {samples.rate:g} samples per second; at most {HIGHEST_RATE:g} can be judged")
    if may_be_uneven:
        closest = int(np.argmin(np.diff(samples.t)))
        apart = samples.t[closest + 1] - samples.t[closest]
        if apart * HIGHEST_RATE < 1.0 - EVENNESS:
            raise PlanFolderError(
                f"{path}: samples {closest + 1} and {closest + 2} are {1e3 * apart:.4g} ms apart; at least "
                f"{1e3 / HIGHEST_RATE:g} ms can be judged"
            )
        return
    uneven = np.abs(np.diff(samples.t) * samples.rate - 1.0)
    row = int(np.argmax(uneven))
    if uneven[row] > EVENNESS:
        raise PlanFolderError(
            f"{path}: samples {row + 1} and {row + 2} are {samples.t[row + 1] - samples.t[row]:.6g} s apart, "
            f"{1.0 / samples.rate:.6g} s in the mean; evenly spaced ones are expected"
        )


def _require_same_end(plan: Plan, samples: JointSamples, path: Path) -> None:
    planned = plan.trajectory
    rate = samples.rate if evenly_spaced(samples) else planned.rate
    period = 1.0 / rate
    held = period * sum(hold_periods(plan.scene.motion, round(rate, 3)))
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
