"""The active part of a problem: constraint generation and constraint tightening as one value.

Most objects, variants and rows never come near a limit, and an interior point method pays for each at every iteration.
So a problem holds some of them; the certificate is about all; what it finds violated joins the problem, and what is in
the problem already gets a larger back-off.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from nospill.certification.certificate import Judgement
from nospill.certification.verdict import Row
from nospill.laws.constraints import END_NAMES, by_name, constraints_of
from nospill.laws.constraints.base import EvaluationPoint, RowId
from nospill.laws.constraints.clearance import Clearance, clearance_backoff
from nospill.laws.constraints.joint_jerk import command_backoff
from nospill.laws.constraints.joint_position import JointPosition, range_backoff
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.planning.driven_waves import (
    FIRST_BACKOFF,
    as_carried,
    beyond_backoff_of_flow,
    far_over,
    relaxed_by_flow,
    smooth_enough,
    steadier_backoff,
)
from nospill.planning.members import (
    Crests,
    Members,
    backoff_by_order,
    crests_of,
    growths_by_order,
    relaxed_by_order,
    tightened,
    uses_of,
    without_ease,
)
from nospill.planning.second_order import beyond_crests, by_modes, taken_by_order, with_room
from nospill.planning.smoothness import AS_STATED, FLOW, OTHER_MODES, SECOND_ORDER, Smoothness
from nospill.planning.task import Task
from nospill.planning.tightening import (
    ROUGH,
    backoff_with_room,
    beyond_backoff,
    relaxed_backoff,
    shared_backoff,
)
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
from nospill.scene.scene import Scene
from nospill.scene.variants import VariantId, labels
from nospill.transcription.margins_along import Margin
from nospill.transcription.problem import EASED

_NEAR = 0.3
"""Rows with this part of their limit left, or less, are near it."""
_NEAR_MEMBER = 0.02
"""Variants with this part of a limit left in an earlier plan are in the problem from the start."""
_SLIGHT = 5e-3
"""Part of a limit by which what is not in the problem may exceed it before it joins: a larger problem costs more."""
_SLIGHT_OF_REFINED = 0.5
"""The same once liquids are in it with several modes, where a variant more costs as much as three."""
_OF_LAW = 5e-3
"""Part of its limit by which the linear part of a height may exceed what a problem leaves to it before modes join."""
_OF_SUM = 0.3
"""Back-off of a residual height with which modes join: the judge finds their sum, the optimiser the root of squares."""
_FAR = 0.05
"""Part of a limit; a motion that is over one by more as planned is made for the arm as stated first."""
_MOST_MODES = 6
"""Most modes of a liquid in a problem."""
_LIGHTER = 0.85
"""Part of the weights of the jerks that a motion that holds over a band of late arms has to promise for more solves."""


def _far_over(judgement: Judgement) -> bool:
    """Whether a motion breaks limits as planned by more than back-off takes away."""
    return any(row.use > 1.0 + _FAR for row in judgement.variant_rows)


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
    def _members(self) -> Members:
        return Members(self.names, self.task.speeds, self.task.model.cargo, self.task.at_once)

    def with_rows(self, rows: Iterable[RowId]) -> ActiveSet:
        """The same with these rows, as far as they may take part, and those on the final state, which cost little."""
        return replace(self, rows=self.possible.intersection(rows) | self._final)

    @property
    def _final(self) -> frozenset[RowId]:
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

    def after(self, judgement: Judgement, slack: Mapping[RowId, float] = MappingProxyType({})) -> ActiveSet:
        """What the next problem has to hold after a motion was judged; itself where there is nothing to act on.

        Where the joints may be late, what the rows are to keep for that too, beside what follows from the motion as
        planned.
        """
        following, band = self._after(judgement, slack), judgement.band
        if band is None or (max(band.use.values(), default=0.0) <= 1.0 and following is self):
            return following
        names, first, rings = following.names, not self.margins, self.rings
        planned, uses = uses_of(judgement.planned_rows), uses_over(band, names)
        lowered: dict[RowId, float] = {}
        if not (first or rings):
            lowered = lowered_at_end(self.backoff, band, uses_of(self._on_members(judgement.planned_rows)), self.names)
        left = {row: use for row, use in band.use.items() if lowered.keys().isdisjoint(of_members(row, names))}
        smooth = smoother(self.smoothness, left, planned, rings=rings, margins=not first)
        if not rings:
            following = following.as_smooth_as(smooth)
        if following.scene is not self.scene or (first and _far_over(judgement)):
            return following  # what the arm does as it is stated comes first
        if rings:
            following = following.as_smooth_as(smooth)
            if rings_far(band, self.smoothness):
                return following
        growths, stilled = self._growths(judgement), self.smoothness.stilled
        backoff = following.backoff if first else raised_backoff(following.backoff, band, names, growths)
        if not stilled:  # there crests are what is nearest to its limit: what one gets back it would ask for again
            backoff = {**backoff, **relaxed_by_order(self._on_members(judgement.planned_rows), backoff, uses)}
        backoff = {**backoff, **{row: max(value, backoff[row]) for row, value in lowered.items()}}
        found = margins_over(band, names, judgement.end_time, backoff, growths)
        margins = half_way(found, self.margins) if rings else falling(found, self.margins, uses if stilled else {})
        rows = following.rows | (joining(band, names) & following.possible)
        return replace(following, rows=rows, margins=margins, backoff=backoff)

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

    def _after(self, judgement: Judgement, slack: Mapping[RowId, float]) -> ActiveSet:
        """`after` for the arm as it is stated.

        Modes join first, of the liquids that break a limit, and objects without members; where modes that are left out
        swing too far at the end, or waves of second order do, the jerks weigh more. Then members join, the worst of
        `missing`. Where there is none, violated rows join, those in the problem get a larger back-off, and `far_peaks`
        join, which that does not reach.
        """
        found = [row for row in self._judged(judgement) if row.constraint not in self.task.ignored]
        if self.task.smooth_first and self.refined and smooth_enough(found, self.task.may_be_driven):
            return self._with_driven(judgement)
        rows = [by_modes(row) for row in found]
        smooth = self._smoothed(found)
        refined = self.refined | self._too_coarse(rows)
        if refined != self.refined:
            alone = self._outside(rows, np.inf, judgement)
            return self.joined(self.members | alone, refined.union(name for name, _ in alone), judgement)
        uses = uses_of(self._on_members(rows, own=True))
        driven = self._driven
        at_end = {row: use for row, use in uses.items() if row.constraint in END_NAMES and row.subject not in driven}
        over = beyond_backoff(at_end, self.backoff, self.excess) if refined else 0.0
        modes = min(2 * self.modes, _MOST_MODES, self.task.scene.slosh_modes)
        if 1.0 < over <= ROUGH and modes > self.modes:
            kept = {row: value for row, value in self.backoff.items() if row not in self._final}
            return replace(self, modes=modes, backoff=kept).joined(self.members, refined, judgement)
        smooth = smooth.as_smooth_as(self.smoothness.heavier(OTHER_MODES, over))
        left = beyond_backoff_of_flow(self._on_members(rows), driven, self.backoff)
        by_flow = self.smoothness.heavier(FLOW, left)
        if by_flow.factor > smooth.smoothness.factor:
            raised = steadier_backoff(self._on_members(rows), driven, self.backoff)
            return replace(self, smoothness=by_flow, backoff=raised)
        if smooth.smoothness is not self.smoothness:
            return smooth
        outside = self._outside(rows, 1.0 + (_SLIGHT_OF_REFINED if refined else _SLIGHT), judgement)
        if outside:
            return self.joined(self.members | outside, refined | {name for name, _ in outside if refined}, judgement)
        broken = self._within_ranges(list(self._on_members(row for row in rows if row.shortfall > 0.0)))
        margins = self._of_waves(judgement)
        crests = [row for row in broken if row.id in margins]
        broken = [row for row in broken if row.id not in margins]
        backoff, joining = tightened(broken, self.rows, smooth.backoff, slack, self.crests)
        if self.scene.initial_state is not None:
            backoff = without_ease(broken, backoff, self.backoff, EASED * judgement.end_time)
        far = self._members.far_peaks(rows, judgement.replay.t)
        if far:
            return replace(self, backoff=backoff).joined(self.members | far, refined, judgement)
        backoff = shared_backoff(backoff, self.backoff, uses)
        if not joining and not crests and backoff == self.backoff:
            return self
        # bodies that touch in spite of their planes have none where they do: more back-off would move nothing
        touching = {row.id for row in broken if row.worst_margin < 0.0} & self.rows & self.task.around_solids
        return replace(
            self,
            rows=smooth.rows | joining | {row.id for row in crests},
            backoff=backoff,
            margins={**self.margins, **margins} if crests else self.margins,
            excess=max(at_end.values(), default=1.0) - 1.0,
            crests=crests_of(broken, self.backoff),
            everywhere=self.everywhere | touching,
        )

    def _of_waves(self, judgement: Judgement) -> dict[RowId, Margin]:
        """What heights keep along a motion that goes on from a state for what the second order adds; else none."""
        if self.scene.initial_state is None:
            return {}
        return margins_of_waves(self.backoff, self.margins, judgement, self.labels_of)[0]

    def labels_of(self, subject: str) -> list[str]:
        """What a subject of the certificate is called in the problem, each of its variants."""
        return [label for (name, _), label in self.names.items() if name == subject] or [subject]

    def _growths(self, judgement: Judgement) -> dict[RowId, float]:
        """Of the heights of second order how much more they fall than their linear parts, which the problem has."""
        return growths_by_order(self._on_members(judgement.planned_rows))

    @property
    def _driven(self) -> frozenset[str]:
        """Names in the problem of those whose waves of second order are among its states."""
        driven = self.task.driven & self.refined
        return frozenset(label for (name, _), label in self.names.items() if name in driven)

    def _judged(self, judgement: Judgement) -> list[Row]:
        """The rows of every variant; what problems have as the judge has it, as they have it."""
        driven = self.task.driven
        return [as_carried(row) if row.subject in driven else row for row in judgement.variant_rows]

    def _smoothed(self, rows: Iterable[Row]) -> ActiveSet:
        """The set with what heights of second order after the end ask for, where they are over their limits."""
        left = list(self._on_members(rows))
        over = beyond_crests(left, self.backoff, smooth=self.smoothness.factor > 1.0)
        backoff, smooth = with_room(left, self.backoff), self.as_smooth_as(self.smoothness.heavier(SECOND_ORDER, over))
        if self.scene.motion.duration is None and smooth is not self:
            at_end = {row: value for row, value in backoff.items() if row in self._final}
            return replace(smooth, backoff={**self.backoff, **at_end})
        lower = frozenset(row for row, value in backoff.items() if value > self.backoff[row])
        return replace(self, rows=self.rows | (lower & self.possible), backoff=backoff)

    def _within_ranges(self, broken: list[Row]) -> list[Row]:
        """Broken rows without the distances that are not in the problem, while a joint leaves its range.

        What bodies touch there is no matter of a motion within the ranges, and no plane parts bodies that start far
        inside each other.
        """
        if all(row.constraint != JointPosition.name or row.id in self.rows for row in broken):
            return broken
        return [row for row in broken if row.constraint != Clearance.name or row.id in self.rows]

    def relaxed(self, judgement: Judgement) -> ActiveSet:
        """The set without most of the back-off that a certified motion shows to be more than is needed."""
        own, band = list(self._on_members(self._judged(judgement), own=True)), judgement.band
        over = {} if band is None else uses_over(band, self.names)
        uses = uses_of(row for row in own if row.linear_value is None)
        relaxed = relaxed_backoff(self.backoff, {row: max(use, over.get(row, 0.0)) for row, use in uses.items()})
        relaxed = {**relaxed, **relaxed_by_order(own, self.backoff, over)}
        if self.smoothness.factor <= 1.0:  # of smoother motions crests say little of what is left
            relaxed = relaxed_by_flow(relaxed, own, self._driven, self.backoff)
        return replace(self, backoff=relaxed)

    def lightened(self, judgement: Judgement) -> ActiveSet:
        """The set with jerks that weigh less, after a motion that holds; itself where they are not known to weigh much.

        With the margins that a motion over a band of arms needs, and of crests of second order what it does not.
        """
        if self.margins and judgement.band is not None:
            growths = self._growths(judgement)
            margins = margins_over(judgement.band, self.names, judgement.end_time, self.backoff, growths)
            if self.smoothness.stilled:
                margins = half_way(margins, self.margins)
            light = rougher(self.smoothness, judgement.band.use, rings=self.rings)
            before = self.smoothness.factor
            worth = self.rings or before == 1.0 or light.factor < _LIGHTER * before
            return replace(self, margins=margins, smoothness=light) if worth else self
        if self.task.smooth_first:
            return self._with_driven(judgement)
        own = list(self._on_members(self._judged(judgement)))
        light = self.smoothness.lighter(SECOND_ORDER, taken_by_order(own))
        if light.factor == self.smoothness.factor:
            return self
        return replace(self, smoothness=light, backoff={**self.backoff, **relaxed_by_order(own, self.backoff)})

    def _with_driven(self, judgement: Judgement) -> ActiveSet:
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
        kept = {row: value for row, value in self.backoff.items() if row not in self._final}
        begun = replace(self, task=task, refined=frozenset(), backoff=kept)
        return begun.joined(self.members, self.refined, judgement)

    def joined(self, members: frozenset[VariantId], refined: frozenset[str], judgement: Judgement) -> ActiveSet:
        """The set with other members and modes, with the back-off that is known and without the rows that stay far."""
        if refined and not self.refined and far_over(judgement.variant_rows, self.task.driven):
            return replace(self, task=replace(self.task, smooth_first=True)).joined(members, refined, judgement)
        rows = [row for row in self._judged(judgement) if row.constraint not in self.task.ignored]
        smooth = self._smoothed(rows)
        grown = ActiveSet.of(self.task, judgement.replay.joint_position, members, refined, self.modes)
        grown = replace(grown, rows=grown.rows | (self.rows & self.task.of_arm))
        fresh = {label for (name, _), label in grown.names.items() if name in refined - self.refined}
        rises = smooth.smoothness.factor > self.smoothness.factor
        of_sum = backoff_with_room(_OF_SUM, 1.0) if rises else _OF_SUM
        driven = grown._driven
        residual = {RowId(ResidualHeight.name, own): FIRST_BACKOFF if own in driven else of_sum for own in fresh}
        spent = dict.fromkeys(self._members.saturated_at_end(self.backoff), _OF_SUM)
        grown = grown.with_backoff({**smooth.backoff, **spent}).with_backoff(residual)
        own = list(grown._on_members(self._judged(judgement), own=True))
        if not rises:  # else those crests say little of smoother waves
            grown = grown.with_backoff(backoff_by_order(own, grown.backoff))
        grown = replace(grown, expected=self.expected, smoothness=smooth.smoothness, margins=self.margins)
        return grown.without_far(own)

    def _too_coarse(self, rows: Iterable[Row]) -> frozenset[str]:
        """Members whose liquid breaks a limit, where the optimiser may carry more than one mode.

        Of a height of second order its linear part counts, and what of its limit the problem left to that.
        """
        broken = {row.subject for row in rows if row.of_liquid and self._is_over_law(row)}
        return frozenset(name for name, _ in self.members if name in broken and self.task.scene.planned_modes > 1)

    def _is_over_law(self, row: Row) -> bool:
        """Whether a liquid breaks a limit by more than what the optimiser's law leaves out."""
        if row.linear_value is None or row.shortfall <= 0.0:
            return row.shortfall > 0.0
        labels = [label for (name, _), label in self.names.items() if name == row.subject]
        kept = max((self.backoff.get(RowId(row.constraint, label), 0.0) for label in labels), default=0.0)
        return row.linear_value > (1.0 + _OF_LAW - kept) * row.limit

    def near_members(self, judgement: Judgement) -> frozenset[VariantId]:
        """Of every constraint and object the variant that comes nearest to a limit in a judged motion, if it does."""
        return self._outside(judgement.variant_rows, 1.0 - _NEAR_MEMBER, judgement)

    def _outside(self, rows: Iterable[Row], use: float, judgement: Judgement) -> frozenset[VariantId]:
        """Variants outside of which a constraint has a use above `use`."""
        t, outer = judgement.replay.t, self.task.outer
        return self._members.missing(rows, above=use, outer=outer, backoff=self.backoff, t=t)

    def _on_members(self, rows: Iterable[Row], *, own: bool = False) -> Iterator[Row]:
        """Rows by the names that their subjects have in the problem; `own`: of the members alone."""
        return self._members.attributed(rows, own=own)
