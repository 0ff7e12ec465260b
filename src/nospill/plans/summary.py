"""The summary of a plan, summary.json: what each of its keys says, and what a plan folder is read back from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import MISSING, asdict, dataclass, fields
from typing import Any

import numpy as np

from nospill.certification.height_order import height_orders, residual_orders
from nospill.certification.left_after_end import left_read, left_written
from nospill.certification.other_speeds import SpeedUse
from nospill.certification.survived import Survival
from nospill.certification.wording import full_model_note
from nospill.plans.names import APPROACH_FILE
from nospill.plans.plan import Plan
from nospill.plans.records import MotionMaxima, PlanningReport, Starts
from nospill.plans.settling import settling_time
from nospill.scene.limits import LimitRecord
from nospill.scene.scene import Scene


@dataclass(frozen=True, slots=True)
class _Computed:
    """An entry of the summary that follows from the plan.

    Attributes:
        written: the plan -> its value.
    """

    written: Callable[[Plan], Any]


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

    def written(self, plan: Plan) -> Any:
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


def _solvers_read(counts: Mapping[str, int]) -> tuple[str, ...]:
    """One name a solve; a damaged count would fill the memory with names."""
    if any(count not in range(_MOST_SOLVES) for count in dict(counts).values()):
        raise ValueError(f"linear_solvers: {dict(counts)}: counts from 0 to {_MOST_SOLVES - 1} are allowed")
    return tuple(Counter(dict(counts)).elements())


def _speeds_written(uses: tuple[SpeedUse, ...] | None) -> list[dict[str, Any]] | None:
    return None if uses is None else [asdict(item) for item in uses]


def _speeds_read(found: list[dict[str, Any]] | None) -> tuple[SpeedUse, ...] | None:
    return None if found is None else tuple(SpeedUse(**item) for item in found)


def _survival_written(found: Survival | None) -> dict[str, Any] | None:
    return None if found is None else found.to_dict()


def _survival_read(found: dict[str, Any] | None) -> Survival | None:
    return None if found is None else Survival.of_dict(found)


def _settling(plan: Plan) -> float | None:
    found = settling_time(plan.scene, plan.certificate)
    return found if np.isfinite(found) else None


def _largest_uses(plan: Plan) -> dict[str, float] | None:
    uses = plan.maxima.other_speeds
    return None if not uses else {name: max(getattr(item, name) for item in uses) for name in ("liquid", "contact")}


def _safe_at_lower_speeds(plan: Plan) -> bool | None:
    uses = plan.maxima.other_speeds
    return None if not uses else all(item.safe for item in uses)


def _certificate_summary(plan: Plan) -> dict[str, Any]:
    worst = plan.certificate.worst
    return {
        "ok": plan.certificate.ok,
        "worst_constraint": f"{worst.constraint} | {worst.label}",
        "worst_margin": worst.worst_margin,
        "full_model": full_model_note(plan.certificate),
    }


def _self_collision(plan: Plan) -> dict[str, object] | None:
    found = plan.certificate.self_collision
    return None if found is None else found.to_dict()


def _limits(scene: Scene) -> tuple[LimitRecord, ...]:
    return (*(limit.record for limit in scene.constraints), *scene.unjudged)


def _approach_summary(plan: Plan) -> dict[str, Any] | None:
    segment = plan.approach
    if segment is None:
        return None
    tray = "loaded" if segment.loaded else "empty"
    return {"file": APPROACH_FILE, "duration_s": segment.duration, "tray": tray, "stretch": segment.stretch}


_MOST_SOLVES = 100_000
"""Of a plan, by one linear solver: bounds the memory that a damaged file can ask for."""

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
    "self_collision": _Computed(_self_collision),
    "slosh_height_order": _Computed(lambda plan: height_orders(plan.scene)),
    "residual_height_order": _Computed(lambda plan: residual_orders(plan.scene)),
    "constraints": _Computed(lambda plan: [limit.to_dict() for limit in _limits(plan.scene)]),
    "held_back": _Computed(lambda plan: plan.limiting_text),
    "time_at_limit": _Kept("maxima", "time_at_limit"),
    "other_speeds": _Kept("maxima", "other_speeds", _speeds_written, _speeds_read),
    "largest_use_at_lower_speeds": _Computed(_largest_uses),
    "safe_at_lower_speeds": _Computed(_safe_at_lower_speeds),
    "survives": _Computed(lambda plan: plan.survival_text),
    "survival": _Kept("maxima", "survival", _survival_written, _survival_read),
    "left_after_end": _Kept("maxima", "left", left_written, left_read),
    "settling_s": _Computed(_settling),
    "would_save": _Computed(lambda plan: plan.savings_text),
    "savings_s": _Kept("report", "savings", from_json=_fractions),
    "compared_s": _Kept("report", "compared", from_json=_fractions),
    "warnings": _Computed(lambda plan: [asdict(warning) for warning in plan.warnings]),
    "rounds": _Kept("report", "rounds"),
    "backoff": _Kept("report", "backoff", from_json=_fractions),
    "jerk_weight_factor": _Kept("report", "jerk_weight_factor"),
    "phases_s": _Kept("report", "phases"),
    "solver_status": _Kept("report", "solver_status"),
    "ran_out": _Kept("report", "ran_out"),
    "fallbacks": _Kept("report", "fallbacks", list, tuple),
    "linear_solvers": _Kept("report", "linear_solvers", Counter, _solvers_read),
    "branch": _Kept("report", "branch"),
    "base_yaw": _Kept("report", "base_yaw"),
    "end_yaws": _Kept("report", "end_yaws"),
    "blocked_way": _Kept("report", "blocked_way"),
    "warm": _Kept("report", "warm"),
    "not_warm": _Kept("report", "not_warm"),
    "approach": _Computed(_approach_summary),
}


SUMMARY_KEYS = tuple(_SUMMARY)
"""Keys of the summary, in order; a failed one has them all, null from the duration on."""


def summary_of(plan: Plan) -> dict[str, Any]:
    """What summary.json holds of a plan; the keys are stable."""
    return {key: entry.written(plan) for key, entry in _SUMMARY.items()}


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
