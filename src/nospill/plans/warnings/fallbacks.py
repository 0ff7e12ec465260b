"""Warning about what planning took in the place of what was asked for."""

from __future__ import annotations

from collections.abc import Iterator

from nospill.plans.warnings.record import Facts, PlanWarning


def fallback(facts: Facts) -> Iterator[PlanWarning]:
    """A search failed and the next best motion was taken."""
    if facts.fallbacks:
        yield PlanWarning("fallback", "motion", f"{'; '.join(facts.fallbacks)}.")
