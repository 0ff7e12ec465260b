"""Rows of variants of objects, beside a problem that holds some: which are missing, and whom the others concern.

A variant that a problem holds is called a member.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import groupby, islice

import numpy as np

from nospill.judge.verdict import Row, condensed
from nospill.laws.constraints import BY_NAME, END_NAMES, LIQUID_NAMES, OBJECT_NAMES
from nospill.laws.constraints.base import RowId
from nospill.planning.tightening import is_spent, tightened_backoff
from nospill.planning.worst_speeds import beside, evenly, is_far, peaks
from nospill.scene.cargo import Cargo
from nospill.scene.variants import VariantId

_SLIGHT_OF_SLOWED = 0.1
"""Part of its limit by which a liquid between two speeds of a problem may exceed it before it joins: the back-off of
those two is cheaper than one member more."""
_MOST_AT_ONCE = 4
"""Of a constraint: where the worst ones keep it, most others do."""


def missing(
    rows: Iterable[Row],
    names: Mapping[VariantId, str],
    speeds: Mapping[VariantId, float],
    *,
    above: float,
    outer: Collection[str],
    backoff: Mapping[RowId, float],
    t: np.ndarray,
    cargo: Iterable[Cargo],
) -> frozenset[VariantId]:
    """Of every constraint the worst objects, of each the variant outside a problem with the largest use.

    At other speeds, the peaks: of liquids those well above a limit, and those beside which back-off has been in vain.

    Of liquids that are not in the problem at other speeds yet, the worst one at even steps of its phase at the end.

    Args:
        rows: of a judged motion.
        names: what the members are called in the problem.
        speeds: of every variant, as part of the planned one.
        above: the use from which a variant is missing; the limit itself, if that is less, for one of an outer object
            without members: of it the back-off of others says nothing.
        outer: objects that no like ones stand for.
        backoff: of every row of the problem, the fraction of its budget that it keeps.
        t: (m,) s, of the motion.
        cargo: whose modes swing.
    """
    of_objects = [row for row in rows if row.constraint in OBJECT_NAMES]
    slowed = [row for row in of_objects if speeds[_variant(row)] < 1.0]
    contact = [row for row in slowed if row.constraint not in LIQUID_NAMES]
    liquid = [row for row in slowed if row.constraint in LIQUID_NAMES]
    liquids = {item.name for item in cargo if item.oscillators}
    alone = set(outer).difference(name for name, _ in names)
    spent = set(spent_at_end(backoff, names, speeds).values())
    at_end = (row for row in liquid if spent and row.constraint in END_NAMES)
    in_vain = {row for row in at_end if not spent.isdisjoint(beside(speeds[_variant(row)], names, speeds))}
    solid = [row for row in contact if row.subject not in liquids]
    in_vain.update(solid)  # they bring no states
    least = {row: min(above, 1.0) if row.subject in alone or row in in_vain else above for row in of_objects}
    found = peaks(solid, speeds)
    found += peaks((row for row in contact if row.subject in liquids), speeds)
    if any(speeds[member] < 1.0 and member[0] in liquids for member in names):
        found += [row for row in peaks(liquid, speeds) if row in in_vain or row.use > above + _SLIGHT_OF_SLOWED]
    elif liquid:
        found += evenly(liquid, speeds, _step(t, cargo))
    planned = (row for row in of_objects if speeds[_variant(row)] == 1.0 and _variant(row) not in names)
    found += _worst(condensed(row for row in planned if row.use > least[row]))
    return frozenset(_variant(row) for row in found if row.use > least[row]).difference(names)


def far_peaks(
    rows: Iterable[Row],
    names: Mapping[VariantId, str],
    speeds: Mapping[VariantId, float],
    *,
    t: np.ndarray,
    cargo: Iterable[Cargo],
) -> frozenset[VariantId]:
    """Liquids over a limit at speeds of which the back-off of what is in the problem says nothing.

    Half a step of their phase at the end, or more, from all that are slowed. Arguments as of `missing`.
    """
    liquid = (row for row in rows if row.constraint in LIQUID_NAMES and speeds[_variant(row)] < 1.0)
    over = [row for row in peaks(liquid, speeds) if row.use > 1.0]
    step = _step(t, cargo) if over else 0.0
    return frozenset(_variant(row) for row in over if is_far(speeds[_variant(row)], names, speeds, step))


def _step(t: np.ndarray, cargo: Iterable[Cargo]) -> float:
    """Step of 1/v, v a part of the planned speed, in which the phase of the slowest mode at the end turns by pi."""
    return float(np.pi / (min(mode.frequency for item in cargo for mode in item.oscillators) * np.ptp(t)))


def _worst(rows: Iterable[Row]) -> Iterator[Row]:
    """Of every constraint the `_MOST_AT_ONCE` rows that use most of their limits."""
    for _, group in groupby(sorted(rows, key=lambda row: (row.constraint, -row.use)), key=lambda row: row.constraint):
        yield from islice(group, _MOST_AT_ONCE)


def attributed(
    rows: Iterable[Row], names: Mapping[VariantId, str], speeds: Mapping[VariantId, float], *, own: bool
) -> Iterator[Row]:
    """Rows by the names that their subjects have in a problem.

    What is not in it is attributed to the members of the same object, or to all where there are none; at another speed,
    to the slowed members next to it.

    Args:
        rows: of a judged motion.
        names: what the members are called.
        speeds: of every variant, as part of the planned one.
        own: whether only the members' own rows are wanted.
    """
    for row in rows:
        variant = _variant(row)
        if row.constraint not in OBJECT_NAMES:
            yield row
        elif variant in names:
            yield replace(row, subject=names[variant], variant="")
        elif not own:
            same = [member for member in names if member[0] == row.subject]
            next_to = beside(speeds[variant], names, speeds) if speeds[variant] < 1.0 else []
            for member in next_to or same or names:
                yield replace(row, subject=names[member], variant="")


def spent_at_end(
    backoff: Mapping[RowId, float], names: Mapping[VariantId, str], speeds: Mapping[VariantId, float]
) -> dict[RowId, VariantId]:
    """Rows on the final state whose back-off is so large that more would not do at the speeds beside, and of whom.

    Of slowed members alone.

    Args:
        backoff: of every row of a problem, the fraction of its budget that is kept.
        names: what the members are called in it.
        speeds: of every variant, as part of the planned one.
    """
    slowed = {label: item for item, label in names.items() if speeds[item] < 1.0}
    rows = (row for row, kept in backoff.items() if row.constraint in END_NAMES and is_spent(kept))
    return {row: slowed[row.subject] for row in rows if row.subject in slowed}


def tightened(
    rows: Iterable[Row], active: Collection[RowId], backoff: Mapping[RowId, float], slack: Mapping[RowId, float]
) -> tuple[dict[RowId, float], frozenset[RowId]]:
    """Back-off of every row for the next problem, and the rows that are broken without taking part in this one.

    Args:
        rows: that break their limits, by the names of the members.
        active: rows that take part.
        backoff: of every row that may.
        slack: part of its budget that each left unused.
    """
    joining, found = set[RowId](), dict(backoff)
    for row in condensed(rows):
        key = row.id
        if key in active:
            excess, point = row.shortfall / row.size, BY_NAME[row.constraint].evaluated_at
            found[key] = tightened_backoff(found[key], excess, slack.get(key, 0.0), point)
        elif key in found:
            joining.add(key)
    return found, frozenset(joining)


def uses_of(rows: Iterable[Row]) -> dict[RowId, float]:
    """The largest use of each row."""
    uses: dict[RowId, float] = {}
    for row in rows:
        uses[row.id] = max(row.use, uses.get(row.id, 0.0))
    return uses


def _variant(row: Row) -> VariantId:
    return row.subject, row.variant
