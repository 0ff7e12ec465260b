"""An earlier motion as the start for a scene with other limits: how far it breaks them, and how to mend it."""

from __future__ import annotations

from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.transcription.nlp import Backoff
from nospill.transcription.problem import Problem
from nospill.transcription.solvers import row_slack
from nospill.transcription.stages import Stages
from nospill.transcription.time_scaling import slowed

_SLOWEST = 1.5
_BISECTIONS = 6
_BROKEN = 0.2
_BROKEN_HEIGHT = 0.05


def with_restart_reserves(reserves: Backoff) -> dict[tuple[str, int], float]:
    """The reserves with at least each constraint's `restart_backoff`."""
    return {key: max(value, BY_NAME[key[0]].restart_backoff) for key, value in reserves.items()}


def is_broken(problem: Problem, motion: Stages) -> bool:
    """Whether a motion breaks rows of a problem so far that the multipliers of its own problem are no help.

    The height of a liquid follows from all of the motion before, the rest from the instant: it is harder to mend.
    """
    slack = row_slack(problem, motion)
    return any(value < -(_BROKEN_HEIGHT if key[0] == SloshHeight.name else _BROKEN) for key, value in slack.items())


def slow_enough(problem: Problem, motion: Stages) -> Stages:
    """The motion slowed down as little as keeps the rows of the problem; itself if slowing down does not help.

    From a motion that breaks many rows, the first dozen steps of an interior point method each end at the next bound.

    Args:
        problem: whose rows; how it is scaled does not matter.
        motion: on its grid.
    """

    def keeps(factor: float) -> bool:
        slow = slowed(motion, layout, factor)
        return min(row_slack(problem, slow).values(), default=0.0) >= 0.0

    layout = problem.transcription.layout
    low, high = 1.0, _SLOWEST
    if not keeps(high):
        return motion
    for _ in range(_BISECTIONS):
        middle = (low * high) ** 0.5
        low, high = (low, middle) if keeps(middle) else (middle, high)
    return slowed(motion, layout, high)
