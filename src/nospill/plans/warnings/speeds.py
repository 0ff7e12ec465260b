"""Warning about a motion that breaks a limit when it is played more slowly."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from nospill.certification.other_speeds import SpeedUse
from nospill.certification.wording import percent
from nospill.plans.warnings.record import PlanWarning


def other_speeds(uses: Sequence[SpeedUse], speed_range: tuple[float, float] | None = None) -> Iterator[PlanWarning]:
    """At a lower speed something spills, slides or tips; or nothing does, and liquids swing higher than is wished.

    Args:
        uses: at the speeds that were looked at.
        speed_range: where a certificate holds, None without one.
    """
    unsafe, wished = [item for item in uses if not item.safe], [item for item in uses if item.liquid > 1.0]
    if unsafe:
        worst = max(unsafe, key=_danger)
        text = (
            f"at {100 * worst.speed:.0f} % of the speed {_what_happens(worst)}, and {len(unsafe)} of {len(uses)} lower "
            f"speeds are unsafe; {_advice(speed_range)}."
        )
        yield PlanWarning("other speeds", "motion", text, _danger(worst), 1.0)
    elif wished:
        worst = max(wished, key=lambda item: item.liquid)
        constraint, _, subject = worst.worst.partition(" | ")
        swing = max(uses, key=lambda item: item.rim_use)
        rim = f", {_mm(swing.below_rim)} below the rim" if swing.below_rim is not None else ""
        text = (
            f"at all {len(uses)} lower speeds that were looked at nothing spills, slides or tips; liquids swing on, at "
            f"most {_mm(swing.height)}{rim}: at {100 * worst.speed:.0f} % of the speed {constraint} of {subject} is "
            f"{percent(worst.liquid, ok=False)} of the stated limit; where that matters, {_advice(speed_range)}."
        )
        yield PlanWarning("other speeds", "motion", text, worst.liquid, 1.0)


def _danger(item: SpeedUse) -> float:
    """Largest use of what is safety: contacts, and the way to the rim."""
    return max(item.contact, item.rim_use)


def _what_happens(item: SpeedUse) -> str:
    if item.spills and item.rim_use >= item.contact:
        return f"a liquid rises {_mm(-(item.below_rim or 0.0))} over its rim"
    constraint, _, subject = (item.worst_contact or item.worst).partition(" | ")
    return f"{constraint} of {subject} uses {percent(item.contact, ok=False)} of its limit"


def _mm(length: float) -> str:
    return f"{1e3 * length:.1f} mm"


def _advice(speed_range: tuple[float, float] | None) -> str:
    if speed_range is None:
        return "run it at full speed only, state motion.speed_range, or make a slower motion with nospill slow"
    least, greatest = speed_range
    return f"keep the speed between {100 * least:.4g} and {100 * greatest:.4g} %, which is certified"
