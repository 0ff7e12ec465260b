"""A stop from a state that breaks a limit already: a liquid above its height, as in a cup that somebody has bumped.

No motion keeps that limit; so it is widened by what is needed, and no more: first the least factor on the heights of
all liquids with which a certified stop is found, by halving, then the fastest stop with that factor. What swings on
after it keeps the limit as it was stated; where the path that is left is too short to still the liquid by so much, it
swings on above it too, and is followed until it has fallen below.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from nospill.certification.after_end import free_heights, residual_height
from nospill.certification.by_flow import steep_flows
from nospill.certification.certificate import Judgement, judge_motion
from nospill.certification.replay import Replay
from nospill.certification.verdict import Certificate, Row
from nospill.certification.wording import describe
from nospill.core.trees import flatten
from nospill.errors import ModelError, NoSolutionError, ScenarioError
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.scene_parameters import initial_coordinates, numbers_of, structure_of
from nospill.motion.trajectory import Trajectory
from nospill.plans.plan import Plan
from nospill.plans.state import MotionState
from nospill.plans.stops import NO_BOUND, Stop
from nospill.robots.joint_paths.search import JointPath
from nospill.scene.scene import Scene
from nospill.stopping.physics import stays
from nospill.stopping.seen_states import on_own_way
from nospill.stopping.solving import Found, found_from_afar, joint_path_of, stopping_scene

_FIRST, _WIDEST = 1.01, 3.0
"""Factors beyond that of the state: the first that is tried, and the widest."""
_FOLLOWED = (2.0, 8.0, 32.0)
"""s after the end, for which liquids are followed: longer where one is not below its limit for good by then."""
HORIZON = _FOLLOWED[-1]
"""s after the end."""
_NEAR = 1.02
"""Ratio of two factors that are as good as one."""


@dataclass(frozen=True, slots=True)
class Recovery:
    """A stop that breaks limits on heights for a while.

    Attributes:
        stop: the motion.
        certificate: its verdict by the limits as stated; heights are the only rows that fail, but for `broken`.
        excess: m above `max_slosh_height` at most, by object; of those that are above it.
        until: s from its beginning, when the last liquid is below its limit for good, also after the arm stands;
            infinite where one is not within `HORIZON` after the end.
        spilled: names of those whose liquid rises over the rim.
        moves: whether an object moves by the whole physics, of a plan by published equations, in every stop that was
            found: where a wave pushes its cup harder than friction bears.
        broken: other rows that fail, in words, "tip of bottle uses 104.0 % of its limit at t = 0.120 s"; of what is
            left of the plan alone, which is the answer where no stop is found that keeps them.
    """

    stop: Stop
    certificate: Certificate
    excess: Mapping[str, float]
    until: float
    spilled: tuple[str, ...] = ()
    moves: bool = False
    broken: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """What it does, in words: "recovering: c1 2.1 mm too high, until 0.312 s"."""
        further = ["by the whole physics an object moves"] if self.moves else []
        if self.stop.doubted:
            further.append(f"the flow that judges {', '.join(self.stop.doubted)} is in doubt")
        if not (self.excess or self.broken):
            return "; ".join(["certified", *further])
        if self.stop.origin == "rest of the plan":
            further += ["no stop was found, it is what is left of the plan", *self.broken]
        return "; ".join([f"recovering: {self._heights}", *further])

    @property
    def _heights(self) -> str:
        """By how much liquids are too high and until when, in words."""
        if not self.excess:
            return "no liquid is too high"
        worst = ", ".join(
            f"{name} {1e3 * over:.1f} mm too high" + (" and over the rim" if name in self.spilled else "")
            for name, over in sorted(self.excess.items())
        )
        if not math.isfinite(self.until):
            return f"{worst}, also {HORIZON:g} s after the arm stands"
        after = self.until - self.stop.duration
        stands = f", {after:.3f} s after the arm stands" if after > 0.0 else ""
        return f"{worst}, until {self.until:.3f} s{stands}"


def recover(plan: Plan, state: MotionState, *, residual: float = 1.0) -> Recovery:
    """Find the stop from a state whose liquids may be above their limits: least excess first, then least time.

    Args:
        plan: certified.
        state: of the plan (`plan.state_at`), with the swings of liquids that were seen or guessed
            (`dataclasses.replace(state, swings=...)`).
        residual: how high liquids may swing on after the stop, over max_slosh_height.

    Raises:
        ScenarioError: the plan has no stops (`stops.require_stoppable`), the state is not one of its own or does not
            say how all its liquids swing, or a liquid of it is over the rim of its cup.
        NoSolutionError: no stop was found within three times the height of the state, and with what is left of the
            plan a liquid moves so far that its equations do not hold.
    """
    own_way, on_it = on_own_way(plan, state)
    scene, joint_path = stopping_scene(own_way.scene, on_it, residual), joint_path_of(own_way)
    high, left = _above(scene), plan.duration - state.t
    rest = None if high else _what_is_left(plan, state, residual)
    ways = [(kept, calmer) for kept in (True, False) for calmer in ((True, False) if high else (True,))]
    for kept, calmer in ways:
        search = _Search(scene, high, on_it, joint_path, left, calmer, kept, of_plan=own_way is not plan)
        found = search.least() if rest is None else search.as_stated()
        if found is not None:
            return _told(found.stop, scene, judge_motion(found.stop.trajectory, scene), moves=not found.stays)
    if rest is not None:
        return rest
    try:
        return _rest_of_plan(plan, state, residual)
    except ModelError as error:
        raise NoSolutionError(
            f"{plan.scene.name}: no stop from {state.t:g} s was found whose liquids stay below "
            f"{_WIDEST * max(high.values(), default=1.0):.2g} times their max_slosh_height, and of what is left of the "
            f"plan nothing is known: {error}"
        ) from error


@dataclass(frozen=True, slots=True)
class _Search:
    """For the least factor on the limits of those liquids that are high, on all where none is.

    Attributes:
        scene: of the stop.
        high: crest over its limit, by object.
        state: from which it begins.
        joint_path: the arm's way along the path.
        left: s, that it may take.
        calmer: whether what swings on keeps the limit as stated.
        stays: whether objects have to stay by the whole physics.
        of_plan: whether what is left of the plan is a start, too.
    """

    scene: Scene
    high: Mapping[str, float]
    state: MotionState
    joint_path: JointPath
    left: float
    calmer: bool
    stays: bool
    of_plan: bool

    def least(self) -> Found | None:
        """The stop with the least factor; None where none is found."""
        needed = max(self.high.values(), default=1.0)
        low = needed * _FIRST if self.high else 1.0
        found = self._within(low)
        if found is not None:
            return found
        wide = needed * _WIDEST
        found = self._within(wide)  # before all between: where even this fails, each of them takes every start's time
        while found is not None and wide > low * _NEAR:
            middle = float(np.sqrt(low * wide))
            other = self._within(middle)
            low, wide, found = (middle, wide, found) if other is None else (low, middle, other)
        return found

    def as_stated(self) -> Found | None:
        """The fastest stop by the limits as they are stated; None where none is found."""
        return self._within(1.0)

    def _within(self, factor: float) -> Found | None:
        """The fastest stop that was found with a factor."""
        cargo = tuple(
            replace(item, filling=replace(item.filling, max_slosh_height=factor * item.filling.max_slosh_height))
            if item.filling is not None and (item.name in self.high or not self.high)
            else item
            for item in self.scene.cargo
        )
        part = self.scene.motion.residual_fraction / (factor if self.calmer else 1.0)
        scene = replace(self.scene, cargo=cargo, motion=replace(self.scene.motion, residual_fraction=part))
        found = found_from_afar(scene, self.state, self.joint_path, self.left, of_plan=self.of_plan)
        return None if found is None or (self.stays and not found.stays) else found


def _what_is_left(plan: Plan, state: MotionState, residual: float) -> Recovery | None:
    """What is left of a plan as the stop, where it keeps every limit from a state; None else."""
    rest = _rest_of_plan(plan, state, residual)
    return rest if rest.certificate.ok else None


def _rest_of_plan(plan: Plan, state: MotionState, residual: float) -> Recovery:
    """What is left of a plan as the stop, whatever it breaks.

    Raises:
        ModelError: a liquid moves so far that its equations do not hold.
    """
    scene, left = stopping_scene(plan.scene, state, residual), plan.duration - state.t
    judgement = judge_motion(state.rest, scene)
    nearest = describe(judgement.certificate.worst)
    stop = Stop(
        t=state.t,
        duration=left,
        left=left,
        end=float(state.rest.s[-1]),
        origin="rest of the plan",
        nearest=nearest,
        trajectory=state.rest,
        seconds=0.0,
        bound=NO_BOUND,
        doubted=tuple(steep_flows(scene, judgement.replay)),
    )
    return _told(stop, scene, judgement, moves=not stays(state.rest, scene))


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


def _told(stop: Stop, scene: Scene, judgement: Judgement, *, moves: bool) -> Recovery:
    """A stop with its verdict by the limits of a scene."""
    rows = [row for row in judgement.certificate.rows if not row.ok and row.of_liquid]
    highest: dict[str, Row] = {}
    for row in rows:
        if row.subject not in highest or row.worst_value > highest[row.subject].worst_value:
            highest[row.subject] = row
    rims = {
        item.name: item.container.height - item.filling.liquid_height
        for item in scene.cargo
        if item.filling is not None and not item.filling.lid
    }
    return Recovery(
        stop=stop,
        certificate=judgement.certificate,
        excess={name: row.worst_value - row.limit for name, row in highest.items()},
        until=_until(stop.trajectory, scene) if any(row.at_end for row in rows) else _last_above(judgement),
        spilled=tuple(name for name, row in highest.items() if row.worst_value > rims.get(name, math.inf)),
        moves=moves,
        broken=tuple(describe(row) for row in judgement.certificate.rows if not (row.ok or row.of_liquid)),
    )


def _last_above(judgement: Judgement) -> float:
    """The last instant at which a liquid is above its limit, s; 0 where none is."""
    late = [trace.t[trace.use > 1.0] for trace in judgement.traces if trace.constraint == SloshHeight.name]
    return float(max((t[-1] for t in late if len(t)), default=0.0))


def _until(record: Trajectory, scene: Scene) -> float:
    """The same with what swings on after the end: until no liquid rises above its limit again, infinite where one may.

    Heights are those of the judge while the arm stands; what is left then is bounded for all time by its modes.
    """
    for wait in _FOLLOWED:
        judgement = judge_motion(record, replace(scene, motion=replace(scene.motion, hold_after=wait)))
        if _calm(judgement.replay, scene):
            return _last_above(judgement)
    return math.inf


def _calm(played: Replay, scene: Scene) -> bool:
    """Whether every liquid stays below its limit from the end of a replay on."""
    structure, numbers = structure_of(scene), numbers_of(scene)
    q, qd = played.slosh_displacement[-1], played.slosh_velocity[-1]
    return all(
        residual_height(item, own, flatten(own), q[part], qd[part], cargo.filling.max_slosh_height)
        <= cargo.filling.max_slosh_height
        for cargo, item, own, part in zip(
            scene.cargo, structure.objects, numbers.objects, structure.slosh_slices, strict=True
        )
        if cargo.filling is not None and not cargo.filling.lid
    )
