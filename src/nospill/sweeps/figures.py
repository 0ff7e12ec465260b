"""A plan in figures: what a line of a sweep says of a motion, or of a cycle of several."""

from __future__ import annotations

from nospill.certification.verdict import Row
from nospill.errors import ScenarioError
from nospill.planning.varied import Varied
from nospill.plans.cycle import CyclePlan
from nospill.plans.plan import Plan
from nospill.scene.scene import Scene

FIGURES = (
    "duration_s",
    "largest_use",
    "max_tray_acceleration_m_s2",
    "max_tilt_rad",
    "joint_speed_use",
    "max_slosh_height_m",
    "residual_height_m",
)
"""Names of the numbers that a motion has in its line."""
CYCLE_FIGURES = (*FIGURES, "wait_s", "cycles_per_hour", "moves_per_hour", "unloaded_per_hour")
"""Those of a cycle: its duration is that of the whole, dwells included; greatest values are those of any leg."""


def figure_names(base: Varied) -> tuple[str, ...]:
    """Of the figures that its plans have."""
    return CYCLE_FIGURES if base.is_cycle else FIGURES


def nearest(plan: Plan | CyclePlan) -> str:
    """Constraint and subject of the row nearest to its limit, of a cycle with its leg."""
    leg, row = _worst(plan)
    return f"{row.constraint} of {row.subject}" + (f", leg {leg}" if leg else "")


def figures_of(plan: Plan | CyclePlan) -> dict[str, float]:
    """The numbers of a motion or of a cycle, by the names in `FIGURES` or `CYCLE_FIGURES`."""
    maxima = [leg.maxima for leg in (plan.legs if isinstance(plan, CyclePlan) else [plan])]
    figures = {
        "duration_s": plan.duration,
        "largest_use": _worst(plan)[1].use,
        "max_tray_acceleration_m_s2": max(item.tray_acceleration for item in maxima),
        "max_tilt_rad": max(item.tilt for item in maxima),
        "joint_speed_use": max(item.joint_speed_use for item in maxima),
        "max_slosh_height_m": max((max(item.slosh_height.values(), default=0.0) for item in maxima), default=0.0),
        "residual_height_m": max((max(item.residual_height.values(), default=0.0) for item in maxima), default=0.0),
    }
    if isinstance(plan, CyclePlan):
        figures |= {name: getattr(plan, name) for name in ("cycles_per_hour", "moves_per_hour", "unloaded_per_hour")}
        figures["wait_s"] = plan.wait
    return {name: float(value) for name, value in figures.items()}


def require_no_own_limits(base: Varied) -> None:
    """Refuse limits that are given from Python, whose classes do not reach other processes; raises ScenarioError."""
    task = base.task
    given = [item.name for item in (*task.constraints, *task.unjudged)] if isinstance(task, Scene) else []
    if given:
        raise ScenarioError(
            f'{base.name}: the constraint "{given[0]}" is given from Python, and a sweep plans in other processes, '
            "which do not have its class; loop over scene.changed(...) with ns.Planner(constraints=[...]) instead"
        )


def _worst(plan: Plan | CyclePlan) -> tuple[str, Row]:
    return plan.certificate.worst if isinstance(plan, CyclePlan) else ("", plan.certificate.worst)
