"""A scene to be planned, and the scenes of its problems: some variants of some objects, with some of their modes."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from nospill.collisions.along_path import least_slack
from nospill.collisions.pairs import scene_pairs
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.clearance import Clearance
from nospill.laws.constraints.residual_height import EndDisplacement
from nospill.laws.like_objects import hull_objects, least_tolerant_objects
from nospill.scene.cargo import Cargo
from nospill.scene.carriers import with_modes
from nospill.scene.heights import by_nonlinear_flow
from nospill.scene.scene import Scene
from nospill.scene.tolerances import heaviest
from nospill.scene.variants import Variant, VariantId, scene_of, variants_by_object
from nospill.transcription.passages import NOT_BOUNDED, Passage

_MOST_OBJECTS = 8
"""Most objects that a problem begins with: the time of a step grows with their cube."""
_MANY, _FEW = 40, 2
"""Outer objects beyond which a problem begins with so few, and as few join at once: of many, neighbours in frequency
swing alike, and to hold them all still at the end is next to asking for the same again and again."""
_AT_ONCE = 4
"""Objects that join a problem at once for one constraint: where the worst ones keep it, most others do."""
_EXCITED = 2.0
"""Frequencies up to which modes of slowed liquids are carried, over the greatest one that is carried at full speed."""


@dataclass(frozen=True, slots=True)
class Task:
    """A scene to be planned.

    Attributes:
        scene: as requested, which the certificate is about, with all modes of its liquids.
        model: the same with one mode of each, with which a search begins.
        variants: of each object, the stated one first; one alone where its numbers are certain.
        payload: what the flange carries: the objects, each as heavy as its tolerance allows.
        outer: objects that no like ones stand for.
        ignored: names of constraints that the problem leaves out.
        passage: how the arm passes its singularities.
        smooth_first: whether waves of second order are kept out of its problems until a motion is smooth enough.
        smooth_alone: whether they are kept out of all, since no problem with them led to a certified motion.
    """

    scene: Scene
    model: Scene
    variants: tuple[tuple[Variant, ...], ...]
    payload: tuple[Cargo, ...]
    outer: frozenset[str]
    ignored: frozenset[str] = frozenset()
    passage: Passage = NOT_BOUNDED
    smooth_first: bool = False
    smooth_alone: bool = False

    @classmethod
    def of(cls, scene: Scene, ignored: Collection[str] = ()) -> Task:
        """The task of a scene, its singularities not looked at yet."""
        model = scene.with_one_mode()
        outer = frozenset(cargo.name for cargo in hull_objects(model))
        return cls(scene, model, variants_by_object(model), heaviest(model), outer, frozenset(ignored))

    @property
    def speeds(self) -> Mapping[VariantId, float]:
        """Part of the planned speed at which each variant is moved."""
        return {item.id: item.speed for own in self.variants for item in own}

    @property
    def on_path(self) -> Task:
        """The same with the tray on its path, place and yaw; the certificate is about what was requested."""
        return replace(self, model=replace(self.model, motion=self.model.motion.on_path()))

    @property
    def keeps_apart(self) -> bool:
        """Whether what may touch depends on the motion: a level tray on its path leaves an arm of six joints no choice.

        Then the choice of its branch has seen to it.
        """
        return self.scene.keeps_distances and not self.searched_scene.leaves_time_alone

    @property
    def leads_past(self) -> bool:
        """Whether the motion has to lead past what is around: then planes are in its problems from the start."""
        return self.keeps_apart and self.scene.has_surroundings

    @property
    def of_arm(self) -> frozenset[RowId]:
        """Rows of clearance of the arm with itself and its load, which take part where an answer breaks them.

        None where the motion leads past something: there they are rows like all others, near or not.
        """
        pairs = scene_pairs(self.scene) if self.keeps_apart and not self.leads_past else ()
        return frozenset(RowId(Clearance.name, pair.subject) for pair in pairs if pair.of_arm)

    def clearance_slack(self, q: np.ndarray) -> dict[RowId, float]:
        """What bodies leave of their clearance at joint positions (m, n), rad, as part of a budget; without any, {}."""
        if not self.keeps_apart:
            return {}
        found = least_slack(self.scene, q, within=Clearance.least_size)
        return {RowId(Clearance.name, subject): slack / Clearance.least_size for subject, slack in found.items()}

    @property
    def around_solids(self) -> frozenset[RowId]:
        """Rows of clearance between bodies of which the second is no half-space: no plane leads out of its middle."""
        pairs = scene_pairs(self.scene) if self.keeps_apart else ()
        return frozenset(RowId(Clearance.name, pair.subject) for pair in pairs if pair.second.shape.kind != "halfspace")

    @property
    def searched_scene(self) -> Scene:
        """The model, with a level tray where only that passes the singularities."""
        scene = self.model
        return replace(scene, motion=scene.motion.without_freedom()) if self.passage.level else scene

    @property
    def at_once(self) -> int:
        """How many objects join a problem at once for one constraint."""
        return _FEW if len(self.outer) > _MANY else _AT_ONCE

    @property
    def first_members(self) -> frozenset[VariantId]:
        """What a problem begins with: the stated variants of the outer ones of like objects, of many the delicate."""
        most = _FEW if len(self.outer) > _MANY else _MOST_OBJECTS
        chosen = {cargo.name for cargo in least_tolerant_objects(self.model, most)}
        return frozenset(stated.id for stated, *_ in self.variants if stated.name in chosen)

    @property
    def driven(self) -> frozenset[str]:
        """Objects whose waves of second order are states of the problems that have more than one mode of them.

        Those whose height after the end is judged by the nonlinear flow, unless smoothness comes first.
        """
        return frozenset() if self.smooth_first or self.smooth_alone else self.by_flow

    @property
    def may_be_driven(self) -> frozenset[str]:
        """The same whatever comes first."""
        return frozenset() if self.smooth_alone else self.by_flow

    @property
    def by_flow(self) -> frozenset[str]:
        """Objects whose height after the end the nonlinear flow judges in any problem and motion of the task."""
        motion, alone = self.scene.motion, min(self.speeds.values(), default=1.0) == 1.0
        if motion.stop or not alone or self.scene.initial_state is not None or self.scene.planned_modes < 2:
            return frozenset()
        return frozenset(item.name for item in self.scene.cargo if by_nonlinear_flow(item, motion.residual_height))

    def judged_scene(self, refined: Collection[str]) -> Scene:
        """The scene that a motion is judged for.

        Of a problem without the modes that drive waves of second order, and where smoothness alone stills them, heights
        by the nonlinear flow are looked at to that order: the motion is so rough that its flow says little.
        """
        if self.scene.planned_modes < 2 or (refined and not self.smooth_alone):
            return self.scene
        motion = self.scene.motion.without_flow
        return self.scene if motion is self.scene.motion else replace(self.scene, motion=motion)

    def _refined(self, variant: Variant, modes: int) -> Variant:
        refined = _with_excited_modes(variant, modes)
        return _with_driven(refined) if variant.name in self.driven else refined

    def problem_scene(self, members: Collection[VariantId], refined: Collection[str], modes: int) -> Scene:
        """The scene of a problem that holds some variants of some objects, those named in `refined` with more modes."""
        scene = self.searched_scene
        if EndDisplacement.name in self.ignored:
            # Its equalities are bounds of the variables, which only another end condition takes away.
            scene = replace(scene, motion=replace(scene.motion, end="residual"))
        families = [
            [self._refined(item, modes) if item.name in refined and item.id in members else item for item in variants]
            for variants in self.variants
        ]
        return scene_of(scene, families, members)


def _with_driven(variant: Variant) -> Variant:
    """A variant with the waves of second order that its modes drive."""
    filling = variant.cargo.filling
    if filling is None or filling.modes.count < 2:
        return variant
    return replace(variant, cargo=replace(variant.cargo, filling=replace(filling, drives=True)))


def _with_excited_modes(variant: Variant, modes: int) -> Variant:
    """A variant with more modes: at a part v of the speed those that the motion excites as well.

    A mode of frequency omega answers there to what one of omega / v answers to at the planned speed.
    """
    refined = replace(variant, cargo=with_modes(variant.cargo, modes))
    greatest = _EXCITED * variant.speed * _fastest(refined.cargo)
    while modes > 1 and _fastest(refined.cargo) > greatest:
        modes -= 1
        refined = replace(variant, cargo=with_modes(variant.cargo, modes))
    return refined


def _fastest(cargo: Cargo) -> float:
    """Greatest frequency of the liquid of an object, rad/s; 0 without any."""
    return max((mode.frequency for mode in cargo.oscillators), default=0.0)
