"""Which violated variants to add to the problem, and which rows to tighten for the rest.

A problem holds some variants of the objects: its members. A motion is judged with all variants, so each row of its
certificate is about a member, about another variant of an object that has members, or about an object without any. For
example, of two like cups c1 and c2, each full within 2 mm, a problem holds c1 as stated. Uses of the slosh height:

    c1 as stated     1.004    a member: its row gets a larger back-off
    c1 at +2 mm      1.020    joins, where a use above 1.005 does
    c2 at +2 mm      1.018    joins as well: of each object the worst variant
    c2 at -2 mm      1.003    counts for the members of c2; there being none, the row of c1 gets a larger back-off

At speeds below the planned one (`speed_range`) like objects have their worst speeds in common, and the use over the
speed has maxima. There the rows at those maxima are candidates in the place of the worst of each object.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, islice

import numpy as np

from nospill.certification.verdict import Row, condensed
from nospill.laws.constraints import END_NAMES
from nospill.laws.constraints.base import RowId
from nospill.planning.tightening import is_saturated
from nospill.planning.worst_speeds import adjacent_members, evenly, is_far, peaks
from nospill.scene.cargo import Cargo
from nospill.scene.variants import VariantId

_SLIGHT_OF_SLOWED = 0.1
"""Part of its limit by which a liquid between two speeds of a problem may exceed it before it joins: the back-off of
those two is cheaper than one member more."""


@dataclass(frozen=True, slots=True)
class Members:
    """The variants in a problem.

    Attributes:
        names: what each is called in it.
        speeds: of every variant, in the problem or not, as part of the planned one.
        cargo: every object once, with the modes that swing.
        at_once: how many join at once for one constraint.
    """

    names: Mapping[VariantId, str]
    speeds: Mapping[VariantId, float]
    cargo: tuple[Cargo, ...]
    at_once: int

    def missing(
        self,
        rows: Iterable[Row],
        *,
        above: float,
        outer: Collection[str],
        backoff: Mapping[RowId, float],
        t: np.ndarray,
    ) -> frozenset[VariantId]:
        """The variants outside the problem that are to join it: those of some rows that use too much of their limits.

        At the planned speed of every constraint the worst objects, of each the worst variant; at lower speeds the peaks
        of contacts and of liquids.

        Args:
            rows: of a judged motion.
            above: the use from which a variant joins; the limit itself, if that is less, where the back-off of the
                members says nothing of it or has been in vain.
            outer: objects that no like ones stand for.
            backoff: of every row of the problem, the fraction of its budget that it keeps.
            t: (m,) s, of the motion.
        """
        of_objects = [row for row in rows if row.of_object]
        slowed = [row for row in of_objects if self._is_slowed(row)]
        planned = [row for row in of_objects if not self._is_slowed(row) and _variant(row) not in self.names]
        contacts = [row for row in slowed if not row.of_liquid]
        liquids = [row for row in slowed if row.of_liquid]
        in_vain = self._next_to_saturated(liquids, backoff)
        alone = set(outer).difference(name for name, _ in self.names)
        with_liquid = self._with_liquid
        solids = {row for row in contacts if row.subject not in with_liquid}  # they bring no states

        def is_over(row: Row) -> bool:
            at_once = row.subject in alone or row in solids or row in in_vain
            return row.use > (min(above, 1.0) if at_once else above)

        candidates = _worst(condensed(filter(is_over, planned)), self.at_once)
        candidates += self._contact_peaks(contacts)
        candidates += self._liquid_candidates(liquids, in_vain, above + _SLIGHT_OF_SLOWED, t)
        return frozenset(_variant(row) for row in candidates if is_over(row)).difference(self.names)

    def far_peaks(self, rows: Iterable[Row], t: np.ndarray) -> frozenset[VariantId]:
        """Liquids over a limit at speeds of which the back-off of what is in the problem says nothing.

        Half a step of their phase at the end, or more, from all that are slowed. Arguments as of `missing`.
        """
        liquids = (row for row in rows if row.of_liquid and self._is_slowed(row))
        over = [row for row in peaks(liquids, self.speeds) if row.use > 1.0]
        step = self._phase_step(t) if over else 0.0
        far = (row for row in over if is_far(self.speeds[_variant(row)], self.names, self.speeds, step))
        return frozenset(_variant(row) for row in far)

    def attributed(self, rows: Iterable[Row], *, own: bool) -> Iterator[Row]:
        """Rows by the names that their subjects have in the problem.

        What is not in it is attributed to the members of the same object, or to all where there are none: at the
        planned speed to those that move so fast, at another to the slowed ones next to it.

        Args:
            rows: of a judged motion.
            own: whether only the members' own rows are wanted.
        """
        for row in rows:
            variant = _variant(row)
            if not row.of_object:
                yield row
            elif variant in self.names:
                yield replace(row, subject=self.names[variant], variant="")
            elif not own:
                alike = [member for member in self.names if self._is_slowed(row) or self.speeds[member] == 1.0]
                same = [member for member in alike if member[0] == row.subject]
                next_to = self._next_to(row) if self._is_slowed(row) else []
                for member in next_to or same or alike or self.names:
                    yield replace(row, subject=self.names[member], variant="")

    def saturated_at_end(self, backoff: Mapping[RowId, float]) -> dict[RowId, VariantId]:
        """Rows on the final state whose back-off is so large that more would not do at adjacent speeds, and of whom.

        Of slowed members alone.

        Args:
            backoff: of every row of the problem, the fraction of its budget that is kept.
        """
        slowed = {label: item for item, label in self.names.items() if self.speeds[item] < 1.0}
        rows = (row for row, kept in backoff.items() if row.constraint in END_NAMES and is_saturated(kept))
        return {row: slowed[row.subject] for row in rows if row.subject in slowed}

    @property
    def slowest(self) -> float:
        """Least speed of a member in which something swings, a part of the planned one; 1 without any."""
        return min((self.speeds[member] for member in self.names if member[0] in self._with_liquid), default=1.0)

    @property
    def _with_liquid(self) -> frozenset[str]:
        """Objects in which something swings."""
        return frozenset(item.name for item in self.cargo if item.oscillators)

    def _is_slowed(self, row: Row) -> bool:
        return self.speeds[_variant(row)] < 1.0

    def _next_to(self, row: Row) -> list[VariantId]:
        """The slowed members at the speeds next to that of a row."""
        return adjacent_members(self.speeds[_variant(row)], self.names, self.speeds)

    def _next_to_saturated(self, liquids: Iterable[Row], backoff: Mapping[RowId, float]) -> set[Row]:
        """Rows on the final state of slowed liquids next to a member whose back-off is spent."""
        spent = set(self.saturated_at_end(backoff).values())
        at_end = (row for row in liquids if spent and row.at_end)
        return {row for row in at_end if not spent.isdisjoint(self._next_to(row))}

    def _contact_peaks(self, contacts: Iterable[Row]) -> list[Row]:
        """Slowed contacts at the speeds at which they are worst, of solids and of vessels with liquid."""
        parts: tuple[list[Row], list[Row]] = ([], [])
        with_liquid = self._with_liquid
        for row in contacts:
            parts[row.subject in with_liquid].append(row)
        return [row for part in parts for row in peaks(part, self.speeds)]

    def _liquid_candidates(
        self, liquids: Sequence[Row], in_vain: Collection[Row], clearly: float, t: np.ndarray
    ) -> list[Row]:
        """Slowed liquids far over a limit or next to which back-off is in vain, at the greatest speeds first.

        Those at peaks between the speeds that are in the problem, and below them at even steps of their phase at the
        end. At most as many as there are members, or as join for one constraint: with the multipliers of these a
        problem twice as large takes less than half of the iterations of one with all of them.

        Args:
            liquids: their rows.
            in_vain: those next to which back-off has been in vain.
            clearly: the use that is far over a limit.
            t: (m,) s, of the motion.
        """
        if not liquids:
            return []
        least, step = self.slowest, self._phase_step(t)
        found = evenly(
            [row for row in liquids if 1.0 / self._speed(row) >= 1.0 / least + 0.5 * step], self.speeds, step
        )
        if least < 1.0:
            found += [row for row in peaks(liquids, self.speeds) if self._speed(row) >= least]
            found = [row for row in found if row in in_vain or row.use > clearly]
        joining = [row for row in found if _variant(row) not in self.names]
        return sorted(joining, key=self._speed, reverse=True)[: max(len(self.names), self.at_once)]

    def _speed(self, row: Row) -> float:
        return self.speeds[_variant(row)]

    def _phase_step(self, t: np.ndarray) -> float:
        """Step of 1/v, v a part of the planned speed, in which the phase of the slowest mode at the end turns by pi."""
        slowest = min(mode.frequency for item in self.cargo for mode in item.oscillators)
        return float(np.pi / (slowest * np.ptp(t)))


def _worst(rows: Iterable[Row], most: int) -> list[Row]:
    """Of every constraint so many rows that use most of their limits."""
    in_order = groupby(sorted(rows, key=lambda row: (row.constraint, -row.use)), key=lambda row: row.constraint)
    return [row for _, group in in_order for row in islice(group, most)]


def _variant(row: Row) -> VariantId:
    return row.subject, row.variant
