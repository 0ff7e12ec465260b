"""How long it takes at most until a plan stands: stops from few instants, and from more where these are too far apart.

A stop that begins at an instant serves every moment before it too, for which the plan goes on until then: what counts
is that wait and the stop together. So instants far apart are looked at first; between two of them one is put only
where the wait is what takes too long, and none where the stop alone does.
"""

from __future__ import annotations

import math

from nospill.plans.plan import Plan
from nospill.plans.state import states_of
from nospill.plans.stops import Stop
from nospill.stopping.later import sooner_by_waiting
from nospill.stopping.own_way import along_own_way
from nospill.stopping.solving import Found, joint_path_of, stop_from
from nospill.stopping.stops import require_stoppable

_STRIDE = 4
"""Steps between the instants that are looked at first."""


def longest_stop(plan: Plan, every: float, within: float) -> tuple[float, float]:
    """The longest time from any moment of a plan until the arm stands, s, and the instant at which that stop begins, s.

    Where it is above the time asked for, it is that of the instants that were looked at, and may be exceeded by others.

    Args:
        plan: certified.
        every: s, least time between two instants at which stops begin.
        within: s; what is left of the plan then is always a stop that takes no longer.

    Raises:
        ScenarioError: as `stops`.
        NoSolutionError: likewise.
    """
    require_stoppable(plan)
    last = math.ceil((plan.duration - within) / every - 1e-9)
    if last < 1:
        return plan.duration, 0.0
    own_way = along_own_way(plan, every)
    joint_path = joint_path_of(own_way)
    chosen = set(range(last, 0, -_STRIDE))
    own: dict[int, Stop] = {}
    found: dict[int, Found] = {}
    while True:
        for index in sorted(chosen - own.keys()):
            (state,) = states_of(own_way.trajectory, own_way.scene, [index * every])
            before = found.get(max((known for known in found if known < index), default=0))
            own[index], solved = stop_from(own_way, state, joint_path, before, afresh_above=within - every)
            if solved is not None:
                found[index] = solved
        stops = _waiting(own_way, own)
        slowest = max(stops.values(), key=lambda stop: stop.duration)
        if slowest.duration + every > within and slowest.t < plan.duration - within - 1e-9:
            return slowest.duration + every, slowest.t
        gaps = list(zip([0, *sorted(stops)], sorted(stops), strict=False))
        late = [(a, b) for a, b in gaps if (b - a) * every + stops[b].duration > within + 1e-9]
        if not late or any(b - a == 1 for a, b in late):
            a, b = max(late or gaps, key=lambda gap: (gap[1] - gap[0]) * every + stops[gap[1]].duration)
            return (b - a) * every + stops[b].duration, stops[b].t
        chosen = {(a + b) // 2 for a, b in late}


def _waiting(plan: Plan, own: dict[int, Stop]) -> dict[int, Stop]:
    """The stops, where it is sooner those of the next instant with what leads there."""
    stops, following = dict(own), None
    for index in sorted(own, reverse=True):
        if following is not None:
            (state,) = states_of(plan.trajectory, plan.scene, [own[index].t])
            stops[index] = sooner_by_waiting(plan, state, own[index], following, 1.0)
        following = stops[index]
    return stops
