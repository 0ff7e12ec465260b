"""What the next problem holds after a motion was judged: the active set that follows from one and its verdict.

Reactions have an order, and a round does the first that applies alone: with other modes, other weights or other members
it is another problem, of whose back-off the motion before says little.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from nospill.certification.certificate import Judgement
from nospill.certification.verdict import Row
from nospill.laws.constraints import END_NAMES
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.clearance import Clearance
from nospill.laws.constraints.joint_position import JointPosition
from nospill.planning.active_set import ActiveSet
from nospill.planning.driven_waves import (
    beyond_backoff_of_flow,
    is_nearly_kept,
    most_left,
    relaxed_by_flow,
    smooth_enough,
    steadier_backoff,
)
from nospill.planning.row_backoff import (
    crests_of,
    growths_by_order,
    relaxed_by_order,
    tightened,
    uses_of,
    without_ease,
)
from nospill.planning.second_order import by_modes, taken_by_order
from nospill.planning.smoothness import FLOW, OTHER_MODES, SECOND_ORDER
from nospill.planning.tightening import ROUGH, beyond_backoff, is_stuck, relaxed_backoff, shared_backoff
from nospill.planning.tracking_margins import (
    falling,
    half_way,
    joining,
    lowered_at_end,
    margins_over,
    of_members,
    raised_backoff,
    rings_far,
    rougher,
    smoother,
    uses_over,
)
from nospill.planning.wave_margins import margins_of_waves
from nospill.transcription.margins_along import Margin
from nospill.transcription.problem import EASED

_SLIGHT = 5e-3
"""Part of a limit by which what is not in the problem may exceed it before it joins: a larger problem costs more."""
_SLIGHT_OF_REFINED = 0.5
"""The same once liquids are in it with several modes, where a variant more costs as much as three."""
_OF_LAW = 5e-3
"""Part of its limit by which the linear part of a height may exceed what a problem leaves to it before modes join."""
_FAR = 0.05
"""Part of a limit; a motion that is over one by more as planned is made for the arm as stated first."""
_MOST_MODES = 6
"""Most modes of a liquid in a problem."""
_SLIGHTLY_OVER = 0.02
"""Part of a limit on what the flow leaves up to which back-off or heavier jerks soon do, whatever the last ones did."""
_TO_SPARE = 0.05
"""Back-off of a crest that is worth a round for itself."""
_LEFT_BY_FLOW, _LIGHTER_BY_FLOW = 0.9, 0.7
"""Use by the flow that lighter jerks are to lead to, and the part of their weights that they have to promise."""
_LIGHTER = 0.85
"""Part of the weights of the jerks that a motion that holds over a band of late arms has to promise for more solves."""


def next_set(active: ActiveSet, judgement: Judgement, slack: Mapping[RowId, float] = MappingProxyType({})) -> ActiveSet:
    """What the next problem has to hold after a motion was judged; the same set where there is nothing to act on.

    Where the joints may be late, what the rows are to keep for that too, beside what follows from the motion as
    planned.

    Args:
        active: of the problem whose answer was judged.
        judgement: the verdict on that.
        slack: of the problem's rows, what is left of their limits, as parts of them.
    """
    following, band = _after_stated(active, judgement, slack), judgement.band
    if band is None or (max(band.use.values(), default=0.0) <= 1.0 and following is active):
        return following
    names, first, rings = following.names, not active.margins, active.rings
    planned, uses = uses_of(judgement.planned_rows), uses_over(band, names)
    lowered: dict[RowId, float] = {}
    if not (first or rings):
        of_stated = uses_of(active.on_members(judgement.planned_rows))
        lowered = lowered_at_end(active.backoff, band, of_stated, active.names)
    left = {row: use for row, use in band.use.items() if lowered.keys().isdisjoint(of_members(row, names))}
    smooth = smoother(active.smoothness, left, planned, rings=rings, margins=not first)
    if not rings:
        following = following.as_smooth_as(smooth)
    if following.scene is not active.scene or (first and _far_over(judgement)):
        return following  # what the arm does as it is stated comes first
    if rings:
        following = following.as_smooth_as(smooth)
        if rings_far(band, active.smoothness):
            return following
    growths, stilled = _growths(active, judgement), active.smoothness.stilled
    backoff = following.backoff if first else raised_backoff(following.backoff, band, names, growths)
    if not stilled:  # there crests are what is nearest to its limit: what one gets back it would ask for again
        backoff = {**backoff, **relaxed_by_order(active.on_members(judgement.planned_rows), backoff, uses)}
    backoff = {**backoff, **{row: max(value, backoff[row]) for row, value in lowered.items()}}
    found = margins_over(band, names, judgement.end_time, backoff, growths)
    margins = half_way(found, active.margins) if rings else falling(found, active.margins, uses if stilled else {})
    rows = following.rows | (joining(band, names) & following.possible)
    return replace(following, rows=rows, margins=margins, backoff=backoff)


def relax(active: ActiveSet, judgement: Judgement) -> ActiveSet:
    """The set without most of the back-off that a certified motion shows to be more than is needed."""
    if active.smoothness.factor <= 1.0:  # of smoother motions crests say little of what is left
        return relax_within_flow(active, judgement)
    return replace(active, backoff=_relaxed(active, judgement))


def relax_within_flow(active: ActiveSet, judgement: Judgement) -> ActiveSet:
    """`relax`, with crests no higher than what the flow leaves allows: else jerks soon weigh more, and all was in vain.

    What that forgoes is a percent or two, what it saves in a loop half of the time.
    """
    own = active.on_members(active.judged_rows(judgement), own=True)
    relaxed = relaxed_by_flow(_relaxed(active, judgement), own, active.driven, active.backoff)
    return replace(active, backoff=relaxed)


def lighten_by_flow(active: ActiveSet, judgement: Judgement) -> ActiveSet:
    """The set with jerks that weigh less, after a motion of which the flow leaves far less than a limit allows.

    The same set where that promises little, where the duration is given, or where jerks weigh more for late arms or
    lower speeds too.
    """
    left = most_left(active.on_members(active.judged_rows(judgement), own=True), active.driven)
    motion = active.task.scene.motion
    if not left or motion.duration is not None or judgement.band is not None or motion.speeds:
        return active
    light = active.smoothness.lighter(FLOW, left / _LEFT_BY_FLOW)
    return replace(active, smoothness=light) if light.factor < _LIGHTER_BY_FLOW * active.smoothness.factor else active


def lighten(active: ActiveSet, judgement: Judgement) -> ActiveSet:
    """The set with jerks that weigh less, after a motion that holds; the same where they are not known to weigh much.

    With the margins that a motion over a band of arms needs, and of crests of second order what it does not.
    """
    if active.margins and judgement.band is not None:
        growths = _growths(active, judgement)
        margins = margins_over(judgement.band, active.names, judgement.end_time, active.backoff, growths)
        if active.smoothness.stilled:
            margins = half_way(margins, active.margins)
        light = rougher(active.smoothness, judgement.band.use, rings=active.rings)
        before = active.smoothness.factor
        worth = active.rings or before == 1.0 or light.factor < _LIGHTER * before
        return replace(active, margins=margins, smoothness=light) if worth else active
    if active.task.smooth_first:
        return active.with_driven(judgement)
    own = list(active.on_members(active.judged_rows(judgement)))
    light = active.smoothness.lighter(SECOND_ORDER, taken_by_order(own))
    if light.factor == active.smoothness.factor:
        return active
    return replace(active, smoothness=light, backoff={**active.backoff, **relaxed_by_order(own, active.backoff)})


def _relaxed(active: ActiveSet, judgement: Judgement) -> dict[RowId, float]:
    """Back-off without most of what a certified motion shows to be more than is needed."""
    own, band = list(active.on_members(active.judged_rows(judgement), own=True)), judgement.band
    over = {} if band is None else uses_over(band, active.names)
    uses = uses_of(row for row in own if row.linear_value is None)
    relaxed = relaxed_backoff(active.backoff, {row: max(use, over.get(row, 0.0)) for row, use in uses.items()})
    return {**relaxed, **relaxed_by_order(own, active.backoff, over)}


def _after_stated(active: ActiveSet, judgement: Judgement, slack: Mapping[RowId, float]) -> ActiveSet:
    """`next_set` for the arm as it is stated.

    Modes join first, of the liquids that break a limit, and objects without members; where modes that are left out
    swing too far at the end, or waves of second order do, the jerks weigh more. Then members join, the worst of
    `missing`. Where there is none, violated rows join, those in the problem get a larger back-off, and `far_peaks`
    join, which that does not reach.
    """
    found = [row for row in active.judged_rows(judgement) if row.constraint not in active.task.ignored]
    if active.task.smooth_first and active.refined and smooth_enough(found, active.task.may_be_driven):
        return active.with_driven(judgement)
    rows = [by_modes(row) for row in found]
    smooth, uses = active.smoothed(found), uses_of(active.on_members(rows, own=True))
    at_end = {row: use for row, use in uses.items() if row.constraint in END_NAMES and row not in active.by_flow}
    slowed = active.membership.slowest < 1.0  # of many speeds the worst is now one, now another: none is stuck
    over = beyond_backoff(at_end, active.backoff, 0.0 if slowed else active.excess) if active.refined else 0.0
    return (
        _with_modes(active, rows, judgement)
        or _with_more_modes(active, over, judgement)
        or _with_heavier_jerks(active, smooth.as_smooth_as(active.smoothness.heavier(OTHER_MODES, over)), rows)
        or _with_members(active, rows, judgement)
        or _tightened(active, smooth, rows, uses, judgement, slack)
    )


def _with_modes(active: ActiveSet, rows: Sequence[Row], judgement: Judgement) -> ActiveSet | None:
    """With several modes of the liquids that break a limit; none where all of those have them."""
    refined = active.refined | _too_coarse(active, rows)
    if refined == active.refined:
        return None
    alone = active.outside(rows, np.inf, judgement)
    return active.joined(active.members | alone, refined.union(name for name, _ in alone), judgement)


def _with_more_modes(active: ActiveSet, over: float, judgement: Judgement) -> ActiveSet | None:
    """With twice the modes, where those left out swing a little too far at the end; else none.

    None where liquids are slowed: of dozens of members that makes a problem twice as large for one of them.
    """
    modes = min(2 * active.modes, _MOST_MODES, active.task.scene.slosh_modes)
    if not (1.0 < over <= ROUGH and modes > active.modes) or active.membership.slowest < 1.0:
        return None
    kept = {row: value for row, value in active.backoff.items() if row not in active.on_final_state}
    return replace(active, modes=modes, backoff=kept).joined(active.members, active.refined, judgement)


def _with_heavier_jerks(active: ActiveSet, smooth: ActiveSet, rows: Sequence[Row]) -> ActiveSet | None:
    """With jerks that weigh more, by what the flow leaves or as `smooth` has them; none where they weigh the same.

    Crests get back-off back before that, where they have any to spare and the flow leaves little too much.
    """
    left = beyond_backoff_of_flow(active.on_members(rows), active.driven, active.backoff)
    by_flow = active.smoothness.heavier(FLOW, left)
    if by_flow.factor > smooth.smoothness.factor:
        spare = _to_spare(active, rows, left - 1.0) if is_nearly_kept(left) else {}
        if spare:
            return replace(active, backoff={**active.backoff, **spare})
        raised = steadier_backoff(active.on_members(rows), active.driven, active.backoff)
        return replace(active, smoothness=by_flow, backoff=raised)
    return None if smooth.smoothness is active.smoothness else smooth


def _with_members(active: ActiveSet, rows: Sequence[Row], judgement: Judgement) -> ActiveSet | None:
    """With the worst variants that are not in the problem; none where these keep their limits."""
    refined = active.refined
    outside = active.outside(rows, 1.0 + (_SLIGHT_OF_REFINED if refined else _SLIGHT), judgement)
    if not outside:
        return None
    return active.joined(active.members | outside, refined | {name for name, _ in outside if refined}, judgement)


def _tightened(
    active: ActiveSet,
    smooth: ActiveSet,
    rows: Sequence[Row],
    uses: Mapping[RowId, float],
    judgement: Judgement,
    slack: Mapping[RowId, float],
) -> ActiveSet:
    """With violated rows and a larger back-off of those in the problem; the same set where none is violated."""
    broken = _within_ranges(active, list(active.on_members(row for row in rows if row.shortfall > 0.0)))
    margins = _of_waves(active, judgement)
    crests = [row for row in broken if row.id in margins]
    broken = [row for row in broken if row.id not in margins]
    backoff, joins = tightened(broken, active.rows, smooth.backoff, slack, active.crests)
    if active.scene.initial_state is not None:
        backoff = without_ease(broken, backoff, active.backoff, EASED * judgement.end_time)
    far = active.membership.far_peaks(rows, judgement.replay.t)
    if far:
        return replace(active, backoff=backoff).joined(active.members | far, active.refined, judgement)
    excess = max((use for row, use in uses.items() if row.constraint in END_NAMES), default=1.0) - 1.0
    spare = _to_spare(active, rows, excess) if is_stuck(excess, active.excess) else {}
    backoff = {**shared_backoff(backoff, active.backoff, uses), **spare}
    if not joins and not crests and backoff == active.backoff:
        return active
    # bodies that touch in spite of their planes have none where they do: more back-off would move nothing
    touching = {row.id for row in broken if row.worst_margin < 0.0} & active.rows & active.task.around_solids
    return replace(
        active,
        rows=smooth.rows | joins | {row.id for row in crests},
        backoff=backoff,
        margins={**active.margins, **margins} if crests else active.margins,
        excess=excess,
        crests=crests_of(broken, active.backoff),
        everywhere=active.everywhere | touching,
    )


def _to_spare(active: ActiveSet, rows: Sequence[Row], over: float) -> dict[RowId, float]:
    """Less back-off of crests that are far below their limits, where the flow alone leaves too much; else none.

    The crests of a coarse motion are higher, and what they are kept from makes a motion slower, not smoother.

    Args:
        active: of the problem whose answer was judged.
        rows: as judged.
        over: part of its limit by which the flow leaves more than that.
    """
    if over <= _SLIGHTLY_OVER:
        return {}
    own = list(active.on_members(rows, own=True))
    if not active.by_flow.issuperset(row.id for row in own if row.shortfall > 0.0):
        return {}
    found = relaxed_by_order(own, active.backoff)
    return found if any(active.backoff[row] - value > _TO_SPARE for row, value in found.items()) else {}


def _far_over(judgement: Judgement) -> bool:
    """Whether a motion breaks limits as planned by more than back-off takes away."""
    return any(row.use > 1.0 + _FAR for row in judgement.variant_rows)


def _of_waves(active: ActiveSet, judgement: Judgement) -> dict[RowId, Margin]:
    """What heights keep along a motion that goes on from a state for what the second order adds; else none."""
    if active.scene.initial_state is None:
        return {}
    return margins_of_waves(active.backoff, active.margins, judgement, active.labels_of)[0]


def _growths(active: ActiveSet, judgement: Judgement) -> dict[RowId, float]:
    """Of the heights of second order how much more they fall than their linear parts, which the problem has."""
    return growths_by_order(active.on_members(judgement.planned_rows))


def _within_ranges(active: ActiveSet, broken: list[Row]) -> list[Row]:
    """Broken rows without the distances that are not in the problem, while a joint leaves its range.

    What bodies touch there is no matter of a motion within the ranges, and no plane parts bodies that start far inside
    each other.
    """
    if all(row.constraint != JointPosition.name or row.id in active.rows for row in broken):
        return broken
    return [row for row in broken if row.constraint != Clearance.name or row.id in active.rows]


def _too_coarse(active: ActiveSet, rows: Iterable[Row]) -> frozenset[str]:
    """Members whose liquid breaks a limit, where the optimiser may carry more than one mode.

    Of a height of second order its linear part counts, and what of its limit the problem left to that.
    """
    broken = {row.subject for row in rows if row.of_liquid and _is_over_law(active, row)}
    return frozenset(name for name, _ in active.members if name in broken and active.task.scene.planned_modes > 1)


def _is_over_law(active: ActiveSet, row: Row) -> bool:
    """Whether a liquid breaks a limit by more than what the optimiser's law leaves out."""
    if row.linear_value is None or row.shortfall <= 0.0:
        return row.shortfall > 0.0
    names = [label for (name, _), label in active.names.items() if name == row.subject]
    kept = max((active.backoff.get(RowId(row.constraint, label), 0.0) for label in names), default=0.0)
    return row.linear_value > (1.0 + _OF_LAW - kept) * row.limit
