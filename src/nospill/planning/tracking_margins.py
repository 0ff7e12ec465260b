"""What a problem keeps back for arms that are late or ring: margins along the motion, and smoother joints.

Late joints add to a row what their jerks make of the delay, at each instant another share of the limit. So the judge's
figures of one motion are the margins of the next problem, instant by instant. What the band adds to a height at the end
no margin takes away, since it adds up over the whole motion: there the jerks weigh more, from round to round.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from nospill.certification.certificate import Judgement
from nospill.certification.tracking_band import Band
from nospill.certification.wording import describe
from nospill.errors import MOTION, NoSolutionError, Reason
from nospill.laws.constraints import END_NAMES
from nospill.laws.constraints.base import RowId
from nospill.planning.smoothness import LATE, LATE_AT_ONCE, RINGING, STILLED, Smoothness
from nospill.scene.scene import Scene
from nospill.scene.tracking import Tracking
from nospill.scene.variants import VariantId
from nospill.transcription.margins_along import Margin

_MOST, _MOST_AT_END, _MOST_IN_ALL = 0.8, 0.75, 0.92
"""Part of a budget that is kept at most: along the motion, on its final state, and there with back-off."""
_BY_MARGINS = 1.1
"""Use over a band of ringing joints up to which margins and back-off alone bring a row back."""
_RINGS_FAR = 1.4
"""Use over a band of ringing joints above which the jerks alone weigh more, as long as their weight may rise."""
_OWN, _AIM, _STEEPER, _MOST_BACKOFF = 0.5, 0.985, 1.3, 0.8
"""Of a row on the final state over a band: part of its use as planned from which back-off lowers it, the use that this
is to lead to, how much more of it than in proportion, for modes outside the problem stay, and the most."""
_JOINS = 0.9
"""Use over the band from which a row takes part."""
_MORE, _LEAST, _STEP = 1.0, 5e-4, 0.03
"""Of what a row is over its limit with its margins: part that is added to its back-off, at least, and at most."""


def margins_over(
    band: Band,
    names: Mapping[VariantId, str],
    duration: float,
    backoff: Mapping[RowId, float],
    growths: Mapping[RowId, float] = MappingProxyType({}),
) -> dict[RowId, Margin]:
    """Margins of the rows of a problem that are what the band adds to those of a judged motion.

    Of a height of second order the problem has the linear part, on which less is enough.

    Args:
        band: as judged.
        names: variant -> what it is called in the problem.
        duration: of the motion, s.
        backoff: of the rows of the problem. With a margin that leaves a row on the final state next to nothing beside
            that, waves would have to be gone to the last, for which solves take longest, most of them in vain.
        growths: of heights of second order how much more they fall than their linear parts; 1 of other rows.
    """
    found: dict[RowId, Margin] = {}
    for row, added in band.added.items():
        at_end = row.constraint in END_NAMES
        times = np.linspace(band.t[0], band.t[-1], len(added)) / duration
        for own in of_members(row, names):
            most = min(_MOST_AT_END, max(_MOST_IN_ALL - backoff.get(own, 0.0), 0.0)) if at_end else _MOST
            found[own] = Margin(times, np.minimum(added / growths.get(own, 1.0), most))
    return found


def falling(
    margins: Mapping[RowId, Margin], before: Mapping[RowId, Margin], uses: Mapping[RowId, float] = MappingProxyType({})
) -> dict[RowId, Margin]:
    """Margins no less than half way from those before; no less than those of a row whose use over the band is above 1.

    Else a row that needs back-off beside its margin would lose of one what it gets of the other.
    """
    middle = half_way(margins, before)
    found: dict[RowId, Margin] = {}
    for row, own in margins.items():
        least = _kept_before(own, before.get(row)) if uses.get(row, 0.0) > 1.0 else middle[row].kept
        found[row] = replace(own, kept=np.maximum(own.kept, least)) if row in before else own
    return found


def half_way(margins: Mapping[RowId, Margin], before: Mapping[RowId, Margin]) -> dict[RowId, Margin]:
    """Margins half way from those before, which are none where a row had none.

    Where joints ring, the next motion jumps less by far than the one that the margins are of, and rings less.
    """
    return {
        row: replace(own, kept=0.5 * (own.kept + _kept_before(own, before.get(row)))) for row, own in margins.items()
    }


def _kept_before(margin: Margin, before: Margin | None) -> np.ndarray:
    """What was kept at the shares of a margin."""
    if before is None:
        return np.zeros(len(margin.kept))
    return before.kept if len(margin.kept) == 1 else np.interp(margin.share, before.share, before.kept)


def of_members(row: RowId, names: Mapping[VariantId, str]) -> list[RowId]:
    """The rows of the problem that a row of the certificate stands for; itself, where it is about no object there."""
    own = [RowId(row.constraint, label) for (name, _), label in names.items() if name == row.subject]
    return own or [row]


def joining(band: Band, names: Mapping[VariantId, str]) -> frozenset[RowId]:
    """Rows that come near their limits over the band."""
    near = (row for row, use in band.use.items() if use > _JOINS)
    return frozenset(own for row in near for own in of_members(row, names))


def raised_backoff(
    backoff: Mapping[RowId, float],
    band: Band,
    names: Mapping[VariantId, str],
    growths: Mapping[RowId, float] = MappingProxyType({}),
) -> dict[RowId, float]:
    """Back-off of every row, more where a row is over its limit although its margins were kept.

    Arguments as of `margins_over`.
    """
    raised = dict(backoff)
    for row, use in band.use.items():
        if use > 1.0 and row.constraint not in END_NAMES:
            for own in of_members(row, names):
                if own in raised:
                    more = _MORE * (use - 1.0) / growths.get(own, 1.0) + _LEAST
                    raised[own] += min(more, _STEP, (1.0 - raised[own]) / 2)
    return raised


def lowered_at_end(
    backoff: Mapping[RowId, float], band: Band, planned: Mapping[RowId, float], names: Mapping[VariantId, str]
) -> dict[RowId, float]:
    """More back-off of rows on the final state that are over by what the motion as planned leaves, not by lateness.

    Args:
        backoff: of every row of the problem.
        band: of its answer.
        planned: its uses without the band, by the names in the problem.
        names: as of `margins_over`.
    """
    found: dict[RowId, float] = {}
    for own, use in uses_over(band, names).items():
        kept, part = backoff.get(own, 1.0), planned.get(own, 0.0)
        if own.constraint in END_NAMES and use > 1.0 and part > _OWN * use and kept < _MOST_BACKOFF:
            left = 1.0 - kept - min(use - part, _MOST_AT_END)
            found[own] = min(kept + _STEEPER * max(left, 0.0) * (use - _AIM) / part, _MOST_BACKOFF)
    return found


def uses_over(band: Band, names: Mapping[VariantId, str]) -> dict[RowId, float]:
    """The largest use of every row over the band, by the names in the problem."""
    return {own: use for row, use in band.use.items() for own in of_members(row, names)}


def require_band(scene: Scene, judgement: Judgement, *, ended: bool) -> None:
    """Refuse a motion that holds for the arm as it is stated and not over the band of it.

    Args:
        scene: with the band.
        judgement: of the best motion that was found.
        ended: whether planning ended because its time was up, so that nothing is known.

    Raises:
        NoSolutionError: naming the row that fails, and the largest part of the band up to which that motion holds.
    """
    band, tracking = judgement.band, scene.tracking
    if band is None or tracking is None or ended or judgement.certificate.ok:
        return
    if not all(row.ok for row in judgement.planned_rows):
        return  # it is no motion for any arm
    worst, part = judgement.certificate.worst, band.largest
    raise NoSolutionError(
        f"No motion found that holds with {tracking.text}: {describe(worst)} in the best one, which holds up to "
        f"{100 * part:.2g} % of that{_part_of(tracking, part)}. State less in tolerance.tracking, or relax that limit.",
        Reason(MOTION, worst.constraint, worst.subject, excess=worst.use - 1.0),
    )


def _part_of(tracking: Tracking, part: float) -> str:
    """A part of a band in its own figures: " (delay 0.9 ms, lag 0.6 ms)"; empty where it is nothing of it.

    What ringing adds to accelerations falls as its frequency rises.
    """
    late = (("delay", tracking.delay), ("lag", tracking.lag))
    found = [f"{name} {1e3 * part * float(np.max(own)):.2g} ms" for name, own in late if np.any(own)]
    if tracking.resonance is not None and part > 0.0:
        found.append(f"resonances above about {tracking.resonance.lowest / min(part, 1.0):.2g} Hz")
    if tracking.swing is not None:
        found.append(f"position {1e3 * part * float(np.max(tracking.swing.amplitude)):.2g} mrad")
    return f" ({', '.join(found)})" if found else ""


def smoother(
    before: Smoothness, uses: Mapping[RowId, float], planned: Mapping[RowId, float], *, rings: bool, margins: bool
) -> Smoothness:
    """How smooth the next motion is to be, where the last one has rows over the band that only smoothness lowers.

    Those are rows on the final state; where joints ring any row, but of what has margins only what is more than those
    and back-off take away. Where late joints leave more than the motion as planned does, jerks of more weight are a
    poor remedy once they weigh much: then what is left costs something itself.

    Args:
        before: of the last problem.
        uses: of its motion over the band.
        planned: without the band.
        rings: whether joints ring.
        margins: whether the problem had margins.
    """
    if rings:
        return before.heavier(RINGING, _largest(uses, above=_BY_MARGINS if margins else 1.0))
    if not margins and before.tried is None and not before.stilled:
        heavier = before.heavier(LATE_AT_ONCE, _largest(uses))
        if heavier is not before:
            return heavier
    if not before.stilled and _mostly_late(uses, planned):
        return before.with_late_stilled
    if not margins:
        return before
    return before.heavier(STILLED if before.stilled else LATE, _largest(uses))


def rougher(before: Smoothness, uses: Mapping[RowId, float], *, rings: bool) -> Smoothness:
    """How smooth the next motion is to be after one that holds; arguments as of `smoother`."""
    if rings:
        return before.lighter(RINGING, 0.0)
    return before.lighter(STILLED if before.stilled else LATE, _largest(uses))


def _mostly_late(uses: Mapping[RowId, float], planned: Mapping[RowId, float]) -> bool:
    """Whether a row on the final state is over, more of it by lateness than by the motion as planned."""
    over = {row: use for row, use in uses.items() if row.constraint in END_NAMES and use > 1.0}
    return any(planned.get(row, 0.0) <= _OWN * use for row, use in over.items())


def _largest(uses: Mapping[RowId, float], above: float = math.inf) -> float:
    """The largest use of a row on the final state, or of any row if it is above that; 0 for none."""
    return max((use for row, use in uses.items() if row.constraint in END_NAMES or use > above), default=0.0)


def rings_far(band: Band, smoothness: Smoothness) -> bool:
    """Whether rows are so far over their limits that jerks of more weight come first, and may still gain something.

    Margins of a motion that steps of the jerk let ring say nothing of one without them.
    """
    return max(band.use.values(), default=0.0) > _RINGS_FAR and smoothness.may_rise
