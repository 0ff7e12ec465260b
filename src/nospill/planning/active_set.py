"""The active part of a problem: constraint generation and constraint tightening as one value.

Most objects, variants and rows never come near a limit, and an interior point method pays for each at every iteration.
So a problem holds some of them; the certificate is about all; what it finds violated joins the problem, and what is in
the problem already gets a larger back-off.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from nospill.judge.certificate import Judgement
from nospill.judge.verdict import Row, condensed
from nospill.laws.constraints import BY_NAME, CONSTRAINTS
from nospill.laws.constraints.base import EvaluationPoint, Role, RowId
from nospill.laws.constraints.joint_position import JointPosition
from nospill.planning.backoff import falls_short, first_backoff, further_backoff, range_backoff
from nospill.planning.task import Member, Task
from nospill.scene.scene import Scene

_NEAR = 0.3
"""Rows with this part of their limit left, or less, are near it."""

_NEAR_MEMBER = 0.02
"""Variants with this part of a limit left, or less, in an earlier plan are in the problem from the start."""

_SLIGHT = 5e-3
"""Part of a limit by which what is not in the problem may exceed it and be answered by back-off alone: a larger problem
costs more."""

_OF_OBJECTS = frozenset(item.name for item in CONSTRAINTS if item.role in (Role.LIQUID, Role.CONTACT))


@dataclass(frozen=True, slots=True)
class ActiveSet:
    """What takes part in a problem, and what part of every budget is kept from the optimiser.

    Attributes:
        scene: of the problem; its objects are the members.
        members: the variants of objects in the problem.
        rows: the rows that take part.
        possible: the rows that may: all but those of ignored constraints and those known to hold.
        backoff: of every row, the fraction of its budget that is kept from the optimiser.
    """

    scene: Scene
    members: frozenset[Member]
    rows: frozenset[RowId]
    possible: frozenset[RowId]
    backoff: Mapping[RowId, float]

    @classmethod
    def of(cls, task: Task, q: np.ndarray, members: frozenset[Member] | None = None) -> ActiveSet:
        """All rows of some members, each with its first back-off.

        Args:
            task: the task.
            q: (m, n) rad, joint positions along the path.
            members: those in the problem; the stated variants of the outer objects when left out.
        """
        members = task.first_members if members is None else members
        scene = task.problem_scene(members)
        rows = [RowId(item.name, subject) for item in CONSTRAINTS for subject in item.subjects(scene)]
        left_out = set(task.ignored)
        if not scene.motion.tilt_free and len(scene.robot.joints) == 6:
            left_out.add(JointPosition.name)  # the path alone gives the joints, and the joint path keeps their ranges
        possible = frozenset(key for key in rows if key.constraint not in left_out)
        backoff = {key: first_backoff(key.constraint) for key in rows} | range_backoff(scene, q)
        return cls(scene, members, possible, possible, backoff)

    # --- rows -------------------------------------------------------------------------------------------------------

    def with_rows(self, rows: Iterable[RowId]) -> ActiveSet:
        """The same with these rows, as far as they may take part, and those on the final state, which cost little."""
        final = {key for key in self.possible if BY_NAME[key.constraint].evaluated_at is EvaluationPoint.END}
        return replace(self, rows=self.possible.intersection(rows) | final)

    def near(self, slack: Mapping[RowId, float], room: float = _NEAR) -> frozenset[RowId]:
        """Rows that come near their limits, by what part of each is left."""
        return frozenset(key for key, value in slack.items() if value <= room) & self.possible

    def without_far(self, rows: Iterable[Row]) -> ActiveSet:
        """The same without the rows that stay far from their limits in a judged motion."""
        far = {RowId(row.constraint, row.subject) for row in rows if row.use < 1.0 - _NEAR}
        return self.with_rows(self.rows - far)

    def with_backoff(self, known: Mapping[RowId, float]) -> ActiveSet:
        """The same with at least the back-off that is known to be needed."""
        return replace(self, backoff={key: max(value, known.get(key, 0.0)) for key, value in self.backoff.items()})

    def raised(self) -> dict[str, float]:
        """Back-off above the first one, by "constraint | subject"."""
        return {key.label: value for key, value in self.backoff.items() if value > first_backoff(key.constraint)}

    # --- constraint generation and tightening -----------------------------------------------------------------------

    def after(self, task: Task, judgement: Judgement) -> ActiveSet:
        """What the next problem has to hold after a motion was judged; itself where there is nothing to act on.

        Members join first, of every constraint and object the worst variant that is violated and not in the problem.
        Where none is missing, violated rows join, and those in the problem get a larger back-off.
        """
        rows = judged_rows(judgement)
        missing = self._worst(task.ignored, rows, 1.0 + _SLIGHT)
        if missing:
            return self.joined(task, self.members | missing, judgement)
        active, backoff = set(self.rows), dict(self.backoff)
        for row in condensed(self._on_members(task, filter(falls_short, rows))):
            key = RowId(row.constraint, row.subject)
            if key in self.rows:
                backoff[key] += further_backoff(row)
            elif key in backoff and key.constraint not in task.ignored:
                active.add(key)
        if active == self.rows and backoff == self.backoff:
            return self
        return replace(self, rows=frozenset(active), backoff=backoff)

    def joined(self, task: Task, members: frozenset[Member], judgement: Judgement) -> ActiveSet:
        """The set with other members, with the back-off that is known and without the rows that stay far."""
        q = judgement.replay.joint_position
        grown = ActiveSet.of(task, q, members).with_backoff(self.backoff)
        return grown.without_far(grown._on_members(task, judged_rows(judgement), own=True))

    def near_members(self, judgement: Judgement) -> frozenset[Member]:
        """Of every constraint and object the variant that comes nearest to a limit in a judged motion, if it does."""
        return self._worst((), judged_rows(judgement), 1.0 - _NEAR_MEMBER)

    def _worst(self, ignored: Collection[str], rows: Iterable[Row], use: float) -> frozenset[Member]:
        """Of every constraint and object the variant outside the problem with the largest use, if above `use`."""
        outside = (row for row in rows if _is_of_object(row) and _member(row) not in self.members)
        found = (row for row in outside if row.use > use and row.constraint not in ignored)
        return frozenset(map(_member, condensed(found)))

    def _on_members(self, task: Task, rows: Iterable[Row], *, own: bool = False) -> Iterator[Row]:
        """Rows by the names that their subjects have in the problem.

        What is not in the problem is attributed to the members of the same object, or to all members where there are
        none, unless only the members' own rows are wanted.
        """
        names = task.names()
        for row in rows:
            if not _is_of_object(row):
                yield row
            elif _member(row) in self.members:
                yield replace(row, subject=names[_member(row)], variant="")
            elif not own:
                alike = [member for member in self.members if member[0] == row.subject] or self.members
                for member in alike:
                    yield replace(row, subject=names[member], variant="")


def judged_rows(judgement: Judgement) -> tuple[Row, ...]:
    """The rows of every variant of every object, and the rows that are of no object."""
    if not judgement.corners:
        return judgement.certificate.rows
    return (*judgement.corners, *(row for row in judgement.certificate.rows if not _is_of_object(row)))


def _is_of_object(row: Row) -> bool:
    return row.constraint in _OF_OBJECTS


def _member(row: Row) -> Member:
    return row.subject, row.variant
