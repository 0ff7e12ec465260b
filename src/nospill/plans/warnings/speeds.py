"""Warning about a motion that breaks a limit when it is played more slowly."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from nospill.judge.other_speeds import SpeedUse
from nospill.plans.warnings.record import PlanWarning


def other_speeds(uses: Sequence[SpeedUse], speed_range: tuple[float, float] | None = None) -> Iterator[PlanWarning]:
    """A limit on an object is broken at a lower speed; `speed_range` is where a certificate holds, None without one."""
    broken = [item for item in uses if max(item.liquid, item.contact) > 1.0]
    if broken:
        worst = max(broken, key=lambda item: max(item.liquid, item.contact))
        use = max(worst.liquid, worst.contact)
        constraint, _, subject = worst.worst.partition(" | ")
        text = (
            f"at {100 * worst.speed:.0f} % of the speed {constraint} of {subject} uses {100 * use:.0f} % of its limit, "
            f"and {len(broken)} of {len(uses)} lower speeds break one; {_advice(speed_range)}."
        )
        yield PlanWarning("other speeds", "motion", text, use, 1.0)


def _advice(speed_range: tuple[float, float] | None) -> str:
    if speed_range is None:
        return "run it at full speed only, state motion.speed_range, or make a slower motion with nospill slow"
    least, greatest = speed_range
    return f"keep the speed between {100 * least:.4g} and {100 * greatest:.4g} %, which is certified"
