"""What is judged in addition to the scene as stated: variants of its objects, and the motion at other speeds."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from nospill.certification.between_instants import peaks_between, with_peaks
from nospill.certification.carriers import with_liquids_apart
from nospill.certification.load_extremes import worst_load_traces
from nospill.certification.replay import MINIMUM_RATE, Replay, coarse_replays, replay
from nospill.certification.traces import constraint_traces
from nospill.certification.verdict import Trace
from nospill.laws.constraints.base import OF_OBJECTS, EvaluationPoint, Role, RowId
from nospill.laws.constraints.joint_torque import JointTorque
from nospill.laws.like_objects import hull_objects
from nospill.motion.at_speed import SlowedMotion, at_speed
from nospill.motion.interpolation import JointMotion
from nospill.motion.trajectory import Trajectory
from nospill.scene.scene import Scene
from nospill.scene.tolerances import Corner, corner_scenes, is_uncertain
from nospill.scene.variants import speed_text

_OF_SLOWED = 0.25
"""Part of the rate of the grid at which slower motions are judged: 500 Hz for 2 kHz, uses agree within 0.1 %."""

_NEAR = 0.03
"""Part of a limit; a use nearer to it than that at a speed of the grid may exceed it near that (1.6 % seen)."""

_CLOSE, _LOOKS, _SAME = 0.0045, 2, 3e-5
"""Between speeds v that come near a limit: distance of their 1/v in the first look; further looks, each at the vertices
of the parabolas through those before; and the part of a speed by which two differ at least."""

_BROKEN = 0.05
"""Part of a limit; where one is broken by more at a speed of the grid, nothing is looked at between them."""

_FIRST_LOOKS = (3, 1)
"""Of so many speeds of the grid one is looked at first, and then, with the liquids integrated once: steps of three of
them determine the modes that problems have."""

_LEFT = 0.005
"""Part of a limit that a first look leaves, or less, where the judge begins."""

_LIQUIDS_OFF, _CONTACTS_OFF = 1e-3, 0.02
"""Parts of a limit by which uses of these looks are off as a rule (1.4e-4 and 0.016 seen; 2.9e-3 of one liquid whose
damping was halved): what is judged in the end is judged with finer steps."""


Corners = Callable[[Trajectory, Scene, JointMotion | None, float, Replay | None], Iterator[Trace]]
"""The arguments of `corner_traces` -> traces on the variants of the objects."""

_RowOfVariant = tuple[RowId, int]
"""A row, and the number of the variant whose uses over the speed are looked at: those of another are another curve."""


def corner_traces(
    trajectory: Trajectory,
    scene: Scene,
    motion: JointMotion | None = None,
    rate: float = MINIMUM_RATE,
    played: Replay | None = None,
) -> Iterator[Trace]:
    """Traces of every constraint on every variant of the objects, one at a time.

    There are none where all numbers are certain at one speed.

    Args:
        trajectory: the record, with its holds.
        scene: what it must keep to.
        motion: what the receiver's joints do; the spline through the recorded positions when left out.
        rate: Hz, the least rate of the grid.
        played: the replay of the scene as stated; with it, joint torques under the worst load too.
    """
    yield from _judged(list(_of_outer_objects(corner_scenes(scene))), trajectory, scene, motion, rate, played)


def _judged(
    corners: Sequence[Corner],
    trajectory: Trajectory,
    scene: Scene,
    motion: JointMotion | None,
    rate: float,
    played: Replay | None,
    *,
    near: Collection[tuple[float, int]] = (),
) -> Iterator[Trace]:
    """`corner_traces` of these; none of the others where those of speed and number in `near` break a limit."""
    uses = dict[_RowOfVariant, dict[float, float]]()

    def looked_at(some: Iterable[Corner]) -> Iterator[Trace]:
        for corner in some:
            for trace in _corner_traces(trajectory, corner, motion, rate):
                use = uses.setdefault((trace.id, corner.number), {})
                use[corner.speed] = max(use.get(corner.speed, 0.0), float(np.max(trace.use)))
                yield trace

    def most() -> float:
        return max((max(use.values()) for use in uses.values()), default=0.0)

    yield from looked_at(corner for corner in corners if (corner.speed, corner.number) in near)
    if most() <= 1.0:
        yield from looked_at(corner for corner in corners if (corner.speed, corner.number) not in near)
        if most() < 1.0 + _BROKEN:
            for between in (closer, *_LOOKS * (vertices,)):
                yield from looked_at(_at_speeds(corners, uses, between))
    yield from _of_loads(trajectory, scene, motion, rate, played)


def broken_or_corner_traces(
    record: Trajectory,
    scene: Scene,
    motion: JointMotion | None,
    rate: float,
    played: Replay | None,
    *,
    again: Collection[float] = (),
) -> Iterator[Trace]:
    """`corner_traces` for a motion under planning: where a first look breaks a limit, what that found, else all of it.

    Such looks are at speeds of the grid, with the liquids integrated once. What comes nearest to a limit there is
    judged before the rest. Other arguments as there.

    Args:
        record: the motion.
        scene: what it must keep to.
        motion: as there.
        rate: as there.
        played: as there.
        again: speeds of the grid that are looked at before all others.
    """
    corners, found, near = list(_of_outer_objects(corner_scenes(scene))), list[Trace](), set[tuple[float, int]]()
    for look in _first_looks(scene.motion.speeds, again):
        for corner in (own for own in corners if own.speed in look):
            traces = [*map(_fullest_instant, _corner_traces(record, corner, motion, rate, _slow_down_roughly))]
            if any(float(trace.use[0]) > 1.0 - _LEFT for trace in traces):
                near.add((corner.speed, corner.number))
            found += traces
        if any(map(_is_broken, found)):
            yield from found
            yield from _of_loads(record, scene, motion, rate, played)
            return
    yield from _judged(corners, record, scene, motion, rate, played, near=near)


def _first_looks(speeds: Sequence[float], again: Collection[float]) -> list[set[float]]:
    """The speeds of each look, one for when those before it hold: `again`, every third speed and both ends, all."""
    looks = [set(again)]
    for every in _FIRST_LOOKS if speeds else ():
        looks.append({1.0, *speeds[::every], speeds[-1]}.difference(*looks))
    return looks


def _is_broken(trace: Trace) -> bool:
    """Whether a limit is broken whatever a first look is off by; what is no number is left to the judge."""
    off = _LIQUIDS_OFF if trace.known is not None and trace.known.role is Role.LIQUID else _CONTACTS_OFF
    return 1.0 + off < float(trace.use[0]) < math.inf


def _fullest_instant(trace: Trace) -> Trace:
    """The instant of a trace that uses most of its limit, as far as its row needs it: hundreds are kept."""
    index = int(np.argmax(trace.use))
    at = {name: getattr(trace, name)[index : index + 1] for name in ("t", "value", "limit", "margin")}
    return replace(trace, **at, linear=None if trace.linear is None else np.max(trace.linear, keepdims=True))


def _of_outer_objects(corners: Iterable[Corner]) -> Iterator[Corner]:
    """Those at other speeds with the outer ones of like objects alone; the same scene for the same objects."""
    known: dict[tuple[int, ...], Scene] = {}
    for corner in corners:
        if corner.speed == 1.0:
            yield corner
            continue
        key = tuple(map(id, corner.scene.cargo))
        if key not in known:
            known[key] = replace(corner.scene, cargo=hull_objects(corner.scene))
        yield replace(corner, scene=known[key])


def _slow_down(
    trajectory: Trajectory, scene: Scene, speed: float, motion: JointMotion | None, rate: float
) -> tuple[Trajectory, Replay]:
    """The record of a motion at a part of its speed, and its replay."""
    slow = at_speed(trajectory, speed)
    joints = None if motion is None else SlowedMotion(motion, speed)
    return slow, replay(slow, scene, motion=joints, rate=_OF_SLOWED * rate)


def _slow_down_roughly(
    trajectory: Trajectory, scene: Scene, speed: float, motion: JointMotion | None, rate: float
) -> tuple[Trajectory, Replay]:
    """The same with the liquids integrated once."""
    slow = at_speed(trajectory, speed)
    joints = slow.motion if motion is None else SlowedMotion(motion, speed)
    ends = float(slow.t[0]), float(slow.t[-1])
    return slow, coarse_replays(scene, [joints], *ends, rate=_OF_SLOWED * rate)[0]


_SlowDown = Callable[[Trajectory, Scene, float, JointMotion | None, float], tuple[Trajectory, Replay]]


def _corner_traces(
    trajectory: Trajectory, corner: Corner, motion: JointMotion | None, rate: float, slow_down: _SlowDown = _slow_down
) -> Iterator[Trace]:
    """The traces of a corner's objects, on the clock of the planned motion."""
    speed, scene = corner.speed, corner.scene
    if speed == 1.0:
        motion = motion or trajectory.motion
        played = replay(trajectory, scene, motion=motion, rate=rate)
        traces = constraint_traces(trajectory, scene, played, points=OF_OBJECTS)
        traces = with_peaks(traces, peaks_between(trajectory, scene, played, traces, motion))
        traces = with_liquids_apart(traces, trajectory, scene, motion=motion, rate=rate)
    else:
        slow, played = slow_down(trajectory, scene, speed, motion, rate)
        traces = constraint_traces(slow, scene, played, points=OF_OBJECTS)
        joints = None if motion is None else SlowedMotion(motion, speed)
        traces = with_liquids_apart(traces, slow, scene, motion=joints, rate=_OF_SLOWED * rate)
        traces = tuple(replace(trace, t=trace.t * speed) for trace in traces)
    for trace in traces:
        if trace.subject in corner.texts:
            yield replace(trace, variant=corner.texts[trace.subject])


def _of_loads(
    trajectory: Trajectory, scene: Scene, motion: JointMotion | None, rate: float, played: Replay | None
) -> Iterator[Trace]:
    """Joint torques at the least speed, and under the worst load of objects that may be heavier."""
    if scene.motion.speeds:
        yield from _torques(trajectory, scene, scene.motion.speeds[-1], motion, rate)
    if is_uncertain(scene) and played is not None:
        yield from worst_load_traces(scene, played)


def _torques(
    trajectory: Trajectory, scene: Scene, least: float, motion: JointMotion | None, rate: float
) -> Iterator[Trace]:
    """Torques at the least speed: they are linear in its square, so that between it and the planned one they are less.

    Under the worst load where masses may be off.
    """
    slow, played = _slow_down(trajectory, replace(scene, cargo=()), least, motion, rate)
    traces = constraint_traces(slow, scene, played, points=[EvaluationPoint.JOINT])
    traces = (*traces, *worst_load_traces(scene, played)) if is_uncertain(scene) else traces
    for trace in traces:
        if trace.constraint == JointTorque.name:
            yield replace(trace, t=trace.t * least, variant=speed_text(least))


def _at_speeds(
    corners: Sequence[Corner],
    uses: Mapping[_RowOfVariant, Mapping[float, float]],
    between: Callable[[Mapping[float, float]], Iterable[float]],
) -> list[Corner]:
    """Corners at speeds between those of the grid, of the objects whose uses ask for them: of those tried nearby.

    Of solids none: their wrench is linear in the square of the speed and the limits are cones, so both ends use most.
    """
    asking: dict[tuple[float, int], set[str]] = {}
    for (row, number), use in uses.items():
        for speed in between(use):
            asking.setdefault((speed, number), set()).add(row.subject)
    chosen = []
    for (speed, number), names in asking.items():
        alike = [corner for corner in corners if corner.number == number]
        nearest = min(alike, key=lambda corner: abs(corner.speed - speed))
        names &= nearest.texts.keys()
        cargo = tuple(item for item in nearest.scene.cargo if item.oscillators and item.name in names)
        if cargo:
            chosen.append(replace(nearest, scene=replace(nearest.scene, cargo=cargo), speed=speed))
    return chosen


def closer(use: Mapping[float, float]) -> set[float]:
    """Speeds between neighbours of which one comes near a limit without exceeding it, from the uses at some speeds."""
    found = set[float]()
    for first, last in pairwise(sorted(use)):
        if 1.0 - _NEAR < max(use[first], use[last]) <= 1.0:
            slow, fast = 1.0 / first, 1.0 / last
            count = math.ceil((slow - fast) / _CLOSE - 1e-9)
            found |= {round(float(1.0 / inverse), 6) for inverse in np.linspace(slow, fast, count + 1)[1:-1]}
    return found


def vertices(use: Mapping[float, float]) -> set[float]:
    """Speeds at which a use just below its limit is largest: vertices of parabolas, from the uses at some speeds."""
    between, speeds = set[float](), sorted(use)
    for first, middle, last in zip(speeds, speeds[1:], speeds[2:], strict=False):
        before, most, after = (use[speed] for speed in (first, middle, last))
        if 1.0 - _NEAR < most <= 1.0 and before <= most >= after and before + after < 2.0 * most:
            below, above = (middle - first) * (most - after), (last - middle) * (most - before)
            vertex = middle + 0.5 * ((last - middle) * above - (middle - first) * below) / (below + above)
            if min(abs(vertex - speed) for speed in (first, middle, last)) > _SAME * middle:
                between.add(round(vertex, 6))
    return between
