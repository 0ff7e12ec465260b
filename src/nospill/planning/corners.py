"""Planning where numbers of the objects may be off: the variants that matter are objects of the optimiser.

The search knows every object once, at its stated numbers with the least friction. The judge looks at all corners;
variants he objects to take the place of the object in the problem, which is solved again from the motion at hand, until
he objects to none. Few of them ever matter, and an iteration with all of them takes many times as long.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass, field, replace

from nospill.errors import MOTION, NoSolutionError, Reason
from nospill.judge.certificate import Judgement, judge
from nospill.judge.verdict import Row, condensed
from nospill.motion.trajectory import SloshTrack, Trajectory
from nospill.planning.growth import GrowingRun, tracks
from nospill.planning.reserves import falls_short
from nospill.planning.run import Memory, PlanningRun, Progress
from nospill.plans.plan import Plan, describe
from nospill.scene.scene import Scene
from nospill.scene.tolerances import Variant, corner_scenes, heaviest, is_uncertain, scene_variants, spread, spread_name
from nospill.transcription.solvers import Solution

_SLIGHT = 5e-3
"""What a variant that is not in the problem may exceed a limit by, as a part of it, for reserves to see to it: a
larger problem costs more than they do."""

_NEAR = 0.02
"""Variants that come this near a limit in an earlier plan are in the problem from the start."""

Key = tuple[str, str]
"""Name of an object and text of its variant."""


def corner_run(scene: Scene, progress: Progress | None, ignored: frozenset[str]) -> CornerRun:
    """A run for a scene with tolerances."""
    families = scene_variants(scene)
    stated = tuple(family[0] for family in families)
    return CornerRun(
        stated_scene(scene), progress, ignored, whole=scene, payload=heaviest(scene), families=families, chosen=stated
    )


def stated_scene(scene: Scene) -> Scene:
    """The scene at its stated numbers, certain, with the least friction.

    Friction is lowered by the reserve, so that whoever reads the scene still finds the coefficient as stated.
    """
    if not is_uncertain(scene):
        return scene
    cargo = []
    for item in scene.cargo:
        least = 0.0 if item.tolerance is None else item.tolerance.friction
        reserve = 1.0 - (1.0 - item.friction_reserve) * (1.0 - least)
        cargo.append(replace(item, friction_reserve=reserve, tolerance=None))
    return replace(scene, cargo=tuple(cargo))


@dataclass(slots=True, kw_only=True)
class CornerRun(GrowingRun[Key]):
    """A run whose scene holds the chosen variants.

    Attributes:
        families: all variants of each object, the stated one first.
        chosen: those in the problem.
        asked_for: name and text of those that are there for good.
    """

    families: tuple[tuple[Variant, ...], ...]
    chosen: tuple[Variant, ...]
    asked_for: set[Key] = field(default_factory=set)

    def trial(self, scene: Scene) -> PlanningRun:
        """A run of its own on a scene at its stated numbers; what it learns does not come back."""
        other = PlanningRun.trial(self, stated_scene(scene))
        if is_uncertain(scene):
            other.payload = heaviest(scene)
        return other

    def restart(self, earlier: Plan, memory: Memory | None) -> Solution | None:
        """Solve from an earlier plan with the variants that come near a limit in it; None where that fails."""
        with self.phase("certify"):
            judgement = judge(self.recorded(earlier.trajectory), self.whole)  # its liquids may be others
        near = self._worst(judgement, 1.0 - _NEAR)
        self.choose(near - {_key(family[0]) for family in self.families})
        self.rows.recall(earlier.report.reserves)
        self.tried += 1
        found = self.solved_from(earlier.trajectory, judgement)
        if found is None:
            self.asked_for.clear()
            self.choose(())
            return None
        self.durations.append(found.stages.duration)
        return found

    def _objections(self, judgement: Judgement) -> list[Row]:
        """Rows that fail or come too near to it, by the names of the problem's objects.

        There are none while a variant is missing in the problem.
        What a variant that is not in the problem exceeds slightly is laid to the account of all that stand for it.
        """
        if self.missing(judgement):
            return []
        inside = {item.name: [variant for variant in self.chosen if variant.name == item.name] for item in self.chosen}
        found = [row for row in judgement.certificate.rows if falls_short(row) and row.subject not in inside]
        names = self._names()
        for row in judgement.corners:
            for variant in inside.get(row.subject, ()) if falls_short(row) else ():
                if row.variant == variant.text or (row.subject, row.variant) not in names:
                    found.append(replace(row, subject=names[_key(variant)], variant=""))
        return list(condensed(found))

    def _names(self) -> dict[Key, str]:
        """What the chosen variants are called in the problem; an object at its stated numbers keeps its name."""
        stated = {_key(family[0]) for family in self.families}
        return {key: key[0] if key in stated else spread_name(*key) for key in map(_key, self.chosen)}

    def missing(self, judgement: Judgement) -> set[Key]:
        """Of every constraint and object the worst variant that fails and is not in the problem: (name, text)."""
        return self._worst(judgement, 1.0 + _SLIGHT, {_key(item) for item in self.chosen})

    def _worst(self, judgement: Judgement, use: float, known: Collection[Key] = ()) -> set[Key]:
        """Of every constraint and object the variant that uses most of the limit, if it uses more than `use`.

        Those in `known` are left out.
        """
        wanted = {_key(item) for family in self.families for item in family}.difference(known)
        rows = [row for row in judgement.corners if row.use > use and row.constraint not in self.ignored]
        return {
            (row.subject, row.variant) for row in condensed(row for row in rows if (row.subject, row.variant) in wanted)
        }

    def choose(self, wanted: Iterable[Key]) -> None:
        """Take variants into the problem, with the reserves that are known.

        The stated object leaves it where another one stands for it, and comes back for good if it is asked for.
        """
        self.asked_for |= set(wanted)
        chosen: list[Variant] = []
        for family in self.families:
            chosen += [item for item in family if _key(item) in self.asked_for] or [family[0]]
        self.chosen = tuple(chosen)
        stated, names = {item.name: item for item in stated_scene(self.whole).cargo}, self._names()
        several = spread(self.whole, self.chosen).cargo
        cargo = [stated.get(names[_key(item)], own) for item, own in zip(chosen, several, strict=True)]
        self.set_cargo(tuple(cargo))

    def problem_rows(self, judgement: Judgement) -> list[Row]:
        """The rows of the variants in the problem, and those that are of no object."""
        names = self._names()
        known = [row for row in judgement.corners if (row.subject, row.variant) in names]
        objects = {cargo.name for cargo in self.whole.cargo}
        others = [row for row in judgement.certificate.rows if row.subject not in objects]
        return [replace(row, subject=names[row.subject, row.variant]) for row in known] + others

    def start_tracks(self, trajectory: Trajectory) -> dict[str, SloshTrack]:
        """The liquids of the variants in the problem."""
        names, found = self._names(), dict[str, SloshTrack]()
        for corner in corner_scenes(self.whole):
            wanted = {key[0]: names[key] for key in corner.texts.items() if key in names}
            found |= tracks(trajectory, corner.scene, wanted) if wanted else {}
        return found

    def nothing_holds(self, trajectory: Trajectory, judgement: Judgement) -> NoSolutionError:
        """A motion was found for the stated numbers, but none with the variants."""
        worst = judgement.certificate.worst
        return NoSolutionError(
            "No motion found that holds over the tolerances, though there is one of "
            f"{trajectory.end_time:.3g} s without those in the way: there {describe(worst)}. "
            "Narrow the tolerance or relax that limit.",
            Reason(MOTION, worst.constraint, worst.subject, excess=worst.use - 1.0),
        )


def _key(variant: Variant) -> Key:
    return variant.name, variant.text
