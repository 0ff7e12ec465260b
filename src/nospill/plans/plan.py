"""The record of one planning task: question, answer, verdict and cost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from nospill.approach import Segment
from nospill.judge.certificate import Judgement
from nospill.judge.full_model import with_full_model
from nospill.judge.limiting import held_back, would_save
from nospill.judge.other_speeds import uses_at
from nospill.judge.verdict import Certificate
from nospill.judge.wording import describe, remedy
from nospill.motion.trajectory import Trajectory
from nospill.plans.folder import write_folder
from nospill.plans.records import MotionMaxima, PlanningReport, motion_maxima
from nospill.plans.summary import summary_of
from nospill.plans.warnings import plan_warnings
from nospill.plans.warnings.record import PlanWarning
from nospill.plans.warnings.speeds import other_speeds
from nospill.scene.scene import Scene


@dataclass(frozen=True, slots=True)
class Plan:
    """A planned motion with its verdict.

    Attributes:
        scene: the task.
        trajectory: the motion.
        certificate: the verdict.
        maxima: largest figures of the motion.
        report: what planning cost.
        judgement: the evidence of the certificate while it is at hand; not saved, None for a plan from a folder.
        approach: from where the arm is to the start of the trajectory, if the scenario asks for it. The certificate has
            the rows about it too.
        warnings: what the plan rests on beyond its limits; the verdict is without them.
    """

    scene: Scene
    trajectory: Trajectory
    certificate: Certificate
    maxima: MotionMaxima
    report: PlanningReport
    judgement: Judgement | None = field(default=None, repr=False, compare=False)
    approach: Segment | None = field(default=None, repr=False, compare=False)
    warnings: tuple[PlanWarning, ...] = ()

    @property
    def duration(self) -> float:
        """End time of the motion, s."""
        return self.trajectory.end_time

    @property
    def status(self) -> str:
        """One of "certified", "certified as published" (`fidelity = "deliverable"`) and "uncertified"."""
        return self.certificate.word if self.certificate.ok else "uncertified"

    @property
    def message(self) -> str:
        """One sentence: the verdict and, if it is no, the row that says so."""
        worst = self.certificate.worst
        if self.certificate.ok:
            return (
                f"{self.certificate.word.capitalize()}: {self.duration:.3f} s; nearest to its limit: {describe(worst)}."
            )
        return f"Not certified: {describe(worst)}.{remedy(worst, self.trajectory.rate)}"

    @property
    def held_back(self) -> str:
        """What holds the motion back, and for how much of its time, in one sentence; empty where nothing does."""
        return held_back(self.maxima.time_at_limit, self.scene.robot.joints)

    @property
    def would_save(self) -> str:
        """What a wider limit would save, in one sentence without a full stop; empty where nothing is known."""
        return would_save(self.report.savings, self.scene.robot.joints)

    @property
    def sooner(self) -> tuple[str, ...]:
        """How much sooner it is than what it was compared with, a line each."""
        return tuple(
            f"{name}: {other:.3f} s; this motion is {_sooner(other - self.duration, other)}"
            for name, other in self.report.compared.items()
        )

    def summary(self) -> dict[str, Any]:
        """What summary.json holds; the keys are stable."""
        return summary_of(self)

    def timed(self, phase: str, seconds: float) -> Plan:
        """The same plan with the time of one more phase in its report."""
        return replace(self, report=replace(self.report, phases={**self.report.phases, phase: seconds}))

    def with_second_looks(self) -> Plan:
        """The plan with what the full model sees beside its certificate, and what it uses at lower speeds."""
        found = replace(self, certificate=with_full_model(self.certificate, self.trajectory, self.scene))
        if self.maxima.other_speeds is not None:
            return found
        uses = uses_at(self.trajectory, self.scene)
        warnings = (*self.warnings, *other_speeds(uses))
        return replace(found, maxima=replace(self.maxima, other_speeds=uses), warnings=warnings)

    def save(
        self, folder: str | Path, *, extra: Callable[[Path], None] | None = None, time_writing: bool = False
    ) -> None:
        """Write the plan folder in one piece: a killed run leaves the old folder or none.

        Args:
            folder: place of the plan folder; an earlier plan there is replaced.
            extra: writes more files into the folder while it is being made, for example figures.
            time_writing: add the time this takes to the summary's phases, so that two copies differ in that figure.

        Raises:
            PlanFolderError: the folder holds something else or cannot be written, or no scenario
                describes the scene.
        """
        plan = self.with_second_looks()
        write_folder(
            folder,
            scene=plan.scene,
            trajectory=plan.trajectory,
            certificate=plan.certificate,
            approach=plan.approach,
            summary=lambda seconds: (plan.timed("write", seconds) if time_writing else plan).summary(),
            extra=extra,
        )


def _sooner(saved: float, whole: float) -> str:
    word = "sooner" if saved >= 0.0 else "later"
    return f"{abs(saved):.3f} s ({100 * abs(saved) / whole:.0f} %) {word}"


def judged_plan(scene: Scene, trajectory: Trajectory, judgement: Judgement, report: PlanningReport) -> Plan:
    """The plan of a judged motion, with its largest figures and its warnings; without an approach."""
    return Plan(
        scene=scene,
        trajectory=trajectory,
        certificate=judgement.certificate,
        maxima=motion_maxima(judgement, scene),
        report=report,
        judgement=judgement,
        warnings=plan_warnings(scene, judgement, report.backoff),
    )
