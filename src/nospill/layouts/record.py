"""A layout that was found, with what was tried on the way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from nospill.plans.cycle import CyclePlan
from nospill.plans.plan import Plan


@dataclass(frozen=True, slots=True)
class Trial:
    """Values that were planned.

    Attributes:
        values: key of the scenario -> value, SI.
        start: from which of the starts the search came there; 0 is the scenario as stated.
        duration: of the certified motion, s; None where there is none.
        why_not: why there is none, one sentence; empty where there is one.
        reserve: part of the limits on liquids and contacts that it keeps back, where the largest margin is sought.
    """

    values: Mapping[str, Any]
    start: int
    duration: float | None
    why_not: str
    reserve: float | None = None


@dataclass(frozen=True, slots=True)
class Layout:
    """The best layout that was found.

    Attributes:
        before: the plan of the scenario as stated, with its own largest margin where that is sought; None where it has
            no certified motion, or none within the time.
        plan: that of the best layout, certified; its scene (of a cycle its cycle) is the layout.
        values: key of the scenario -> value in it, SI.
        tried: every layout that was planned, in their order.
        stuck: key -> why it could not be moved either way from a layout, one sentence: steps from there leave it.
        within: s, within which the largest margin was sought; None where the shortest motion was.
        margin: the part of its limits on liquids and contacts that the plan leaves at least, where that is sought.
        margin_before: the same of the scenario as stated.
    """

    before: Plan | CyclePlan | None
    plan: Plan | CyclePlan
    values: Mapping[str, Any]
    tried: tuple[Trial, ...]
    stuck: Mapping[str, str] = field(default_factory=dict)
    within: float | None = None
    margin: float | None = None
    margin_before: float | None = None

    @property
    def gained(self) -> float | None:
        """Seconds that the motion is shorter than as stated; None where that had none."""
        return None if self.before is None else self.before.duration - self.plan.duration

    @property
    def text(self) -> str:
        """The answer in one sentence."""
        least = "" if self.within is None or self.margin is None else f"margin {self.margin:.1%} in "
        found = f"best layout of {len(self.tried)} planned: {least}{self.plan.duration:.3f} s, certified"
        if self.before is None or self.gained is None:
            return f"{found}; as stated there is no certified motion{'' if self.within is None else ' within the time'}"
        if self.within is not None:
            if not self.values or self.margin_before is None:
                return f"{found}; none leaves more than as stated"
            return f"{found}; {self.margin_before:.1%} as stated"
        if not self.values:
            return f"{found}; none is shorter than as stated"
        return (
            f"{found}, {self.gained / self.before.duration:.1%} shorter than as stated ({self.before.duration:.3f} s)"
        )
