"""What a verdict is made of: traces over time, the worst instant of each as a row, all rows as a certificate."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from nospill.collisions.pairs import SelfCollision
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.base import OF_OBJECTS, Constraint, EvaluationPoint, Role, RowId
from nospill.laws.constraints.clearance import Clearance
from nospill.scene.limits import LimitRecord

_ALIKE = 9
"""Digits to which uses are compared: of alike ones the first is named on every machine, however it rounds its sums."""
APPROACH = "approach "
"""What the constraints of the rows about the approach begin with."""


def limit_use(constraint: Constraint | None, limit: np.ndarray | float, margin: np.ndarray | float) -> np.ndarray:
    """Use of a limit, 1 - margin/size: 1 at the limit, more where it is broken.

    The size is that of the limit itself, and at least `Constraint.least_size` (half a turn of a joint, one weight, one
    gravity); a limit of zero counts as one of its unit. A margin that is no number is infinite use.

    Args:
        constraint: that it is the limit of; None for a check of the record.
        limit: (m,) or one number, in the constraint's unit.
        margin: likewise.
    """
    use = 1.0 - np.asarray(margin) / _size(constraint, limit)
    missing = np.isnan(use)
    return np.where(missing, np.inf, use) if missing.any() else use


def margin_at(constraint: Constraint | None, limit: np.ndarray, use: np.ndarray) -> np.ndarray:
    """The margin (m,) at some uses of a limit, in the constraint's unit: `limit_use` the other way round."""
    return (1.0 - use) * _size(constraint, limit)


def _size(constraint: Constraint | None, limit: np.ndarray | float) -> np.ndarray:
    least, size = 0.0 if constraint is None else constraint.least_size, np.abs(limit)
    return np.maximum(size, least) if least > 0.0 else np.where(size > 0.0, size, 1.0)


@dataclass(frozen=True)
class Row:
    """One constraint and one subject: the instant that uses most of the limit. `ok` is worst_margin >= 0.

    `variant` says with which numbers, where those of the subject may be off and others than the stated ones are worst;
    `linear_value` is the greatest height by linear theory, where the row is about one of second order; `law` is the
    constraint itself, where it is none of the table.
    """

    constraint: str
    subject: str
    unit: str
    limit: float
    worst_value: float
    worst_margin: float
    at_s: float
    ok: bool
    variant: str = ""
    linear_value: float | None = None
    law: Constraint | None = field(default=None, repr=False, compare=False)

    @property
    def known(self) -> Constraint | None:
        """The constraint that it is about; None for a check of the record."""
        return self.law or BY_NAME.get(self.constraint.removeprefix(APPROACH))

    @property
    def id(self) -> RowId:
        """Constraint and subject."""
        return RowId(self.constraint, self.subject)

    @property
    def label(self) -> str:
        """Subject with its variant, as in messages: "c1 at fill +2 mm", "holder to link_4 (estimated capsules)"."""
        if not self.variant:
            return self.subject
        of_bodies = self.constraint.removeprefix(APPROACH) == Clearance.name
        return f"{self.subject} ({self.variant})" if of_bodies else f"{self.subject} at {self.variant}"

    @cached_property
    def use(self) -> float:
        """`limit_use` at that instant; cached, since rows are sorted by it."""
        return float(limit_use(self.known, self.limit, self.worst_margin))

    @property
    def size(self) -> float:
        """What its margin is measured by (`limit_use`), in its unit."""
        return float(_size(self.known, self.limit))

    @property
    def of_record(self) -> bool:
        """Whether it is about the record itself, and no constraint of the motion: it fails where a file is damaged."""
        return self.known is None

    @property
    def of_object(self) -> bool:
        """Whether it is about an object on the tray by itself, its liquid or its place."""
        return self.known is not None and self.known.evaluated_at in OF_OBJECTS

    @property
    def of_liquid(self) -> bool:
        """Whether it is about the liquid in an object."""
        return self.known is not None and self.known.role is Role.LIQUID

    @property
    def at_end(self) -> bool:
        """Whether it is about the final state."""
        return self.known is not None and self.known.evaluated_at is EvaluationPoint.END

    @property
    def shortfall(self) -> float:
        """What is missing, in the row's unit, of what a finer grid may find; above zero where the row falls short.

        A row about the record leaves nothing to find: it falls short only where it fails.
        """
        constraint = None if self.constraint.startswith(APPROACH) else self.known
        if constraint is None:
            return -self.worst_margin
        found = constraint.judge_resolution * abs(self.limit) + constraint.integration_error
        return found - self.worst_margin


def _urgency(row: Row) -> tuple[bool, float]:
    return not row.ok, round(row.use, _ALIKE)


def _fullest_of_each(rows: Iterable[Row]) -> tuple[Row, ...]:
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(row.constraint, []).append(row)
    return tuple(sorted((max(group, key=_urgency) for group in groups.values()), key=_urgency, reverse=True))


@dataclass(frozen=True, slots=True, repr=False)
class Certificate:
    """All rows; ok when every one is.

    Attributes:
        ok: whether every row holds.
        grid_hz: rate of the grid the trajectory was judged on.
        rows: one per constraint and subject.
        published: whether the physics are the published ones (`fidelity = "deliverable"`).
        modes: modes of each liquid in each direction where the full model has more (`Scene.fewer_modes`), else None.
        full_model: rows on objects that the full model breaks in the same motion (see `judge.full_model`), no part of
            `ok`; None where nobody has looked.
        unjudged: limits of the scene whose classes are not at hand; with any of them nothing is certified.
        self_collision: which pairs of the arm with itself and its load were judged; None where the record of an earlier
            version does not say.
    """

    ok: bool
    grid_hz: float
    rows: tuple[Row, ...]
    published: bool = False
    modes: int | None = None
    full_model: tuple[Row, ...] | None = field(default=None, compare=False)
    unjudged: tuple[LimitRecord, ...] = ()
    self_collision: SelfCollision | None = field(default=None, compare=False)

    def __repr__(self) -> str:
        return f"<Certificate: {self.word}, {len(self.rows)} rows>"

    @property
    def word(self) -> str:
        """The verdict in a few words: of less than the full model it says of what, by itself never "certified"."""
        if not self.ok:
            return "not certified"
        if self.published:
            return "certified as published"
        return f"certified with {self.modes} mode{'' if self.modes == 1 else 's'}" if self.modes else "certified"

    @property
    def worst(self) -> Row:
        """The row that uses most of its limit (`limit_use`); a broken one before any other."""
        return max(self.rows, key=_urgency)

    def worst_rows(self) -> tuple[Row, ...]:
        """Of every constraint of the motion the row that uses most of its limit: broken ones first, then by use."""
        return _fullest_of_each([row for row in self.rows if not row.of_record])

    def record_rows(self) -> tuple[Row, ...]:
        """The same of the checks of the record itself."""
        return _fullest_of_each([row for row in self.rows if row.of_record])

    def listed_rows(self) -> tuple[Row, ...]:
        """What a table of the certificate shows: the checks of the record that fail, then `worst_rows`."""
        return (*(row for row in self.record_rows() if not row.ok), *self.worst_rows())

    def joined(self, other: Certificate) -> Certificate:
        """This verdict with the rows of another one, about another segment, behind its own."""
        grid_hz = min(self.grid_hz, other.grid_hz)
        return replace(self, ok=self.ok and other.ok, grid_hz=grid_hz, rows=self.rows + other.rows)

    def to_dict(self) -> dict[str, Any]:
        """For certificate.json: ok, grid_hz, rows, published, modes, what the full model breaks where it is known."""
        table: dict[str, Any] = {"ok": self.ok, "grid_hz": self.grid_hz, "rows": [_plain(row) for row in self.rows]}
        table |= {"published": self.published, "modes": self.modes}
        if self.self_collision is not None:
            table["self_collision"] = self.self_collision.to_dict()
        if self.full_model is not None:
            table["full_model"] = [_plain(row) for row in self.full_model]
        return table


def _plain(row: Row) -> dict[str, Any]:
    """A row as it is written; a variant and a linear value only where there is one."""
    names = (item.name for item in fields(Row) if item.name != "law")
    absent = {"variant": "", "linear_value": None}
    return {name: value for name in names if (value := getattr(row, name)) != absent.get(name, row)}


@dataclass(frozen=True)
class Trace:
    """One constraint and subject over time: t (m,) s, value, limit and margin (m,) in the constraint's unit.

    `variant` as of a row; `linear` (m,) is the height by linear theory where the value is one of second order; `law` is
    the constraint itself, where it is none of the table.
    """

    constraint: str
    subject: str
    unit: str
    t: np.ndarray
    value: np.ndarray
    limit: np.ndarray
    margin: np.ndarray
    variant: str = ""
    linear: np.ndarray | None = None
    law: Constraint | None = field(default=None, repr=False, compare=False)

    @property
    def known(self) -> Constraint | None:
        """The constraint, as `Row.known`."""
        return self.law or BY_NAME.get(self.constraint)

    @property
    def id(self) -> RowId:
        """Constraint and subject."""
        return RowId(self.constraint, self.subject)

    @cached_property
    def use(self) -> np.ndarray:
        """`limit_use` over time, shape (m,); cached, since rows, peaks and what holds the motion back all read it."""
        return limit_use(self.known, self.limit, self.margin)


def worst_row(trace: Trace) -> Row:
    """The instant of a trace that uses most of its limit: where that is constant, the one with the least margin."""
    index = int(np.argmax(trace.use))
    margin = float(trace.margin[index])
    if np.isnan(margin):  # that is none at all
        margin = -np.inf
    return Row(
        constraint=trace.constraint,
        subject=trace.subject,
        unit=trace.unit,
        limit=float(trace.limit[index]),
        worst_value=float(trace.value[index]),
        worst_margin=margin,
        at_s=float(trace.t[index]),
        ok=bool(margin >= 0.0),
        variant=trace.variant,
        linear_value=None if trace.linear is None else float(np.max(trace.linear)),
        law=trace.law,
    )


def limit_trace(name: str, subject: str, unit: str, limit: float, t: np.ndarray, values: np.ndarray) -> Trace:
    """The trace of values (m,), none below zero, against one limit."""
    return Trace(name, subject, unit, t, values, np.full(len(values), limit), limit - values)


def fullest(traces: Iterable[Trace]) -> dict[RowId, Trace]:
    """Of every constraint and subject the trace that uses most of its limit, in the order of their first ones."""
    found: dict[RowId, Trace] = {}
    for trace in traces:
        keep_fullest(found, trace)
    return found


def keep_fullest(found: dict[RowId, Trace], trace: Trace) -> None:
    """Put a trace among the `fullest` so far, where it uses more of its limit than the one that is there."""
    key = trace.id
    if key not in found or _urgency(worst_row(trace)) > _urgency(worst_row(found[key])):
        found[key] = trace


def condensed(rows: Iterable[Row]) -> tuple[Row, ...]:
    """Of every constraint and subject the row that uses most of its limit, in the order of their first rows."""
    groups: dict[RowId, list[Row]] = {}
    for row in rows:
        groups.setdefault(row.id, []).append(row)
    return tuple(max(group, key=_urgency) for group in groups.values())
