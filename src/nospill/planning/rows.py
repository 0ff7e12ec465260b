"""Which rows of the problem take part, and what part of every budget is kept from the optimiser."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from nospill.judge.verdict import Row
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.constraints.base import Place
from nospill.laws.constraints.joint_position import JointPosition
from nospill.planning.reserves import first_reserve, further_reserve
from nospill.scene.scene import Scene

_AT_THE_END = frozenset(constraint.name for constraint in CONSTRAINTS if constraint.place is Place.END)
_NEAR = 0.3
"""Rows with this part of their limit left come near it."""

Key = tuple[str, int]
"""Constraint and index of its subject."""


@dataclass(slots=True)
class Rows:
    """The rows of a scene.

    Attributes:
        subjects: by constraint, their names.
        ignored: constraints that the user wants left out.
        left_out: those and what is known to hold beforehand.
        reserves: of every row, the fraction of its budget that is kept back.
        kept: rows that take part.
    """

    subjects: dict[str, tuple[str, ...]]
    ignored: frozenset[str]
    left_out: frozenset[str]
    reserves: dict[Key, float]
    kept: set[Key]

    @classmethod
    def of(cls, scene: Scene, ignored: frozenset[str]) -> Rows:
        """All rows of a scene but those of ignored constraints take part, each with its first reserve."""
        subjects = {constraint.name: constraint.subjects(scene) for constraint in CONSTRAINTS}
        reserves = {(name, index): first_reserve(name) for name, own in subjects.items() for index in range(len(own))}
        # On a level tray the path alone says where six joints are, and `joint_paths` has looked at that.
        given = not scene.motion.tilt_free and len(scene.robot.joints) == 6
        left_out = ignored | {JointPosition.name} if given else ignored
        found = cls(subjects, ignored, left_out, reserves, set())
        found.keep_all()
        return found

    @property
    def all(self) -> set[Key]:
        """Every row that may take part."""
        return {key for key in self.reserves if key[0] not in self.left_out}

    @property
    def active(self) -> frozenset[Key]:
        """The rows of the problem: those that are kept, and all on the final state, which cost nothing."""
        return frozenset(self.kept | {key for key in self.all if key[0] in _AT_THE_END})

    def keep_all(self) -> None:
        """Let all of them take part."""
        self.kept = self.all

    def keep_near(self, rows: Sequence[Row]) -> None:
        """Leave rows far from their limits to the judge: they come back if he objects. Fewer rows, faster steps."""
        for row in rows:
            own = self.subjects.get(row.constraint, ())
            if row.subject in own and row.use < 1.0 - _NEAR:
                self.kept.discard((row.constraint, own.index(row.subject)))

    def close(self, slack: Mapping[Key, float]) -> set[Key]:
        """Those that come near their limits, by what is left of each."""
        return {key for key, value in slack.items() if value <= _NEAR} & self.all

    def answer(self, objections: Sequence[Row]) -> bool:
        """Take back rows that were left out, raise the reserve of the others; whether there was any to act on."""
        raised = False
        for row in objections:
            if row.constraint not in self.subjects or row.constraint in self.ignored:
                continue
            key = (row.constraint, self.subjects[row.constraint].index(row.subject))
            if key in self.kept:
                self.reserves[key] += further_reserve(row)
            self.kept.add(key)
            raised = True
        return raised

    def labelled(self) -> dict[str, float]:
        """The reserves by constraint and subject: "slip | c1"."""
        return {self._label(key): value for key, value in self.reserves.items()}

    def raised(self) -> dict[str, float]:
        """The same of those that are larger than at first."""
        return {self._label(key): value for key, value in self.reserves.items() if value > first_reserve(key[0])}

    def recall(self, labelled: Mapping[str, float]) -> None:
        """Keep back at least as much as is known to be needed."""
        for key in self.reserves:
            self.reserves[key] = max(self.reserves[key], labelled.get(self._label(key), 0.0))

    def _label(self, key: Key) -> str:
        return f"{key[0]} | {self.subjects[key[0]][key[1]]}"
