"""The active part of a problem: constraint generation and constraint tightening as one value.

Most objects, variants and rows never come near a limit, and an interior point method pays for each at every iteration.
So a problem holds some of them; the certificate is about all; what it finds violated joins the problem, and what is in
the problem already gets a larger back-off (`next_set`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from nospill.certification.certificate import Judgement
from nospill.certification.verdict import Row
from nospill.laws.constraints import by_name, constraints_of
from nospill.laws.constraints.base import EvaluationPoint, RowId
from nospill.laws.constraints.clearance import clearance_backoff
from nospill.laws.constraints.joint_jerk import command_backoff
from nospill.laws.constraints.joint_position import JointPosition, range_backoff
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.planning.driven_waves import (
    FIRST_BACKOFF,
    as_carried,
    far_over,
)
from nospill.planning.members import Members
from nospill.planning.row_backoff import Crests, backoff_by_order
from nospill.planning.second_order import beyond_crests, with_room
from nospill.planning.smoothness import AS_STATED, SECOND_ORDER, Smoothness
from nospill.planning.task import Task
from nospill.planning.tightening import (
    backoff_with_room,
)
from nospill.scene.scene import Scene
from nospill.scene.variants import VariantId, labels
from nospill.transcription.margins_along import Margin

_NEAR = 0.3
"""Rows with this part of their limit left, or less, are near it."""
_NEAR_MEMBER = 0.02
"""Variants with this part of a limit left in an earlier plan are in the problem from the start."""
_OF_SUM = 0.3
"""Back-off of a residual height with which modes join: the judge finds their sum, the optimiser the root of squares."""


@dataclass(frozen=True, slots=True)
class ActiveSet:
    """What takes part in a problem, and what part of every budget is kept from the optimiser.

    Attributes:
        task: what the problem is for.
        scene: of the problem; its objects are the members.
        members: the variants of objects in the problem.
        refined: objects that are in it with more than one mode of their liquid.
        modes: of those.
        rows: the rows that take part.
        possible: the rows that may: all but those of ignored constraints and those known to hold.
        backoff: of every row, the fraction of its budget that is kept from the optimiser.
        everywhere: rows of clearance whose pairs have planes however far apart they are.
        expected: duration, s, that the weights of the jerks are for, once it is known: with other weights it would be
            another objective.
        smoothness: the factor on them, above 1 where only smoother motions keep some rows.
        excess: largest part of its limit by which a row on the final state was over it before the last back-off.
        crests: of the broken rows in the problem before the last back-off.
        margins: what rows keep along the motion beside that, for arms that are late, or of a motion that goes on from a
            state for what the second order adds.
    """

    task: Task
    scene: Scene
    members: frozenset[VariantId]
    refined: frozenset[str]
    modes: int
    rows: frozenset[RowId]
    possible: frozenset[RowId]
    backoff: Mapping[RowId, float]
    everywhere: frozenset[RowId] = frozenset()
    expected: float | None = None
    smoothness: Smoothness = AS_STATED
    excess: float = 0.0
    crests: Crests = field(default_factory=dict)
    margins: Mapping[RowId, Margin] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        task: Task,
        q: np.ndarray,
        members: frozenset[VariantId] | None = None,
        refined: frozenset[str] = frozenset(),
        modes: int = 0,
    ) -> ActiveSet:
        """All rows of some members, each with its first back-off.

        Args:
            task: the task.
            q: (m, n) rad, joint positions along the path.
            members: those in the problem; the stated variants of the outer objects when left out.
            refined: objects that carry more than one mode.
            modes: of those; 0 for as many as the optimiser carries at first.
        """
        members = task.first_members if members is None else members
        modes = modes or task.scene.planned_modes
        scene = task.problem_scene(members, refined, modes)
        apart = clearance_backoff(task.clearance_slack(q[[0, -1]]))
        rows = [RowId(item.name, subject) for item in constraints_of(scene) for subject in item.subjects(scene)] + [
            *apart
        ]
        left_out = set(task.ignored)
        if scene.leaves_time_alone:
            left_out.add(JointPosition.name)  # the path alone gives the joints, and the joint path keeps their ranges
        possible = frozenset(row for row in rows if row.constraint not in left_out)
        known = by_name(scene)
        backoff = {row: known[row.constraint].backoff for row in rows}
        backoff |= range_backoff(scene, q) | command_backoff(scene) | apart
        return cls(task, scene, members, refined, modes, possible - task.of_arm, possible, backoff)

    @property
    def names(self) -> dict[VariantId, str]:
        """What the members are called in the problem."""
        return {variant: name for variant, name in labels(self.task.variants).items() if variant in self.members}

    @property
    def membership(self) -> Members:
        """Which variants of objects are in the problem, and by which names."""
        return Members(self.names, self.task.speeds, self.task.model.cargo, self.task.at_once)

    def with_rows(self, rows: Iterable[RowId]) -> ActiveSet:
        """The same with these rows, as far as they may take part, and those on the final state, which cost little."""
        return replace(self, rows=self.possible.intersection(rows) | self.on_final_state)

    @property
    def on_final_state(self) -> frozenset[RowId]:
        """Rows on the final state."""
        known = by_name(self.scene)
        return frozenset(row for row in self.possible if known[row.constraint].evaluated_at is EvaluationPoint.END)

    def near(self, slack: Mapping[RowId, float], within: float = _NEAR) -> frozenset[RowId]:
        """Rows that come near their limits, by what part of each is left; of the arm with itself those it breaks."""
        of_arm = self.task.of_arm
        near = (row for row, value in slack.items() if value <= (min(within, 0.0) if row in of_arm else within))
        return frozenset(near) & self.possible

    @property
    def usual(self) -> frozenset[RowId]:
        """All rows that may take part, but those of the arm with itself that nothing has broken."""
        return self.possible - (self.task.of_arm - self.rows)

    def without_far(self, rows: Iterable[Row]) -> ActiveSet:
        """The same without the rows that stay far from their limits in a judged motion."""
        return self.with_rows(self.rows - {row.id for row in rows if row.use < 1.0 - _NEAR})

    def with_backoff(self, known: Mapping[RowId, float]) -> ActiveSet:
        """The same with at least the back-off that is known to be needed."""
        return replace(self, backoff={row: max(value, known.get(row, 0.0)) for row, value in self.backoff.items()})

    def increased(self) -> dict[str, float]:
        """Back-off above the first one, by the labels of the rows."""
        known, first = by_name(self.scene), command_backoff(self.scene)
        above = (
            (row, value) for row, value in self.backoff.items() if value > first.get(row, known[row.constraint].backoff)
        )
        return {row.label: value for row, value in above}

    def as_smooth_as(self, smoothness: Smoothness) -> ActiveSet:
        """The same with jerks of at least that weight; of another where late joints are stilled from then on."""
        begins = smoothness.stilled and not self.smoothness.stilled
        return replace(self, smoothness=smoothness) if begins or smoothness.factor > self.smoothness.factor else self

    @property
    def rings(self) -> bool:
        """Whether the joints may ring."""
        tracking = self.task.scene.tracking
        return tracking is not None and tracking.resonance is not None

    def with_less_margin(self) -> ActiveSet:
        """The same with half of what rows keep along the motion: for a problem that has no answer with all of it."""
        return replace(self, margins={row: replace(own, kept=0.5 * own.kept) for row, own in self.margins.items()})

    def labels_of(self, subject: str) -> list[str]:
        """What a subject of the certificate is called in the problem, each of its variants."""
        return [label for (name, _), label in self.names.items() if name == subject] or [subject]

    @property
    def driven(self) -> frozenset[str]:
        """Names in the problem of those whose waves of second order are among its states."""
        driven = self.task.driven & self.refined
        return frozenset(label for (name, _), label in self.names.items() if name in driven)

    @property
    def by_flow(self) -> frozenset[RowId]:
        """Rows on what is left of these, which the flow judges."""
        return frozenset(RowId(ResidualHeight.name, name) for name in self.driven)

    def judged_rows(self, judgement: Judgement) -> list[Row]:
        """The rows of every variant; what problems have as the judge has it, as they have it."""
        driven = self.task.driven
        return [as_carried(row) if row.subject in driven else row for row in judgement.variant_rows]

    def smoothed(self, rows: Iterable[Row]) -> ActiveSet:
        """The set with what heights of second order after the end ask for, where they are over their limits."""
        left = list(self.on_members(rows))
        over = beyond_crests(left, self.backoff, smooth=self.smoothness.factor > 1.0)
        backoff, smooth = with_room(left, self.backoff), self.as_smooth_as(self.smoothness.heavier(SECOND_ORDER, over))
        if self.scene.motion.duration is None and smooth is not self:
            at_end = {row: value for row, value in backoff.items() if row in self.on_final_state}
            return replace(smooth, backoff={**self.backoff, **at_end})
        lower = frozenset(row for row, value in backoff.items() if value > self.backoff[row])
        return replace(self, rows=self.rows | (lower & self.possible), backoff=backoff)

    def with_driven(self, judgement: Judgement) -> ActiveSet:
        """The set with waves of second order as states, after a motion that is smooth enough to begin with."""
        task = replace(self.task, smooth_first=False)
        return replace(self, smoothness=self.smoothness.with_waves_as_states)._begun_again(task, judgement)

    def without_driven(self, judgement: Judgement) -> ActiveSet:
        """The set of a task that stills waves of second order by smoothness alone; itself where they are no states."""
        if not self.task.may_be_driven:
            return self
        task = replace(self.task, smooth_alone=True, smooth_first=False)
        return self._begun_again(task, judgement)

    def _begun_again(self, task: Task, judgement: Judgement) -> ActiveSet:
        """The set of another task, with the same modes joined afresh."""
        kept = {row: value for row, value in self.backoff.items() if row not in self.on_final_state}
        begun = replace(self, task=task, refined=frozenset(), backoff=kept)
        return begun.joined(self.members, self.refined, judgement)

    def joined(self, members: frozenset[VariantId], refined: frozenset[str], judgement: Judgement) -> ActiveSet:
        """The set with other members and modes, with the back-off that is known and without the rows that stay far."""
        if refined and not self.refined and far_over(judgement.variant_rows, self.task.driven):
            return replace(self, task=replace(self.task, smooth_first=True)).joined(members, refined, judgement)
        rows = [row for row in self.judged_rows(judgement) if row.constraint not in self.task.ignored]
        smooth = self.smoothed(rows)
        grown = ActiveSet.of(self.task, judgement.replay.joint_position, members, refined, self.modes)
        grown = replace(grown, rows=grown.rows | (self.rows & self.task.of_arm))
        fresh = {label for (name, _), label in grown.names.items() if name in refined - self.refined}
        rises = smooth.smoothness.factor > self.smoothness.factor
        of_sum = backoff_with_room(_OF_SUM, 1.0) if rises else _OF_SUM
        driven = grown.driven
        residual = {RowId(ResidualHeight.name, own): FIRST_BACKOFF if own in driven else of_sum for own in fresh}
        spent = dict.fromkeys(self.membership.saturated_at_end(self.backoff), _OF_SUM)
        grown = grown.with_backoff({**smooth.backoff, **spent}).with_backoff(residual)
        own = list(grown.on_members(self.judged_rows(judgement), own=True))
        if not rises:  # else those crests say little of smoother waves
            grown = grown.with_backoff(backoff_by_order(own, grown.backoff))
        grown = replace(grown, expected=self.expected, smoothness=smooth.smoothness, margins=self.margins)
        return grown.without_far(own)

    def near_members(self, judgement: Judgement) -> frozenset[VariantId]:
        """Of every constraint and object the variant that comes nearest to a limit in a judged motion, if it does."""
        return self.outside(judgement.variant_rows, 1.0 - _NEAR_MEMBER, judgement)

    def outside(self, rows: Iterable[Row], use: float, judgement: Judgement) -> frozenset[VariantId]:
        """Variants outside of which a constraint has a use above `use`."""
        t, outer = judgement.replay.t, self.task.outer
        return self.membership.missing(rows, above=use, outer=outer, backoff=self.backoff, t=t)

    def on_members(self, rows: Iterable[Row], *, own: bool = False) -> Iterator[Row]:
        """Rows by the names that their subjects have in the problem; `own`: of the members alone."""
        return self.membership.attributed(rows, own=own)
