"""How long it takes at most until a plan stands: stops from few instants, and from more where these are too far apart.

A stop that begins at an instant serves every moment before it too, for which the plan goes on until then: what counts
is that wait and the stop together. So instants far apart are looked at first, and then, from the longest wait on, the
earliest one between that can close it. An instant from which no short stop is found is passed over: the search may
fail where 20 ms before or after it does not.
"""

from __future__ import annotations

import math

import numpy as np

from nospill.plans.plan import Plan
from nospill.plans.stops import Stop
from nospill.stopping.own_way import along_own_way
from nospill.stopping.solving import Found, joint_path_of, stop_from
from nospill.stopping.splices import states_with_leads
from nospill.stopping.stops import require_stoppable

_STRIDE = 4
"""Steps between the instants that are looked at first."""
_HOPELESS = 0.6
"""Part of the instants from which stops are short; with less the plan is given up."""


def longest_stop(plan: Plan, every: float, within: float) -> tuple[float, float]:
    """The longest time from any moment of a plan until the arm stands, s, and the instant at which that stop begins, s.

    Where it is above the time asked for, it is that of the instants that were looked at: others may close the wait.

    Args:
        plan: certified.
        every: s, least time between two instants at which stops begin.
        within: s; what is left of the plan then is always a stop that takes no longer.

    Raises:
        ScenarioError: as `stops`.
        NoSolutionError: likewise.
    """
    require_stoppable(plan)
    if plan.duration <= within:
        return plan.duration, 0.0
    last = math.ceil((plan.duration - within) / every - 1e-9) + 1  # what is left from there is short enough
    after = [
        index for index in range(last + _STRIDE, last + 3 * _STRIDE, _STRIDE) if index * every < plan.duration - 0.1
    ]
    own_way = along_own_way(plan, every)
    joint_path = joint_path_of(own_way)
    chosen = [*reversed(range(last, 0, -_STRIDE)), *after]
    own: dict[int, Stop] = {}
    found: dict[int, Found] = {}
    while True:
        for index in chosen:
            (state,), (lead,) = states_with_leads(own_way, np.array([index * every]))
            before = found[min(found, key=lambda known: abs(known - index))] if found else None
            own[index], solved = stop_from(own_way, state, joint_path, before, afresh_above=within - every, lead=lead)
            if solved is not None:
                found[index] = solved
        good = sorted(index for index, stop in own.items() if stop.duration <= within - every + 1e-9)
        begun = [0, *(index for index in good if index < last - 1)]
        waits = (min(((b - a) * every + own[b].duration, b) for b in good if b > a) for a in begun)
        worst, b = max(waits)
        reach = math.floor((within - own[b].duration) / every + 1e-9)
        chosen = [index for index in range(b - reach, b) if index > 0 and index not in own][:1]
        if worst <= within + 1e-9 or not chosen or len(good) < _HOPELESS * len(own):
            return worst, own[b].t
