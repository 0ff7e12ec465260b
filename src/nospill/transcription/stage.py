"""Rows of a stage: the constraints of the table as smooth expressions, and which rows belong to which of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, dataclass
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from nospill.core.frames import SX
from nospill.laws.constraints import constraints_of
from nospill.laws.constraints.base import EvaluationPoint, smooth_rows
from nospill.laws.sample import Sample
from nospill.laws.structure import Structure


class RowIndex(NamedTuple):
    """A row of a structure, whose subjects have no names yet.

    Attributes:
        constraint: its name.
        subject: index of its subject.
    """

    constraint: str
    subject: int


@dataclass(frozen=True, slots=True)
class Block:
    """Rows of one constraint and one subject inside a stage.

    Attributes:
        constraint: its name.
        subject: index of its subject.
        first: index of the first row.
        count: number of rows.
        repetition: which point of the interval they stand at, 0 for the node.
    """

    constraint: str
    subject: int
    first: int
    count: int
    repetition: int

    @property
    def row(self) -> RowIndex:
        """Constraint and subject."""
        return RowIndex(self.constraint, self.subject)


def subject_count(structure: Structure) -> int:
    """Most subjects that a constraint has in a structure; three of them are directions."""
    given = (item.count for item in structure.constraints)
    return max(len(structure.objects), len(structure.joints), 3, *given)


class RowCollector:
    """Gathers smooth rows and remembers which constraint and subject each belongs to."""

    def __init__(self, backoff: Mapping[RowIndex, SX]) -> None:
        self._backoff = backoff
        self.values: list[SX] = []
        self.lower: list[np.ndarray] = []
        self.upper: list[np.ndarray] = []
        self.blocks: list[Block] = []
        self._count = 0

    def add(self, sample: Sample, points: tuple[EvaluationPoint, ...], repetition: int = 0) -> None:
        """Add every constraint of the given points."""
        for constraint in constraints_of(sample.structure):
            if constraint.evaluated_at not in points:
                continue
            for subject, budgets in enumerate(constraint.budgets(sample)):
                first = self._count
                for budget in budgets:
                    value, lower, upper = smooth_rows(budget, self._backoff[RowIndex(constraint.name, subject)])
                    self.values.append(value)
                    self.lower.append(lower)
                    self.upper.append(upper)
                    self._count += len(lower)
                self.blocks.append(Block(constraint.name, subject, first, self._count - first, repetition))

    def stacked(self) -> tuple[SX, np.ndarray, np.ndarray]:
        """All rows with their bounds."""
        if not self.values:
            return SX(0, 1), np.zeros(0), np.zeros(0)
        return ca.vertcat(*self.values), np.concatenate(self.lower), np.concatenate(self.upper)

    def plain(self) -> dict[str, Any]:
        """Bounds and blocks as json can hold them, see `Rows`."""
        _, lower, upper = self.stacked()
        return {"lower": lower.tolist(), "upper": upper.tolist(), "blocks": [astuple(item) for item in self.blocks]}


@dataclass(frozen=True, eq=False)
class Rows:
    """Rows of constraints as plain numbers, which are kept beside compiled code.

    Attributes:
        lower: (m,) bounds.
        upper: likewise.
        blocks: which rows belong to what.
    """

    lower: np.ndarray
    upper: np.ndarray
    blocks: tuple[Block, ...]

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> Rows:
        """The rows of a table that `RowCollector.plain` has made."""
        lower, upper = (np.array(data[name], dtype=float) for name in ("lower", "upper"))
        return cls(lower, upper, tuple(Block(*block) for block in data["blocks"]))
