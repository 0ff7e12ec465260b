"""summary.json: what it holds of a plan, in one table, and what of it is read back."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import MISSING, asdict, dataclass, fields
from typing import Any, Protocol

import numpy as np

from nospill.approach import Segment
from nospill.judge.other_speeds import SpeedUse
from nospill.judge.verdict import Certificate
from nospill.judge.wording import full_model_note
from nospill.plans.names import APPROACH_FILE
from nospill.plans.records import MotionMaxima, PlanningReport, Starts
from nospill.plans.settling import settling_time
from nospill.plans.warnings.record import PlanWarning
from nospill.scene.scene import Scene


class Summarised(Protocol):
    """What a summary reads of a plan."""

    @property
    def scene(self) -> Scene:
        """The task."""
        ...

    @property
    def certificate(self) -> Certificate:
        """The verdict."""
        ...

    @property
    def maxima(self) -> MotionMaxima:
        """Largest figures of the motion."""
        ...

    @property
    def report(self) -> PlanningReport:
        """What planning cost."""
        ...

    @property
    def approach(self) -> Segment | None:
        """How the arm gets to its start."""
        ...

    @property
    def warnings(self) -> tuple[PlanWarning, ...]:
        """What it rests on."""
        ...

    @property
    def duration(self) -> float:
        """End time of the motion, s."""
        ...

    @property
    def status(self) -> str:
        """The verdict in a word."""
        ...

    @property
    def message(self) -> str:
        """The verdict in a sentence."""
        ...

    @property
    def held_back(self) -> str:
        """What holds the motion back."""
        ...

    @property
    def would_save(self) -> str:
        """What a wider limit would save."""
        ...


@dataclass(frozen=True, slots=True)
class _Computed:
    """An entry of the summary that follows from the plan.

    Attributes:
        written: the plan -> its value.
    """

    written: Callable[[Summarised], Any]


@dataclass(frozen=True, slots=True)
class _Kept:
    """An entry of the summary that a plan folder is read back from.

    Attributes:
        record: attribute of the plan, "maxima" or "report".
        name: attribute of that record.
        to_json: its value -> what is written.
        from_json: what is written -> its value.
    """

    record: str
    name: str
    to_json: Callable[[Any], Any] = lambda value: value
    from_json: Callable[[Any], Any] = lambda value: value

    def written(self, plan: Summarised) -> Any:
        """The value as it is written."""
        return self.to_json(getattr(getattr(plan, self.record), self.name))


def _degrees(angle: float) -> float:
    return float(np.degrees(angle))


def _radians(angle: float) -> float:
    return float(np.radians(angle))


def _starts(found: Mapping[str, Any]) -> Starts:
    return Starts(found["tried"], found["converged"], found["agreed"], tuple(found["durations"]))


def _fractions(found: Mapping[str, Any]) -> dict[str, float]:
    return {name: float(value) for name, value in dict(found).items()}


def _speeds_written(uses: tuple[SpeedUse, ...] | None) -> list[dict[str, Any]] | None:
    return None if uses is None else [asdict(item) for item in uses]


def _speeds_read(found: list[dict[str, Any]] | None) -> tuple[SpeedUse, ...] | None:
    return None if found is None else tuple(SpeedUse(**item) for item in found)


def _settling(plan: Summarised) -> float | None:
    found = settling_time(plan.scene, plan.certificate)
    return found if np.isfinite(found) else None


def _largest_uses(plan: Summarised) -> dict[str, float] | None:
    uses = plan.maxima.other_speeds
    return None if not uses else {name: max(getattr(item, name) for item in uses) for name in ("liquid", "contact")}


def _certificate_summary(plan: Summarised) -> dict[str, Any]:
    worst = plan.certificate.worst
    return {
        "ok": plan.certificate.ok,
        "worst_constraint": f"{worst.constraint} | {worst.label}",
        "worst_margin": worst.worst_margin,
        "full_model": full_model_note(plan.certificate),
    }


def _approach_summary(plan: Summarised) -> dict[str, Any] | None:
    segment = plan.approach
    if segment is None:
        return None
    tray = "loaded" if segment.loaded else "empty"
    return {"file": APPROACH_FILE, "duration_s": segment.duration, "tray": tray, "stretch": segment.stretch}


_SUMMARY: dict[str, _Computed | _Kept] = {
    "scenario": _Computed(lambda plan: plan.scene.name),
    "status": _Computed(lambda plan: plan.status),
    "message": _Computed(lambda plan: plan.message),
    "duration_s": _Computed(lambda plan: plan.duration),
    "plan_time_s": _Kept("report", "plan_time"),
    "solve_time_s": _Kept("report", "solve_time"),
    "iterations": _Kept("report", "iterations"),
    "starts": _Kept("report", "starts", asdict, _starts),
    "max_tray_acceleration_m_s2": _Kept("maxima", "tray_acceleration"),
    "max_tray_angular_acceleration_rad_s2": _Kept("maxima", "tray_angular_acceleration"),
    "max_tilt_deg": _Kept("maxima", "tilt", _degrees, _radians),
    "max_joint_speed_use": _Kept("maxima", "joint_speed_use"),
    "max_slosh_height_m": _Kept("maxima", "slosh_height"),
    "residual_slosh_height_m": _Kept("maxima", "residual_height"),
    "certificate": _Computed(_certificate_summary),
    "held_back": _Computed(lambda plan: plan.held_back),
    "time_at_limit": _Kept("maxima", "time_at_limit"),
    "other_speeds": _Kept("maxima", "other_speeds", _speeds_written, _speeds_read),
    "largest_use_at_lower_speeds": _Computed(_largest_uses),
    "settling_s": _Computed(_settling),
    "would_save": _Computed(lambda plan: plan.would_save),
    "savings_s": _Kept("report", "savings", from_json=_fractions),
    "compared_s": _Kept("report", "compared", from_json=_fractions),
    "warnings": _Computed(lambda plan: [asdict(warning) for warning in plan.warnings]),
    "rounds": _Kept("report", "rounds"),
    "backoff": _Kept("report", "backoff", from_json=_fractions),
    "phases_s": _Kept("report", "phases"),
    "solver_status": _Kept("report", "solver_status"),
    "linear_solvers": _Kept("report", "linear_solvers", Counter, lambda counts: tuple(Counter(counts).elements())),
    "branch": _Kept("report", "branch"),
    "base_yaw": _Kept("report", "base_yaw"),
    "approach": _Computed(_approach_summary),
}


SUMMARY_KEYS = tuple(_SUMMARY)
"""Keys of the summary, in order; a failed one has them all, null from the duration on."""


def failed_summary(scenario: str, message: str) -> dict[str, Any]:
    """The summary of a scenario without a solution: all of `SUMMARY_KEYS`, null from the duration on."""
    return dict.fromkeys(SUMMARY_KEYS) | {"scenario": scenario, "status": "failed", "message": message}


def restored_records(summary: Mapping[str, Any]) -> tuple[MotionMaxima, PlanningReport]:
    """Largest figures and cost of planning from a summary; a key that older plans lack has its default.

    Raises:
        KeyError: a key is missing.
    """
    known = (*fields(MotionMaxima), *fields(PlanningReport))
    optional = {item.name for item in known if item.default is not MISSING or item.default_factory is not MISSING}
    found: dict[str, dict[str, Any]] = {"maxima": {}, "report": {}}
    for key, entry in _SUMMARY.items():
        if isinstance(entry, _Kept) and (key in summary or entry.name not in optional):
            found[entry.record][entry.name] = entry.from_json(summary[key])
    return MotionMaxima(**found["maxima"]), PlanningReport(**found["report"])


def summary_of(plan: Summarised) -> dict[str, Any]:
    """What summary.json holds of a plan; the keys are stable."""
    return {key: entry.written(plan) for key, entry in _SUMMARY.items()}
