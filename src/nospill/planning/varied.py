"""What is varied: a motion or a cycle of several, each read, changed and planned the same way."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from nospill.certification.wording import describe
from nospill.core.units import as_written, quantity
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


@dataclass(frozen=True, slots=True)
class Varied:
    """The base of variants.

    Attributes:
        task: a motion or a cycle.
    """

    task: Scene | Cycle

    @property
    def name(self) -> str:
        """Of the scenario."""
        return self.task.name

    @property
    def is_cycle(self) -> bool:
        """Whether it is a cycle."""
        return isinstance(self.task, Cycle)

    @property
    def scenes(self) -> tuple[Scene, ...]:
        """Of every leg, or of the one motion."""
        return tuple(leg.scene for leg in self.task.legs) if isinstance(self.task, Cycle) else (self.task,)

    @property
    def table(self) -> dict[str, Any]:
        """Its keys and values."""
        return tomllib.loads(self.task.text) if isinstance(self.task, Cycle) else self.task.source

    def text(self) -> str:
        """The scenario, which needs no other file."""
        return self.task.text if isinstance(self.task, Cycle) else self.task.text()

    def changed(self, changes: dict[str, Any]) -> Scene | Cycle:
        """A variant; raises ScenarioError."""
        return changed_cycle(self.task, changes) if isinstance(self.task, Cycle) else self.task.changed(changes)

    def planner(self) -> Planner | CyclePlanner:
        """What plans variants, each from the one before."""
        return CyclePlanner() if self.is_cycle else Planner()


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
    if isinstance(source, Varied):
        return source
    if isinstance(source, Scene):
        return Varied(source.require_as_read())
    if isinstance(source, Cycle):
        return Varied(source)
    read = load_cycle if has_legs(source) else load
    return Varied(read(source, settings=settings))


def varied_from_text(text: str, name: str) -> Varied:
    """The base of variants from the text of a scenario that needs no other file; raises ScenarioError."""
    table = tomllib.loads(text)
    if table.get("leg"):
        return Varied(cycle_from_table(table, name=name, label=name))
    return Varied(scene_from_table(table, name=name))


def planned(planner: Planner | CyclePlanner, variant: Scene | Cycle) -> Plan | CyclePlan:
    """The plan of a variant by the planner of its base; raises what `plan` and `plan_cycle` do."""
    if isinstance(planner, CyclePlanner):
        assert isinstance(variant, Cycle)  # of the same base
        return planner.plan(variant)
    assert isinstance(variant, Scene)
    return planner.plan(variant)


def duration_change(planner: Planner | CyclePlanner, variant: Scene | Cycle) -> float:
    """Seconds by which the last plan would be longer of a variant, to the first order; raises ScenarioError."""
    if isinstance(planner, CyclePlanner):
        assert isinstance(variant, Cycle)
        return planner.duration_change(variant)
    assert isinstance(variant, Scene)
    return planner.duration_change(variant)


def finding(plan: Plan | CyclePlan) -> str:
    """What the verdict rests on, in one phrase."""
    return plan.certificate.finding if isinstance(plan, CyclePlan) else describe(plan.certificate.worst)


def time_within(within: float | str) -> float:
    """A stated longest duration, s.

    Args:
        within: s, or text with a unit.

    Raises:
        ScenarioError: it is no time, or not above 0.
    """
    try:
        seconds = quantity(within, "time")
    except ScenarioError as error:
        raise ScenarioError(f"within: {error}") from None
    if not (seconds > 0.0 and math.isfinite(seconds)):
        raise ScenarioError(f'within {as_written(within)} is no time for a motion; give one above 0, as "1.2 s"')
    return seconds
