"""A layout that was found, with what was tried on the way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from nospill.plans.plan import Plan


@dataclass(frozen=True, slots=True)
class Trial:
    """Values that were planned.

    Attributes:
        values: key of the scenario -> value, SI.
        start: from which of the starts the search came there; 0 is the scenario as stated.
        duration: of the certified motion, s; None where there is none.
        why_not: why there is none, one sentence; empty where there is one.
    """

    values: Mapping[str, Any]
    start: int
    duration: float | None
    why_not: str


@dataclass(frozen=True, slots=True)
class Layout:
    """The best layout that was found.

    Attributes:
        before: the plan of the scenario as stated; None where it has no certified motion.
        plan: that of the best layout, certified; its scene is the layout.
        values: key of the scenario -> value in it, SI.
        tried: every layout that was planned, in their order.
        stuck: key -> why it could not be moved either way from a layout, one sentence: steps from there leave it.
    """

    before: Plan | None
    plan: Plan
    values: Mapping[str, Any]
    tried: tuple[Trial, ...]
    stuck: Mapping[str, str] = field(default_factory=dict)

    @property
    def gained(self) -> float | None:
        """Seconds that the motion is shorter than as stated; None where that had none."""
        return None if self.before is None else self.before.duration - self.plan.duration

    @property
    def text(self) -> str:
        """The answer in one sentence."""
        found = f"best layout of {len(self.tried)} planned: {self.plan.duration:.3f} s, certified"
        if self.before is None or self.gained is None:
            return f"{found}; as stated there is no certified motion"
        if not self.values:
            return f"{found}; none is shorter than as stated"
        return (
            f"{found}, {self.gained / self.before.duration:.1%} shorter than as stated ({self.before.duration:.3f} s)"
        )
