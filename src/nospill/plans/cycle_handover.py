"""A whole cycle as one file for a controller, dwells included, read back and judged leg by leg."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import accumulate, pairwise
from pathlib import Path

import numpy as np

from nospill.certification.verdict import Certificate
from nospill.errors import PlanFolderError, ScenarioError
from nospill.export import Exporter
from nospill.motion.interpolation import JointMotion, JointSamples
from nospill.plans.cycle import CyclePlan
from nospill.plans.handover import Handover, rate_of, read_samples, require_exportable
from nospill.plans.played import certified, done_by, planned_samples

_SAME = 1e-6
"""rad; what a format's printing may change is far below."""


@dataclass(frozen=True, slots=True)
class CycleHandover:
    """A file of a whole cycle and what its receiver will make of it.

    Attributes:
        path: the file.
        exporter: its format.
        rate: samples per second, Hz.
        samples: how many.
        certificates: name of a leg -> of its part of the file, as the receiver plays it.
        joint_deviation: largest difference of a joint from the plans at any time, rad; between samples too.
    """

    path: Path
    exporter: Exporter
    rate: float
    samples: int
    certificates: tuple[tuple[str, Certificate], ...]
    joint_deviation: float

    @property
    def ok(self) -> bool:
        """Whether every leg is certified."""
        return all(certificate.ok for _, certificate in self.certificates)


def hand_over_cycle(plan: CyclePlan, exporter: Exporter, path: Path, *, rate: float | None = None) -> CycleHandover:
    """Write a cycle as one file, read it back and judge each leg, with its dwell, as its receiver will play it.

    Args:
        plan: of the cycle.
        exporter: the format.
        path: file to write, at once or not at all.
        rate: samples per second, Hz; the format's usual one or the plan's when left out.

    Raises:
        ScenarioError: the format does not take these scenes or this rate, states one payload for the whole file, or
            the joints are late, so that the command of one leg would run into the next.
        PlanFolderError: the disk refuses, or the file does not hold these motions when it is read.
        ModelError: the liquids cannot be integrated along what was read.
    """
    first, name = plan.legs[0], plan.cycle.name
    rate = rate_of(first, exporter, rate)
    for one in plan.legs:
        require_exportable(one, exporter, rate)
    if exporter.one_payload and len({len(one.scene.cargo) for one in plan.legs}) > 1:
        raise ScenarioError(
            f"{exporter.name}: states one payload for the file, and {name} carries another on each leg; export the "
            "folders of its legs"
        )
    if first.scene.controller is not None and first.scene.controller.is_late:
        raise ScenarioError(
            f"{name}: [controller] has a delay or lag, so that the command of a leg runs into the next one; export the "
            "folders of its legs"
        )
    parts = [planned_samples(one, rate) for one in plan.legs]
    ends = [0, *accumulate(len(part.t) - 1 for part in parts)]
    exporter.write(_joined(parts, rate), first.scene, path)
    bare = replace(first.scene, motion=replace(first.scene.motion, hold_before=0.0, hold_after=0.0))
    samples = read_samples(exporter, path, bare)
    if len(samples.t) != ends[-1] + 1:
        raise PlanFolderError(f"{path}: holds {len(samples.t)} samples where the cycle has {ends[-1] + 1}")
    motion = exporter.interpolation.motion(samples)
    certificates: list[tuple[str, Certificate]] = []
    deviation = 0.0
    for leg, one, (begin, end) in zip(plan.cycle.legs, plan.legs, pairwise(ends), strict=True):
        own, played = _part(samples, begin, end), _later(motion, float(samples.t[begin]))
        apart = float(np.max(np.abs(own.position[-1] - one.trajectory.joint_position[-1])))
        if apart > _SAME:
            raise PlanFolderError(f'{path}: leg "{leg.name}" ends {apart:.4g} rad from where it ends in the plan')
        certificates.append((leg.name, certified(one, own, played)))
        done = done_by(one, own, played)
        deviation = max(deviation, Handover.largest_deviation(one.trajectory, own, done))
    return CycleHandover(path, exporter, samples.rate, len(samples.t), tuple(certificates), deviation)


def _joined(parts: list[JointSamples], rate: float) -> JointSamples:
    """Samples one after the other; where one part ends the next begins."""

    def column(name: str) -> np.ndarray | None:
        values = [getattr(part, name) for part in parts]
        return None if values[0] is None else np.concatenate([values[0], *(value[1:] for value in values[1:])])

    position = column("position")
    assert position is not None  # of every part
    t = np.round(np.arange(len(position)) / rate * 1e9) / 1e9
    return JointSamples(t, position, column("speed"), column("acceleration"))


def _part(samples: JointSamples, begin: int, end: int) -> JointSamples:
    """Samples from one to another, on a clock that begins at 0."""
    rows = slice(begin, end + 1)
    speed, acceleration = (None if of is None else of[rows] for of in (samples.speed, samples.acceleration))
    return JointSamples(samples.t[rows] - samples.t[begin], samples.position[rows], speed, acceleration)


def _later(motion: JointMotion, begins: float) -> JointMotion:
    """A motion on a clock that begins later, s."""

    def played(t: np.ndarray, order: int = 0, /) -> np.ndarray:
        return motion(t + begins, order)

    return played
