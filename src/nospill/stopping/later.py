"""A stop that begins a little later: the plan goes on to the next instant, and the stop from there follows.

Where a plan stands on a limit, a problem with back-off may have no solution, or only a slow one, 20 ms before or after
an instant at which it has a good one. The way there is the plan's own; the whole is judged as one motion.
"""

from __future__ import annotations

from dataclasses import replace

from nospill.certification.wording import describe
from nospill.plans.plan import Plan
from nospill.plans.state import MotionState
from nospill.plans.stops import Stop
from nospill.stopping.solving import splice_at, stopping_scene
from nospill.stopping.splices import joined_record
from nospill.stopping.verdicts import judged_stop, swinging_on

_WORTH = 2e-3
"""s; by so much it has to be sooner."""


def sooner_by_waiting(
    plan: Plan, state: MotionState, lead: MotionState, own: Stop, following: Stop, residual: float
) -> Stop:
    """The stop of the next instant with what leads there, where it stands sooner than a state's own; else that one.

    Args:
        plan: certified.
        state: of the plan.
        lead: `splices.BEFORE` samples earlier.
        own: the stop from it.
        following: the stop from a later instant, certified as after `stopping_scene`.
        residual: how high liquids may swing on, over max_slosh_height.
    """
    if following.origin == "rest of the plan" or following.t - own.t + following.duration > own.duration - _WORTH:
        return own
    record = joined_record(state.rest, following.trajectory, following.t - own.t)
    scene = swinging_on(stopping_scene(plan.scene, state, residual))
    verdict = judged_stop(record, scene, splice_at(plan, state, lead, residual))
    if verdict is None or not verdict.ok or not verdict.stays:
        return own
    return replace(
        own,
        duration=verdict.record.end_time,
        end=following.end,
        origin="later",
        nearest=describe(verdict.judgement.certificate.worst),
        trajectory=verdict.record,
        doubted=verdict.doubted,
    )
