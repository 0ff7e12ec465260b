"""The plan of a cycle: a plan for every leg, one certificate over all, and where the time goes."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from nospill.certification.verdict import Certificate, Row
from nospill.certification.wording import describe
from nospill.core.files import atomic_folder
from nospill.core.units import format_quantity
from nospill.motion.holds import hold_periods
from nospill.plans.names import (
    CERTIFICATE_FILE,
    CYCLE_FILE,
    FIGURES_FOLDER,
    LEGS_FOLDER,
    SCENARIO_FILE,
    is_cycle_folder,
)
from nospill.plans.plan import Plan
from nospill.plans.row_checks import SAME_JOINTS
from nospill.plans.settling import settling_time
from nospill.scene.cycle import Cycle

SEAM = "joints in a row"
"""Name of the rows about the joints between one leg and the next."""
_HOUR = 3600.0


@dataclass(frozen=True, slots=True)
class LegTime:
    """Where the time of one leg goes.

    Attributes:
        name: of the leg.
        motion: s.
        dwell: s, after it.
        begins: s, on the clock of the cycle.
        share: of the time of the whole cycle, both together.
        held_back: what holds the motion back, and for how much of its time, in words; empty where nothing does.
    """

    name: str
    motion: float
    dwell: float
    begins: float
    share: float
    held_back: str


@dataclass(frozen=True, slots=True, repr=False)
class CycleCertificate:
    """The verdict on a cycle: every leg is certified, dwell included, and the arm goes on from each with the next.

    Attributes:
        legs: name of a leg -> the certificate of its motion, which begins with the swing that the one before left.
        seams: a row for every two legs that follow each other, the last and the first too: the largest step of a joint.
        changed: what in a folder is not as it was planned, a sentence each.
    """

    legs: tuple[tuple[str, Certificate], ...]
    seams: tuple[Row, ...]
    changed: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether every row of every leg holds, every seam does, and nothing was changed."""
        return all(certificate.ok for _, certificate in self.legs) and self.holds_together

    @property
    def holds_together(self) -> bool:
        """Whether every seam holds and nothing was changed."""
        return all(row.ok for row in self.seams) and not self.changed

    def __repr__(self) -> str:
        return f"<CycleCertificate: {self.word}, {len(self.legs)} legs>"

    @property
    def word(self) -> str:
        """The verdict in a few words, of less than the full model as of a leg."""
        if not self.ok:
            return "not certified"
        return max((certificate.word for _, certificate in self.legs), key=len)

    @property
    def worst(self) -> tuple[str, Row]:
        """The leg and the row that uses most of its limit; a broken one before any other."""
        return max(
            ((name, certificate.worst) for name, certificate in self.legs),
            key=lambda item: (not item[1].ok, item[1].use),
        )

    @property
    def finding(self) -> str:
        """What the verdict rests on, in one phrase: what was changed, a seam that does not hold, or the worst row."""
        if self.changed:
            return self.changed[0]
        broken = next((row for row in self.seams if not row.ok), None)
        if broken is not None:
            step = format_quantity(broken.worst_value, "angle", digits=4)
            return f"the arm stands otherwise from {broken.subject}: a joint is {step} off"
        name, row = self.worst
        return f'leg "{name}": {describe(row)}'

    def to_dict(self) -> dict[str, Any]:
        """For certificate.json."""
        return {
            "ok": self.ok,
            "word": self.word,
            "legs": {name: certificate.to_dict() for name, certificate in self.legs},
            "seams": [
                {"from": row.subject, "largest_step_rad": row.worst_value, "limit_rad": row.limit, "ok": row.ok}
                for row in self.seams
            ],
            "changed": list(self.changed),
        }


@dataclass(frozen=True, repr=False)  # without slots: what is left at the end is found once
class CyclePlan:
    """The plan of a cycle.

    Attributes:
        cycle: the task, with all dwells in s.
        legs: a plan for every leg; the scene of each begins where, and with the swing that, the one before it ends.
        certificate: the verdict on all of it.
    """

    cycle: Cycle
    legs: tuple[Plan, ...]
    certificate: CycleCertificate

    def __repr__(self) -> str:
        return f"<CyclePlan of {self.cycle.name}: {self.duration:.3f} s, {self.certificate.word}>"

    @property
    def duration(self) -> float:
        """Of the whole cycle, dwells included, s."""
        return round(sum(leg.motion + leg.dwell for leg in self.times), 9)

    @property
    def times(self) -> tuple[LegTime, ...]:
        """Where the time goes, leg by leg; motions and dwells as files hold them, in whole sample periods."""
        spans = [_spans(plan) for plan in self.legs]
        whole = sum(motion + dwell for motion, dwell in spans)
        found: list[LegTime] = []
        begins = 0.0
        for leg, plan, (motion, dwell) in zip(self.cycle.legs, self.legs, spans, strict=True):
            found.append(LegTime(leg.name, motion, dwell, begins, (motion + dwell) / whole, plan.limiting_text))
            begins += motion + dwell
        return tuple(found)

    @cached_property
    def wait(self) -> float:
        """How long to wait after the cycle until it may begin again as it was planned, with liquids at rest, s."""
        last, off = self.legs[-1], self.cycle.legs[-1].unloaded
        stays = tuple(item for item in last.scene.cargo if item.name not in off)
        settled = settling_time(replace(last.scene, cargo=stays), last.certificate)
        return max(settled - self.times[-1].dwell, 0.0)

    @property
    def cycles_per_hour(self) -> float:
        """Cycles an hour, with the wait after each."""
        return _HOUR / (self.duration + self.wait)

    @property
    def moves_per_hour(self) -> float:
        """Legs an hour, likewise."""
        return len(self.legs) * self.cycles_per_hour

    @property
    def unloaded_per_hour(self) -> float:
        """Objects taken off the tray in an hour, likewise."""
        return sum(len(leg.unloaded) for leg in self.cycle.legs) * self.cycles_per_hour

    @property
    def message(self) -> str:
        """One sentence: the verdict and what it rests on."""
        if self.certificate.ok:
            word = self.certificate.word.capitalize()
            return f"{word}: {self.duration:.3f} s; nearest to its limit: {self.certificate.finding}."
        return f"Not certified: {self.certificate.finding}."

    @property
    def losses_text(self) -> str:
        """Where the cycle loses its time, in one sentence without a full stop."""
        times, whole = self.times, self.duration
        longest = max(times, key=lambda leg: leg.motion)
        held = f": {longest.held_back}" if longest.held_back else ""
        text = f"most time: leg {longest.name}, {longest.motion:.3f} s ({100 * longest.motion / whole:.0f} %){held}"
        stands = sum(leg.dwell for leg in times)
        return f"{text}; dwells {stands:.3f} s ({100 * stands / whole:.0f} %)" if stands else text

    @property
    def repeats_text(self) -> str:
        """Whether the cycle ends as it began, in one sentence without a full stop."""
        if self.wait == 0.0:
            return "the cycle ends as it began: what it carries next is fresh or at rest (2 % of its limit)"
        return f"the cycle does not end as it began: its liquids swing on, and rest after {self.wait:.1f} s"

    def with_second_looks(self) -> CyclePlan:
        """The same with what the full model sees of every leg, and what each survives of its arm."""
        legs = tuple(one.with_second_looks() for one in self.legs)
        own = tuple((leg.name, one.certificate) for leg, one in zip(self.cycle.legs, legs, strict=True))
        return replace(self, legs=legs, certificate=replace(self.certificate, legs=own))

    def with_changes(self, changed: Sequence[str]) -> CyclePlan:
        """The plan whose certificate knows what in a folder is not as it was planned."""
        return replace(self, certificate=replace(self.certificate, changed=tuple(changed)))

    def summary(self) -> dict[str, Any]:
        """What cycle.json holds; the keys are stable."""
        return {
            "scenario": self.cycle.name,
            "status": self.certificate.word if self.certificate.ok else "uncertified",
            "message": self.message,
            "duration_s": self.duration,
            "cycles_per_hour": self.cycles_per_hour,
            "moves_per_hour": self.moves_per_hour,
            "unloaded_per_hour": self.unloaded_per_hour,
            "wait_s": self.wait if np.isfinite(self.wait) else None,
            "repeats": self.repeats_text,
            "losses": self.losses_text,
            "legs": [
                {
                    "name": leg.name,
                    "folder": leg_folder(index, leg.name),
                    "begins_s": leg.begins,
                    "motion_s": leg.motion,
                    "dwell_s": leg.dwell,
                    "share": leg.share,
                    "held_back": leg.held_back,
                    "cargo": [item.name for item in plan.scene.cargo],
                    "unload": list(task.unloaded),
                    "load": list(task.loaded),
                }
                for index, (leg, plan, task) in enumerate(zip(self.times, self.legs, self.cycle.legs, strict=True))
            ],
        }

    def save(
        self,
        folder: str | Path,
        *,
        extra: Callable[[Plan, Path], None] | None = None,
        figures: Callable[[Path], None] | None = None,
    ) -> None:
        """Write the folder of the cycle in one piece: a killed run leaves the old folder or none.

        Args:
            folder: place of the folder; an earlier plan of a cycle there is replaced.
            extra: writes more files into the folder of a leg while it is being made, for example figures.
            figures: writes figures of the whole cycle into a folder that is there.

        Raises:
            PlanFolderError: the folder holds something else or cannot be written.
        """
        with atomic_folder(folder, replaceable=is_cycle_folder) as partial:
            (partial / SCENARIO_FILE).write_text(self.cycle.text, encoding="utf-8")
            for index, (leg, one) in enumerate(zip(self.cycle.legs, self.legs, strict=True)):
                place = partial / leg_folder(index, leg.name)
                one.save(place, extra=None if extra is None else functools.partial(extra, one))
            if figures is not None:
                (partial / FIGURES_FOLDER).mkdir()
                figures(partial / FIGURES_FOLDER)
            for name, table in ((CERTIFICATE_FILE, self.certificate.to_dict()), (CYCLE_FILE, self.summary())):
                text = json.dumps(table, indent=2, allow_nan=False) + "\n"
                (partial / name).write_text(text, encoding="utf-8")


def leg_folder(index: int, name: str) -> str:
    """Folder of a leg in that of its cycle."""
    return f"{LEGS_FOLDER}/{index + 1}-{name}"


def seams(legs: Sequence[tuple[str, Plan]]) -> tuple[Row, ...]:
    """A row for every two legs that follow each other, the last and the first too."""
    rows: list[Row] = []
    t = 0.0
    for (name, plan), (following, after) in zip(legs, [*legs[1:], legs[0]], strict=True):
        t += sum(_spans(plan))
        step = float(np.max(np.abs(after.trajectory.joint_position[0] - plan.trajectory.joint_position[-1])))
        left = SAME_JOINTS - step
        rows.append(Row(SEAM, f"{name} to {following}", "rad", SAME_JOINTS, step, left, t, left >= 0.0))
    return tuple(rows)


def planned_cycle(cycle: Cycle, legs: Sequence[Plan]) -> CyclePlan:
    """The plan of a cycle from the plans of its legs, with their own certificates."""
    named = [(leg.name, plan) for leg, plan in zip(cycle.legs, legs, strict=True)]
    certificate = CycleCertificate(tuple((name, plan.certificate) for name, plan in named), seams(named))
    return CyclePlan(cycle, tuple(legs), certificate)


def _spans(plan: Plan) -> tuple[float, float]:
    """Motion and dwell as files hold them, s."""
    record = plan.trajectory
    spans = record.t[-1] - record.t[0], hold_periods(plan.scene.motion, record.rate)[1] / record.rate
    return round(float(spans[0]), 9), round(float(spans[1]), 9)
