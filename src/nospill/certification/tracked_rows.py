"""What arms that do not quite track their command make of a plan: uses of its limits over time, by coarse replays.

Every limit on liquids and contacts is looked at, and the distances of the bodies that come near each other. Nothing is
kept in reserve: what counts is the friction that was measured, the whole footprint and the rim, so that a use of one is
where something spills, slides, turns, tips, lifts or touches, however high a liquid swings below its rim.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from nospill.certification.clearance import clearance_traces
from nospill.certification.replay import Replay, coarse_replays
from nospill.certification.rims import rims_below
from nospill.certification.run import Run, of_joints_alone, run_of
from nospill.certification.second_order import with_second_order_along
from nospill.certification.traces import constraint_traces, end_traces, evaluated_traces
from nospill.certification.verdict import Row, Trace, limit_use
from nospill.laws.constraints.base import OF_OBJECTS, EvaluationPoint, Role, RowId
from nospill.laws.constraints.clearance import Clearance
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.like_objects import hull_objects
from nospill.motion.interpolation import JointMotion
from nospill.motion.trajectory import Trajectory
from nospill.scene.cargo import Cargo
from nospill.scene.carriers import with_modes
from nospill.scene.scene import Scene

_RATE = 1000.0
"""Hz, of the replays: with 20 modes uses agree with the judge's within 0.2 % of a limit."""
_NEAR = 0.04
"""m; pairs of bodies that come nearer to their limit than this are followed."""
_INSTANTS = 101
"""At which they are."""
_WHOLE = 0.008
"""s, of which every replay has a whole number, so that instants of one are instants of another."""
_SLOW_RATE = 250.0
"""Hz, of the steps of liquids with few modes, at least."""
_LEAST_FREEBOARD = 1e-4
"""m."""
_STEP_ANGLE = 0.12
"""rad of the fastest mode, of the second order in them."""
_MODES = 3
"""Of a liquid, with which differences between replays are made."""

Uses = Mapping[RowId, np.ndarray]
"""Use of a limit over time, (m,), by row; of a row on the end one value."""


@dataclass(frozen=True, slots=True)
class Followed:
    """A plan to be played by other arms.

    Attributes:
        scene: with the outer ones of like objects alone, their reserves nothing.
        record: the plan, until the joints stand.
        motion: what the joints do where the arm tracks as it is stated.
        near: rows of the pairs of bodies that come near their limits.
        freeboards: of every liquid, from its level to where the plane of its crest meets the rim, less what the second
            order adds to its height as planned, m.
        rate: of the replays, Hz.
        few_modes: whether each liquid has few of its modes.
    """

    scene: Scene
    record: Trajectory
    motion: JointMotion
    near: tuple[Row, ...]
    freeboards: Mapping[str, float]
    rate: float = _RATE
    few_modes: bool = False

    @classmethod
    def of(cls, trajectory: Trajectory, scene: Scene, rows: Sequence[Row] = ()) -> Followed:
        """The plan of a scene with nothing in reserve; `rows` of its certificate say which bodies come near."""
        run = run_of(trajectory, scene.controller)
        cargo = tuple(map(_without_reserves, scene.cargo))
        return cls.of_run(run, replace(scene, cargo=cargo), rows)

    @classmethod
    def of_run(cls, run: Run, scene: Scene, rows: Sequence[Row]) -> Followed:
        """A run of a scene, with its reserves."""
        near = tuple(row for row in rows if row.constraint == Clearance.name and row.worst_margin < _NEAR)
        alone = _outer(scene)
        return cls(alone, run.record, run.motion or run.record.motion, near, _freeboards(alone, rows))

    @property
    def joints(self) -> int:
        """How many."""
        return len(self.record.joints)

    @property
    def span(self) -> tuple[float, float]:
        """First and last time of the record, s."""
        return float(self.record.t[0]), float(self.record.t[-1])

    @property
    def halvings(self) -> int:
        """Of the steps of the liquids, to the rate of the replays: few modes are slow."""
        return max(0, int(np.log2(self.rate / _SLOW_RATE))) if self.few_modes else 0

    def with_few_modes(self) -> Followed:
        """The same with few modes of each liquid: for differences between replays."""
        return replace(self, scene=_with_few_modes(self.scene), few_modes=True)

    def only(self, subjects: Collection[str]) -> Followed:
        """The same with nothing on the tray but some objects, and some pairs of bodies; all where one is neither."""
        cargo = tuple(item for item in self.scene.cargo if item.name in subjects)
        near = tuple(row for row in self.near if row.subject in subjects)
        known = {item.name for item in cargo} | {row.subject for row in near}
        # a distance needs every body that is there
        if near or known != set(subjects):
            return self
        return replace(self, scene=replace(self.scene, cargo=cargo), near=near)

    def rows(self, *motions: JointMotion, after: float = 0.0, at_end: bool = True) -> tuple[Uses, ...]:
        """The uses of what may happen under some motions of the joints.

        Args:
            motions: what they do.
            after: s that it may last longer than the plan.
            at_end: whether rows on the final state are among them.
        """
        replays = self.played(motions, after=after)
        found = [dict(own) for own in self._during(self._on_objects(replays), replays, self._use)]
        if at_end:
            of_ends = end_traces(self.scene, [(self._record(played), played) for played in replays])
            for own, traces in zip(found, of_ends, strict=True):
                own |= {trace.id: use for trace in traces if (use := self._use(trace)) is not None}
        return tuple(found)

    def during(self, replays: Sequence[Replay]) -> tuple[Uses, ...]:
        """Uses of the rows on objects and of the distances that are near, during some replays of one length.

        Evaluated one behind the other, in one call; slosh heights to the order that the scene has them.
        """
        objects = with_second_order_along(self._on_objects(replays), self.scene, replays, step_angle=_STEP_ANGLE)
        return self._during(objects, replays, lambda trace: trace.use)

    def _during(
        self,
        objects: Sequence[Trace],
        replays: Sequence[Replay],
        use_of: Callable[[Trace], np.ndarray | None],
    ) -> tuple[Uses, ...]:
        """Uses of traces along all replays and of the distances that are near; those that are None are left out."""
        found: list[dict[RowId, np.ndarray]] = [{} for _ in replays]
        for trace in (*objects, *self._distances(replays)):
            use = use_of(trace)
            if use is not None:
                for own, part in zip(found, np.split(use, len(replays)), strict=True):
                    own[trace.id] = part
        return tuple(found)

    def traces(self, played: Replay) -> tuple[Trace, ...]:
        """Traces of the rows on objects, those on the final state too, and of the distances that are near."""
        near = clearance_traces(self.scene, played.t, played.joint_position, self.near)
        return (*constraint_traces(self._record(played), self.scene, played, points=OF_OBJECTS), *near)

    def _record(self, played: Replay) -> Trajectory:
        joints = played.joint_position, played.joint_speed, played.joint_acceleration
        return Trajectory.of_joints(played.t, self.record.joints, *joints)

    def played(self, motions: Sequence[JointMotion], *, after: float = 0.0) -> tuple[Replay, ...]:
        """Replays of some motions of the joints; arguments as of `rows`."""
        (start, stop), samples = self.span, self.record.rate
        # jerks jump at the samples of the record: they are instants of every grid that is finer
        rate = samples * float(np.ceil(self.rate / samples - 1e-9)) if self.rate > samples else self.rate
        whole = start + float(np.ceil((stop + after - start) / _WHOLE - 1e-6)) * _WHOLE
        return coarse_replays(self.scene, motions, start, whole, rate=rate, halvings=self.halvings)

    def _on_objects(self, replays: Sequence[Replay]) -> tuple[Trace, ...]:
        """Traces of the rows on objects during all replays, one after the other."""
        columns = [[item.body, item.slosh_displacement.T, item.slosh_velocity.T] for item in replays]
        joined = [np.hstack(own) for own in zip(*columns, strict=True)]
        return evaluated_traces(self.scene, {EvaluationPoint.OBJECT: (np.arange(joined[0].shape[1]), joined)})

    def _distances(self, replays: Sequence[Replay]) -> tuple[Trace, ...]:
        """Likewise of the distances that are near, at some instants."""
        some = np.linspace(0, len(replays[0].t) - 1, _INSTANTS).astype(int)
        joints = np.concatenate([item.joint_position[some] for item in replays])
        return clearance_traces(self.scene, np.arange(len(joints)), joints, self.near, instants=len(joints))

    def _use(self, trace: Trace) -> np.ndarray | None:
        return _use_without_reserve(trace, self.freeboards)


def without_reserve(replay: Replay, scene: Scene, rows: Sequence[Row]) -> dict[RowId, float]:
    """The largest use of what may happen in a replay, with nothing in reserve: above 1 it does.

    Args:
        replay: of the joints.
        scene: with its reserves.
        rows: of the certificate of that replay, for the pairs of bodies that are near.
    """
    bare = of_joints_alone(_without_flow(replace(scene, cargo=tuple(map(_without_reserves, scene.cargo)))))
    record = Trajectory.of_joints(
        replay.t, scene.robot.joints, replay.joint_position, replay.joint_speed, replay.joint_acceleration
    )
    free = _freeboards(bare, ())  # traces have what the second order adds
    uses = [(trace.id, _use_without_reserve(trace, free)) for trace in constraint_traces(record, bare, replay)]
    found = {row: float(np.max(use)) for row, use in uses if use is not None}
    near = [row for row in rows if row.constraint == Clearance.name]
    return found | {row.id: float(limit_use(row.known, 0.0, row.worst_value - min(row.limit, 0.0))) for row in near}


@lru_cache(maxsize=8)  # of a scene under planning in every round, with what is kept of the last few scenes
def _outer(scene: Scene) -> Scene:
    """The scene for replays: with the outer ones of like objects alone."""
    return of_joints_alone(_without_flow(replace(scene, cargo=hull_objects(scene))))


@lru_cache(maxsize=8)
def _with_few_modes(scene: Scene) -> Scene:
    cargo = tuple(with_modes(item, min(_MODES, scene.slosh_modes)) for item in scene.cargo)
    return replace(scene, cargo=cargo)


def _without_flow(scene: Scene) -> Scene:
    """The scene with heights of second order where it has those of the nonlinear flow.

    Many replays are looked at for what happens first, and what is left after the end seldom does.
    """
    return replace(scene, motion=scene.motion.without_flow)


def _without_reserves(item: Cargo) -> Cargo:
    return replace(item, friction_reserve=0.0, footprint_reserve=0.0)


def _use_without_reserve(trace: Trace, freeboards: Mapping[str, float]) -> np.ndarray | None:
    """Use over time of a limit on what may happen, heights by the way to the rim; None of another limit."""
    constraint = trace.known
    if constraint is None:
        return None
    if constraint.name == Clearance.name:  # bodies whose shapes are estimated touch where they may not overlap more
        return limit_use(constraint, np.zeros_like(trace.value), trace.value - np.minimum(trace.limit, 0.0))
    if constraint.name in (SloshHeight.name, ResidualHeight.name):
        return np.abs(trace.value) / freeboards[trace.subject]
    return trace.use if constraint.role is Role.CONTACT else None


def _freeboards(scene: Scene, rows: Sequence[Row]) -> dict[str, float]:
    """Linear crest at which each liquid reaches its rim, m: as it is for the crest that is allowed."""
    added = {row.subject: row.worst_value - row.linear_value for row in rows if row.linear_value is not None}
    allowed = {item.name: item.filling.max_slosh_height for item in scene.cargo if item.filling is not None}
    free = {item.subject: allowed[item.subject] + item.edge.below_rim for item in rims_below(scene, allowed)}
    return {name: max(height - added.get(name, 0.0), _LEAST_FREEBOARD) for name, height in free.items()}


def worst_of(uses: Uses) -> tuple[float, RowId]:
    """The largest use of all rows, and whose it is."""
    largest = [(float(np.max(use)), row) for row, use in uses.items()]
    return max((np.inf if math.isnan(use) else use, row) for use, row in largest)
