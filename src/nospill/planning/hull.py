"""Planning with many like objects: those in the middle of others follow.

The tray's motion at a point is linear in the point's place, a liquid answers to it nearly linearly, and every limit of
an object is a cone or a convex height. So what holds for like objects holds for one that stands in the convex hull of
their places, nearly to the last digit: of a tray of 32 like cups four matter. The judge looks at all of them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from nospill.errors import MOTION, NoSolutionError, Reason
from nospill.judge.certificate import Judgement
from nospill.judge.verdict import Row, condensed
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.parameters import flatten
from nospill.laws.scene_parameters import object_numbers
from nospill.motion.trajectory import SloshTrack, Trajectory
from nospill.planning.growth import GrowingRun
from nospill.planning.reserves import falls_short
from nospill.planning.run import PlanningRun, Progress
from nospill.plans.plan import describe
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene

_DIGITS = 12
_SLIGHT = 5e-3
"""What an object that is not in the problem may exceed a limit by, as a part of it, for reserves to see to it."""


def hull_run(scene: Scene, progress: Progress | None, ignored: frozenset[str]) -> PlanningRun:
    """A run for a scene; where objects stand in the middle of like ones, one that leaves them to the judge."""
    chosen = outer_objects(scene)
    if len(chosen) == len(scene.cargo):
        return PlanningRun(scene, progress, ignored)
    return HullRun(replace(scene, cargo=chosen), progress, ignored, whole=scene, payload=scene.cargo)


def outer_objects(scene: Scene) -> tuple[Cargo, ...]:
    """The objects of a scene but those that stand in the convex hull of others just like them."""
    groups: dict[tuple[float, ...], list[int]] = {}
    for index, cargo in enumerate(scene.cargo):
        numbers = replace(object_numbers(cargo, scene), position=np.zeros(3))
        key = tuple(float(f"{value:.{_DIGITS}g}") for value in flatten(numbers))
        groups.setdefault((*key, float(len(numbers.oscillators))), []).append(index)
    outer: set[int] = set()
    for members in groups.values():
        places = np.array([scene.cargo[index].position for index in members])
        outer |= {members[vertex] for vertex in _vertices(places)}
    return tuple(cargo for index, cargo in enumerate(scene.cargo) if index in outer)


def _vertices(places: np.ndarray) -> Iterable[int]:
    """Indices of the corners of the convex hull of places (m, 2)."""
    lowest, highest = places.min(axis=0), places.max(axis=0)
    if len(places) < 3 or np.all((places == lowest) | (places == highest)):  # all at corners of one rectangle
        return range(len(places))
    from scipy.spatial import ConvexHull, QhullError  # slow to load

    try:
        return (int(vertex) for vertex in ConvexHull(places).vertices)
    except QhullError:  # all on one line: its ends
        spread = places - places.mean(axis=0)
        along = spread @ np.linalg.svd(spread)[2][0]
        return {int(np.argmin(along)), int(np.argmax(along))}


@dataclass(slots=True, kw_only=True)
class HullRun(GrowingRun[str]):
    """A run whose scene holds the outer objects, and those that the judge asked for, by their names."""

    def trial(self, scene: Scene) -> PlanningRun:
        """A run of its own on the outer objects of a scene; what it learns does not come back."""
        if {cargo.name for cargo in scene.cargo} <= {cargo.name for cargo in self.scene.cargo}:
            return PlanningRun.trial(self, scene)
        other = PlanningRun.trial(self, replace(scene, cargo=outer_objects(scene)))
        other.payload = scene.cargo
        return other

    def missing(self, judgement: Judgement) -> set[str]:
        """The objects that fail and are not in the problem, but what is slight."""
        return {row.subject for row in self._outside(judgement) if row.use > 1.0 + _SLIGHT}

    def choose(self, wanted: Iterable[str]) -> None:
        """Take objects into the problem."""
        names = {cargo.name for cargo in self.scene.cargo} | set(wanted)
        self.set_cargo(tuple(cargo for cargo in self.whole.cargo if cargo.name in names))

    def problem_rows(self, judgement: Judgement) -> list[Row]:
        """All rows: those of objects that are left out are not looked for."""
        return list(judgement.certificate.rows)

    def start_tracks(self, trajectory: Trajectory) -> dict[str, SloshTrack]:
        """The liquids as recorded."""
        return trajectory.slosh

    def nothing_holds(self, trajectory: Trajectory, judgement: Judgement) -> NoSolutionError:
        """A motion was found for the outer objects, but none with one in their midst."""
        worst = judgement.certificate.worst
        return NoSolutionError(
            f"No motion found, though there is one of {trajectory.end_time:.3g} s without an object in the middle of "
            f"others: there {describe(worst)}. Relax that limit.",
            Reason(MOTION, worst.constraint, worst.subject, excess=worst.use - 1.0),
        )

    def _outside(self, judgement: Judgement) -> list[Row]:
        """Rows that fail, or come too near to it, of objects that are not in the problem."""
        others = {cargo.name for cargo in self.whole.cargo} - {cargo.name for cargo in self.scene.cargo}
        return [
            row
            for row in judgement.certificate.rows
            if row.subject in others and falls_short(row) and row.constraint not in self.ignored
        ]

    def _objections(self, judgement: Judgement) -> list[Row]:
        """Rows of the problem that fail; what an object outside exceeds slightly is laid to all those within."""
        if self.missing(judgement):
            return []
        subjects = {constraint.name: constraint.subjects(self.scene) for constraint in CONSTRAINTS}
        outside = self._outside(judgement)
        shared = [replace(row, subject=name) for row in outside for name in subjects[row.constraint]]
        own = [row for row in PlanningRun._objections(self, judgement) if row not in outside]
        return list(condensed(own + shared))
