"""The record of one planning task: question, answer, verdict and cost."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nospill.approach import Segment
from nospill.certification.certificate import Judgement, judge
from nospill.certification.full_model import judged_in_full, with_full_model, with_rows_of
from nospill.certification.histories import ContactLoad, History, ModalStates, contact_load, history_of, modal_states
from nospill.certification.known_arm import beside
from nospill.certification.left_after_end import LeftAfterEnd, left_after_end, left_line
from nospill.certification.limiting import limiting_text, savings_text
from nospill.certification.other_speeds import uses_at
from nospill.certification.replay import tray_from_joints
from nospill.certification.survival import survival
from nospill.certification.survived import Survival
from nospill.certification.verdict import Certificate
from nospill.certification.wording import describe, finding, remedy, tight_time
from nospill.core.blas_threads import one_blas_thread
from nospill.laws.constraints.base import RowId
from nospill.motion.trajectory import Trajectory
from nospill.plans.folder import write_folder
from nospill.plans.records import MotionMaxima, PlanningReport, motion_maxima
from nospill.plans.state import MotionState, states_of
from nospill.plans.warnings import plan_warnings, slower_warnings
from nospill.plans.warnings.record import PlanWarning
from nospill.robots.kinematics.forward import ToolMotions
from nospill.scene.scene import Scene


@dataclass(frozen=True, repr=False)  # without slots: what a folder does not hold is judged again once
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

    def __repr__(self) -> str:
        kinds = len({warning.name for warning in self.warnings})
        warned = f", {kinds} {'warning' if kinds == 1 else 'warnings'}" if kinds else ""
        return f"<Plan of {self.scene.name}: {self.duration:.3f} s, {self.status}{warned}>"

    @property
    def status(self) -> str:
        """The verdict's word (`Certificate.word`), or "uncertified"."""
        return self.certificate.word if self.certificate.ok else "uncertified"

    @property
    def message(self) -> str:
        """One sentence: the verdict and, if it is no, the row that says so."""
        worst = self.certificate.worst
        if self.certificate.ok:
            return (
                f"{self.certificate.word.capitalize()}: {self.duration:.3f} s; nearest to its limit: {describe(worst)}."
            )
        longest = self.scene.planning.max_plan_time
        ended = f" Planning ended at planning.max_plan_time = {longest:g} s: allow more." if self.report.ran_out else ""
        advice = f"{remedy(worst, self.trajectory.rate)}{ended}{tight_time(self.scene)}"
        return f"Not certified: {finding(self.certificate)}.{advice}"

    @property
    def certified_speeds(self) -> tuple[float, float] | None:
        """The range of speeds that the certificate is about and holds in; None where there is none."""
        return self.scene.motion.speed_range if self.certificate.ok else None

    @property
    def limiting_text(self) -> str:
        """What holds the motion back, and for how much of its time, in one sentence; empty where nothing does."""
        return limiting_text(self.maxima.time_at_limit, self.scene.robot.joints)

    @property
    def savings_text(self) -> str:
        """What a wider limit would save, in one sentence without a full stop; empty where nothing is known."""
        return savings_text(self.report.savings, self.scene.robot.joints)

    @cached_property
    def survival(self) -> Survival | None:
        """What it survives of an arm that does not quite track it, found once; None of an empty tray."""
        return self.maxima.survival or survival(self.trajectory, self.scene, self.certificate.rows)

    @property
    def survival_text(self) -> str:
        """The same in a sentence without a full stop, of a plan that was printed or saved; else empty.

        Beside it stands what the arm is known for, and what to state where it survives less than that.
        """
        found = self.maxima.survival
        return "" if found is None else "; ".join(filter(None, (found.text, beside(found, self.scene))))

    @cached_property
    def left_after_end(self) -> dict[str, LeftAfterEnd]:
        """What is left of each liquid's waves after the end in three columns, found once; by object."""
        known = self.maxima.left
        return left_after_end(self.trajectory, self.scene, self.evidence.replay) if known is None else known

    @property
    def left_text(self) -> str:
        """The same in a line, of a plan that was printed or saved; else empty."""
        return left_line(self.maxima.left or {})

    @property
    def comparison(self) -> tuple[str, ...]:
        """How much sooner it is than what it was compared with, a line each."""
        return tuple(
            f"{name}: {other:.3f} s; this motion is {_sooner(other - self.duration, other)}"
            for name, other in self.report.compared.items()
        )

    @cached_property
    def evidence(self) -> Judgement:
        """`judgement`; for a plan from a folder its trajectory is judged again, once.

        Raises:
            PlanFolderError: the trajectory does not fit the scene, or is no motion.
            ModelError: the liquids cannot be integrated.
        """
        return self.judgement or judge(self.trajectory, self.scene)

    @property
    def histories(self) -> tuple[RowId, ...]:
        """Constraint and subject of every limit that `history` has over time: the rows of the certificate."""
        return tuple(row.id for row in self.evidence.certificate.rows)

    def history(self, constraint: str, subject: str) -> History:
        """One limit over the motion at the instants that were judged; its largest use is that of the row.

        Where numbers of an object may be off, or the speed may be lower, it is that of the worst variant, as in the
        row. Limits on the end and on a place that is passed have one instant; a distance has those at some instants
        and the least of all. Limits on the approach have none.

        Args:
            constraint: name of the row, as "slosh height".
            subject: what it is about, as "c1".

        Raises:
            ScenarioError: the certificate has no such row.
        """
        return history_of(self.evidence, self.scene, RowId(constraint, subject))

    def contact(self, name: str) -> ContactLoad:
        """Force and moment of the tray on an object, at the instants that were judged, for its numbers as stated.

        Raises:
            ScenarioError: there is no such object, or it stands in a carrier.
        """
        return contact_load(self.evidence, self.scene, name)

    def modes(self, name: str) -> ModalStates:
        """The slosh modes of an object's liquid, likewise.

        Raises:
            ScenarioError: there is no such object, or it holds no liquid.
        """
        return modal_states(self.evidence, self.scene, name)

    def tray(self, t: ArrayLike) -> ToolMotions:
        """Pose and motion of the tray at any time of the motion, as the joints of the trajectory carry it.

        Args:
            t: one time or many, (m,), s.

        Returns:
            Arrays with samples first; of one time, without them.

        Raises:
            ScenarioError: a time is outside the motion or no number.
        """
        times = np.asarray(self.trajectory.require_times(t))
        motion = tray_from_joints(self.scene, [self.trajectory(np.atleast_1d(times), order) for order in range(3)])[0]
        return motion if times.ndim else ToolMotions(*(getattr(motion, item.name)[0] for item in fields(motion)))

    def state_at(self, t: float) -> MotionState:
        """How arm, tray and liquids move at the sample nearest to a time, s: where another motion may go on from.

        Raises:
            ScenarioError: the time is outside the motion, or the state is not known: the joints follow their controller
                late.
            ModelError: the liquids cannot be integrated.
        """
        return states_of(self.trajectory, self.scene, [t])[0]

    @property
    def plots(self) -> tuple[str, ...]:
        """Names of the figures that `plot` draws, whether or not they apply."""
        return tuple(_figures().NAMES)

    def plot(self, name: str) -> Any:
        """A figure of the plan as a `matplotlib.figure.Figure`, which no window and no file has.

        Raises:
            ScenarioError: there is no such figure, or it does not apply to this plan.
        """
        return _figures().figure_of(self, name)

    def summary(self) -> dict[str, Any]:
        """What summary.json holds; the keys are stable."""
        return dict(importlib.import_module("nospill.plans.summary").summary_of(self))

    def text(self) -> str:
        """What `nospill plan` prints of it, in many lines: certificate, warnings, what holds it back, what it survives.

        Raises:
            PlanFolderError, ModelError: as `evidence`.
        """
        return str(importlib.import_module("nospill.plans.text").plan_text(self.with_second_looks()))

    def timed(self, phase: str, seconds: float) -> Plan:
        """The same plan with the time of one more phase in its report."""
        return replace(self, report=replace(self.report, phases={**self.report.phases, phase: seconds}))

    @one_blas_thread()
    def with_second_looks(self) -> Plan:
        """The plan with what the full model sees, what it uses at lower speeds, and what it survives of its arm."""
        maxima = replace(self.maxima, survival=self.survival, left=self.left_after_end)
        if maxima.other_speeds is not None:
            known = with_full_model(self.certificate, self.trajectory, self.scene)
            return replace(self, certificate=known, maxima=maxima)
        full = judged_in_full(self.evidence, self.trajectory, self.scene)
        found = replace(self, certificate=with_rows_of(self.certificate, full, self.scene), maxima=maxima)
        uses = uses_at(self.trajectory, self.scene)
        warnings = (*self.warnings, *slower_warnings(self.scene, self.evidence, full, uses, found.certified_speeds))
        return replace(found, maxima=replace(found.maxima, other_speeds=uses), warnings=warnings)

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


def _figures() -> Any:
    """The package of figures, which lies above this one: it is imported where one is asked for."""
    return importlib.import_module("nospill.plots.figures")


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
        warnings=plan_warnings(scene, judgement, report.backoff, report.fallbacks),
    )
