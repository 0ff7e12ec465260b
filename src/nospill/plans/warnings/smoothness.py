"""Warning about a motion that stated weights of the jerk hold back."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nospill.laws.constraints.jerk import PathJerk, TiltJerk
from nospill.plans.warnings.record import Facts, PlanWarning

LEAST_USE_AT_A_LIMIT = 0.97
"""Of a limit; what is kept from the optimiser and from the judge's resolution leaves a limit that holds at most 3 %."""

LARGEST_PART = 0.02
"""Of the duration, that the weighted jerks count as; where no weight is stated they count as some thousandths."""


def smoothness(facts: Facts) -> Iterator[PlanWarning]:
    """No limit is reached and the scenario states a weight, or the weights count as much of the duration."""
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
    elif facts.scene.fidelity == "full" and facts.scene.motion.duration is None:  # published plans have theirs
        by_name = {PathJerk.name: planning.path_jerk_weight, TiltJerk.name: planning.tilt_jerk_weight}
        jerks = [
            (by_name[trace.constraint], trace.value) for trace in facts.judgement.traces if trace.constraint in by_name
        ]
        seconds = sum((weight or 0.0) * float(np.mean(value**2)) for weight, value in jerks)
        duration = float(np.ptp(facts.judgement.replay.t))
        if seconds > LARGEST_PART * duration:
            text = (
                f"{' and '.join(stated)} count as {seconds:.3f} s, {100 * seconds / duration:.0f} % of the "
                "duration: leave them out for a shorter motion with faster jerks."
            )
            yield PlanWarning("smoothness", "motion", text, seconds / duration, LARGEST_PART)
