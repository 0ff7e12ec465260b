"""What is varied: a motion or a cycle of several, each read, changed, planned and told in figures the same way."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from nospill.certification.verdict import Row
from nospill.certification.wording import describe
from nospill.errors import ScenarioError
from nospill.planning.cycles import CyclePlanner
from nospill.planning.planner import Planner
from nospill.plans.cycle import CyclePlan
from nospill.plans.plan import Plan
from nospill.scenario import load, scene_from_table
from nospill.scenario.cycles import changed_cycle, cycle_from_table, load_cycle
from nospill.scenario.loading import ScenarioSource, has_legs
from nospill.scene.cycle import Cycle
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
CYCLE_FIGURES = (*FIGURES, "wait_s", "cycles_per_hour", "moves_per_hour")
"""Those of a cycle: its duration is that of the whole, dwells included; greatest values are those of any leg."""


@dataclass(frozen=True, slots=True)
class VariedMotion:
    """A motion as the base of variants."""

    scene: Scene

    figures = FIGURES

    @property
    def name(self) -> str:
        """Of the scenario."""
        return self.scene.name

    @property
    def table(self) -> dict[str, Any]:
        """Its keys and values."""
        return self.scene.source

    def text(self) -> str:
        """The scenario, which needs no other file."""
        return self.scene.text()

    def changed(self, changes: dict[str, Any]) -> Scene:
        """A variant; raises ScenarioError."""
        return self.scene.changed(changes)

    def planner(self) -> Planner:
        """What plans variants, each from the one before."""
        return Planner()


@dataclass(frozen=True, slots=True)
class VariedCycle:
    """A cycle as the base of variants; its methods are those of `VariedMotion`."""

    cycle: Cycle

    figures = CYCLE_FIGURES

    @property
    def name(self) -> str:
        """Of the scenario."""
        return self.cycle.name

    @property
    def table(self) -> dict[str, Any]:
        """Its keys and values."""
        return tomllib.loads(self.cycle.text)

    def text(self) -> str:
        """The scenario, which needs no other file."""
        return self.cycle.text

    def changed(self, changes: dict[str, Any]) -> Cycle:
        """A variant; raises ScenarioError."""
        return changed_cycle(self.cycle, changes)

    def planner(self) -> CyclePlanner:
        """What plans variants, each from the one before."""
        return CyclePlanner()


Varied = VariedMotion | VariedCycle
Source = Varied | Scene | Cycle | ScenarioSource
"""What may be varied, or names it."""


def varied(source: Source, *, settings: Sequence[str] = ()) -> Varied:
    """The base of variants from what `load` or `load_cycle` takes, or from what they return.

    Args:
        source: it.
        settings: values to replace in what is read, each as "motion.tilt=free".

    Raises:
        ScenarioError: it cannot be read.
    """
    if isinstance(source, VariedMotion | VariedCycle):
        return source
    if isinstance(source, Scene):
        return VariedMotion(source.require_as_read())
    if isinstance(source, Cycle):
        return VariedCycle(source)
    if has_legs(source):
        return VariedCycle(load_cycle(source, settings=settings))
    return VariedMotion(load(source, settings=settings))


def varied_from_text(text: str, name: str) -> Varied:
    """The base of variants from the text of a scenario that needs no other file; raises ScenarioError."""
    table = tomllib.loads(text)
    if table.get("leg"):
        return VariedCycle(cycle_from_table(table, name=name, label=name))
    return VariedMotion(scene_from_table(table, name=name))


def planned(planner: Planner | CyclePlanner, variant: Scene | Cycle) -> Plan | CyclePlan:
    """The plan of a variant by the planner of its base; raises what `plan` and `plan_cycle` do."""
    if isinstance(planner, CyclePlanner):
        assert isinstance(variant, Cycle)  # of the same base
        return planner.plan(variant)
    assert isinstance(variant, Scene)
    return planner.plan(variant)


def finding(plan: Plan | CyclePlan) -> str:
    """What the verdict rests on, in one phrase."""
    return plan.certificate.finding if isinstance(plan, CyclePlan) else describe(plan.certificate.worst)


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
        figures |= {"wait_s": plan.wait, "cycles_per_hour": plan.cycles_per_hour, "moves_per_hour": plan.moves_per_hour}
    return {name: float(value) for name, value in figures.items()}


def require_no_own_limits(base: Varied) -> None:
    """Refuse limits that are given from Python, whose classes do not reach other processes; raises ScenarioError."""
    scene = base.scene if isinstance(base, VariedMotion) else None
    given = [item.name for item in (*scene.constraints, *scene.unjudged)] if scene else []
    if given:
        raise ScenarioError(
            f'{base.name}: the constraint "{given[0]}" is given from Python, and a sweep plans in other processes, '
            "which do not have its class; loop over scene.changed(...) with ns.Planner(constraints=[...]) instead"
        )


def _worst(plan: Plan | CyclePlan) -> tuple[str, Row]:
    return plan.certificate.worst if isinstance(plan, CyclePlan) else ("", plan.certificate.worst)
