"""Warning about a motion that no limit holds back, since a stated weight of the jerk does."""

from __future__ import annotations

from collections.abc import Iterator

from nospill.plans.warnings.record import Facts, PlanWarning

LEAST_USE_AT_A_LIMIT = 0.97
"""Of a limit; what is kept from the optimiser and from the judge's resolution leaves a limit that holds at most 3 %."""


def smoothness(facts: Facts) -> Iterator[PlanWarning]:
    """No limit is reached, and the scenario states a weight."""
    planning = facts.scene.planning
    weights = {"path_jerk_weight": planning.path_jerk_weight, "tilt_jerk_weight": planning.tilt_jerk_weight}
    stated = [f"{key} = {value:g}" for key, value in weights.items() if value]
    if not stated:
        return
    use, trace = max(((float(trace.use.max()), trace) for trace in facts.judgement.traces), key=lambda pair: pair[0])
    if use < LEAST_USE_AT_A_LIMIT:
        text = (
            f"no limit is reached ({trace.constraint} of {trace.subject} comes nearest, {100 * use:.0f} %): "
            f"{' and '.join(stated)} decide how long the motion takes; leave them out for the shortest."
        )
        yield PlanWarning("smoothness", "motion", text, use, LEAST_USE_AT_A_LIMIT)
