"""What a search is for: the scene, what of it may be in the problem, and how the arm passes its singularities."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

from nospill.laws.constraints.residual_height import EndDisplacement
from nospill.laws.like_objects import outer_objects
from nospill.robots.joint_paths.search import JointPath
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene
from nospill.scene.tolerances import heaviest, is_uncertain
from nospill.scene.variants import Variant, variants_by_object
from nospill.transcription.guess import USUAL_START, Start, estimate_duration, resolving_intervals, smooth_start
from nospill.transcription.passages import NOT_BOUNDED, Passage
from nospill.transcription.stages import Stages

_COARSEST = 25
_COARSE_SWING = 2.5

Member = tuple[str, str]
"""Name of an object and text of its variant."""


def starting_motion(scene: Scene, joint_path: JointPath, start: Start = USUAL_START) -> Stages:
    """A smooth motion along the path on the coarse grid."""
    fewest = resolving_intervals(scene, estimate_duration(scene, joint_path), _COARSE_SWING)
    return smooth_start(scene, joint_path, max(_COARSEST, scene.planning.intervals // 4, fewest), start)


@dataclass(frozen=True, slots=True)
class Task:
    """A scene to be planned.

    Attributes:
        scene: as requested, which the certificate is about.
        families: of each object its variants, the stated one first; one alone where its numbers are certain.
        payload: what the flange carries: the objects, each as heavy as its tolerance allows.
        ignored: names of constraints that the problem leaves out.
        passage: how the arm passes its singularities.
    """

    scene: Scene
    families: tuple[tuple[Variant, ...], ...]
    payload: tuple[Cargo, ...]
    ignored: frozenset[str] = frozenset()
    passage: Passage = NOT_BOUNDED

    @classmethod
    def of(cls, scene: Scene, ignored: Collection[str] = ()) -> Task:
        """The task of a scene, its singularities not looked at yet."""
        if is_uncertain(scene):
            return cls(scene, variants_by_object(scene), heaviest(scene), frozenset(ignored))
        families = tuple((Variant(cargo.name, "", cargo),) for cargo in scene.cargo)
        return cls(scene, families, scene.cargo, frozenset(ignored))

    def names(self) -> dict[Member, str]:
        """What every variant is called in a problem and in messages; the stated one has the name of its object."""
        return {
            (variant.name, variant.text): variant.name if variant is family[0] else variant.label
            for family in self.families
            for variant in family
        }

    @property
    def first_members(self) -> frozenset[Member]:
        """What a problem begins with: the stated variants of the outer ones of like objects."""
        outer = {cargo.name for cargo in outer_objects(self.scene)}
        return frozenset((first.name, first.text) for first, *_ in self.families if first.name in outer)

    @property
    def searched_scene(self) -> Scene:
        """The scene with a level tray where only that passes the singularities."""
        scene = self.scene
        return replace(scene, motion=replace(scene.motion, tilt_free=False)) if self.passage.level else scene

    def problem_scene(self, members: Collection[Member]) -> Scene:
        """The scene of a problem with some variants of some objects, certain and in the order of the families."""
        names = self.names()
        chosen = [
            (names[item.name, item.text], item.cargo)
            for family in self.families
            for item in family
            if (item.name, item.text) in members
        ]
        cargo = [own if own.name == name else replace(own, name=name) for name, own in chosen]
        scene = self.searched_scene
        if EndDisplacement.name in self.ignored:
            # Its equalities are bounds of the variables, which only another end condition takes away.
            scene = replace(scene, motion=replace(scene.motion, end="residual"))
        same = len(cargo) == len(scene.cargo) and all(a is b for a, b in zip(cargo, scene.cargo, strict=True))
        return scene if same else replace(scene, cargo=tuple(cargo))
