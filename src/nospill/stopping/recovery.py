"""A stop from a state that breaks a limit already: a liquid above its height, as in a cup that somebody has bumped.

No motion keeps that limit; so it is widened by what is needed, and no more: first the least factor on the heights of
all liquids with which a certified stop is found, by halving, then the fastest stop with that factor. What swings on
after it keeps the limit as it was stated.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from nospill.certification.after_end import free_heights
from nospill.certification.certificate import Judgement, judge_motion
from nospill.certification.verdict import Certificate
from nospill.errors import NoSolutionError, ScenarioError
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.scene_parameters import initial_coordinates, numbers_of, structure_of
from nospill.plans.plan import Plan
from nospill.plans.state import MotionState
from nospill.plans.stops import Stop
from nospill.robots.joint_paths.search import JointPath
from nospill.scene.scene import Scene
from nospill.stopping.solving import Found, found_from_afar, joint_path_of, stopping_scene

_FIRST, _WIDER, _WIDEST = 1.01, 1.2, 3.0
"""Factors beyond that of the state: the first that is tried, from one to the next, and the last."""
_NEAR = 1.02
"""Ratio of two factors that are as good as one."""


@dataclass(frozen=True, slots=True)
class Recovery:
    """A stop that breaks limits on heights for a while.

    Attributes:
        stop: the motion.
        certificate: its verdict by the limits as stated; heights on the way are the only rows that fail.
        excess: m above `max_slosh_height` at most, by object; of those that are above it.
        until: s from its beginning, when the last liquid is below its limit for good.
    """

    stop: Stop
    certificate: Certificate
    excess: Mapping[str, float]
    until: float

    @property
    def text(self) -> str:
        """What it does, in words: "recovering: c1 2.1 mm too high, until 0.312 s"."""
        if not self.excess:
            return "certified"
        worst = ", ".join(f"{name} {1e3 * over:.1f} mm too high" for name, over in sorted(self.excess.items()))
        return f"recovering: {worst}, until {self.until:.3f} s"


def recover(plan: Plan, state: MotionState, *, residual: float = 1.0) -> Recovery:
    """Find the stop from a state whose liquids may be above their limits: least excess first, then least time.

    Args:
        plan: certified.
        state: of the plan (`plan.state_at`), with the swings of liquids that were seen or guessed
            (`dataclasses.replace(state, swings=...)`).
        residual: how high liquids may swing on after the stop, over max_slosh_height.

    Raises:
        ScenarioError: a liquid of the state is over the rim of its cup.
        NoSolutionError: no stop was found within three times the height of the state.
    """
    scene, joint_path = stopping_scene(plan.scene, state, residual), joint_path_of(plan)
    high = _above(scene)
    needed, left = max(high.values(), default=1.0), plan.duration - state.t
    first = needed * _FIRST if high else 1.0
    low, wide = needed, first
    found = _within(scene, high, wide, state, joint_path, left)
    while found is None:
        low, wide = wide, wide * _WIDER
        if wide > needed * _WIDEST:
            raise NoSolutionError(
                f"{plan.scene.name}: no stop from {state.t:g} s was found whose liquids stay below {low:.2g} times "
                "their max_slosh_height"
            )
        found = _within(scene, high, wide, state, joint_path, left)
    while wide > max(low * _NEAR, first):
        middle = float(np.sqrt(low * wide))
        other = _within(scene, high, middle, state, joint_path, left)
        low, wide, found = (middle, wide, found) if other is None else (low, middle, other)
    return _told(found.stop, judge_motion(found.stop.trajectory, scene))


def _above(scene: Scene) -> dict[str, float]:
    """Crest over its limit of every liquid that is above it when the motion begins.

    Raises:
        ScenarioError: one is over the rim.
    """
    (displacement, _), structure, numbers = initial_coordinates(scene), structure_of(scene), numbers_of(scene)
    above = {}
    for cargo, item, own, part in zip(
        scene.cargo, structure.objects, numbers.objects, structure.slosh_slices, strict=True
    ):
        if cargo.filling is None or cargo.filling.lid:
            continue
        crest = float(free_heights(item, own, displacement[None, part])[0])
        rim = cargo.container.height - cargo.filling.liquid_height
        if crest > rim:
            raise ScenarioError(
                f"{scene.name}: the liquid of {cargo.name} stands {1e3 * crest:.1f} mm above its rest level, and the "
                f"rim of its cup is at {1e3 * rim:.1f} mm: it has been spilled"
            )
        if crest > cargo.filling.max_slosh_height:
            above[cargo.name] = crest / cargo.filling.max_slosh_height
    return above


def _within(
    scene: Scene, high: Mapping[str, float], factor: float, state: MotionState, joint_path: JointPath, left: float
) -> Found | None:
    """The fastest stop that was found with wider limits on those liquids that are high, on all where none is."""
    cargo = tuple(
        replace(item, filling=replace(item.filling, max_slosh_height=factor * item.filling.max_slosh_height))
        if item.filling is not None and (item.name in high or not high)
        else item
        for item in scene.cargo
    )
    calmer = replace(scene.motion, residual_fraction=scene.motion.residual_fraction / factor)
    return found_from_afar(replace(scene, cargo=cargo, motion=calmer), state, joint_path, left)


def _told(stop: Stop, judgement: Judgement) -> Recovery:
    rows = [row for row in judgement.certificate.rows if not row.ok and row.constraint == SloshHeight.name]
    late = [trace.t[trace.use > 1.0] for trace in judgement.traces if trace.constraint == SloshHeight.name]
    return Recovery(
        stop=stop,
        certificate=judgement.certificate,
        excess={row.subject: row.worst_value - row.limit for row in rows},
        until=float(max((t[-1] for t in late if len(t)), default=0.0)),
    )
