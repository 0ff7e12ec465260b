"""The margins of one object along a given motion of the tray, for many sets of its numbers at once.

The tray moves the same way whatever stands on it, and objects do not touch each other. So each object of each sample is
a problem of its own with few numbers: its liquid is integrated by Runge-Kutta steps, after each step every constraint
of the object is looked at, and its worst margin kept. One CasADi function does this from the first instant to the last;
it is mapped over the samples, with the tray's motion shared by all.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from nospill.core.batches import over_columns, thread_count
from nospill.core.frames import SX, FrameMotion, body_motion, frame_at_rest
from nospill.core.trees import flatten
from nospill.judge.after_end import residual_height
from nospill.judge.replay import slosh_accelerations, tray_from_joints
from nospill.judge.run import run_of
from nospill.laws.constraints import constraints_of
from nospill.laws.constraints.base import Constraint, EvaluationPoint, worst_figures
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.parameters import (
    ObjectNumbers,
    SceneNumbers,
    Structure,
    blank_numbers,
    object_parameter_count,
    symbolic_object_numbers,
)
from nospill.laws.sample import Sample, coordinate_count, sample_objects, split_states
from nospill.laws.scene_parameters import structure_of
from nospill.laws.slosh.integrate import runge_kutta_step
from nospill.motion.control import commanded, followed
from nospill.motion.interpolation import QUINTIC_SPLINE
from nospill.motion.trajectory import Trajectory
from nospill.scene.controller import Controller
from nospill.scene.scene import Scene

STEP = 1e-3
"""s; longest step of the integration, after each of which the margins are looked at."""

BATCH = 100
"""Samples that are computed together, and share one motion of the tray."""
_NEVER = 1e9


@dataclass(frozen=True, slots=True)
class TrayMotion:
    """A motion of the tray in n steps.

    Attributes:
        body: (27, n) rates and specific force (as `Replay.body`) at the start, the middle and the end of each step.
        step: length of a step, s.
    """

    body: np.ndarray
    step: float


def tray_motion(
    trajectory: Trajectory, scene: Scene, arm: Controller | None = None, *, after: float = 0.0
) -> TrayMotion:
    """The tray's motion from the first joint sample to the end of the motion, from the joint positions alone.

    Args:
        trajectory: the plan's.
        scene: with the controller that the command was made for.
        arm: how the joints really follow the command; as the scenario states when left out.
        after: s of rest that are added to the end, in which a late arm comes to rest.
    """
    run = run_of(trajectory, scene.controller)
    motion = run.motion or trajectory.motion
    if arm is not None:
        samples = commanded(trajectory, scene.controller)
        motion = followed(QUINTIC_SPLINE.motion(samples), arm, float(samples.t[0]), float(samples.t[-1]))
    start, end = float(trajectory.t[0]), run.record.end_time + after
    count = int(np.ceil((end - start) / STEP - 1e-9))
    t = np.linspace(start, end, 2 * count + 1)
    _, body = tray_from_joints(scene, [motion(t, order) for order in range(3)])
    return TrayMotion(np.vstack([body[:, 0:-1:2], body[:, 1::2], body[:, 2::2]]), (end - start) / count)


@dataclass(frozen=True, slots=True)
class Margins:
    """Worst figures of one object in m samples, per constraint that applies to it.

    Attributes:
        constraints: which.
        margin: (m, n) in the constraint's unit.
        limit: likewise.
    """

    constraints: tuple[Constraint, ...]
    margin: np.ndarray
    limit: np.ndarray


def object_margins(
    scene: Scene, index: int, numbers: tuple[ObjectNumbers, ...], *motions: TrayMotion
) -> Iterator[tuple[int, Margins]]:
    """Margins of one object for many sets of its numbers, batch by batch.

    Args:
        scene: the object's scene.
        index: of the object.
        numbers: one per sample, of the structure the object has in the scene.
        motions: of the tray, of so many steps each; one for each batch of `BATCH`, and again from the first.

    Yields:
        The number of samples in the batch and their margins.
    """
    whole = structure_of(scene)
    structure = replace(whole, objects=whole.objects[index : index + 1])
    shared = (scene.gravity, scene.motion.residual_fraction)
    made = _function(structure, motions[0].body.shape[1], BATCH)
    names = tuple(constraint.name for constraint in made.constraints)
    initial = ca.DM(scene.cargo[index].initial_coordinates.ravel())
    for first in range(0, len(numbers), BATCH):
        batch, motion = numbers[first : first + BATCH], motions[first // BATCH % len(motions)]
        columns = np.column_stack([np.concatenate([shared, [motion.step], flatten(item)]) for item in batch])
        padded = np.pad(columns, ((0, 0), (0, BATCH - len(batch))), mode="edge")
        found = np.array(made.call(ca.DM(padded), initial, ca.DM(motion.body)).full())[:, : len(batch)].T
        figures, states = np.split(found, [2 * len(names)], axis=1)
        margin, limit = figures[:, 0::2].copy(), figures[:, 1::2]
        _play_on(structure, batch, names, states, margin, limit)
        yield len(batch), Margins(made.constraints, np.where(np.isnan(margin), -np.inf, margin), limit)


@dataclass(frozen=True, slots=True)
class _Made:
    call: Any
    constraints: tuple[Constraint, ...]


@lru_cache(maxsize=16)
def _function(structure: Structure, steps: int, batch: int) -> _Made:
    """(numbers of samples, initial slosh coordinates, motion) -> margin and limit of every constraint, final state."""
    count, size = coordinate_count(structure), 3 + object_parameter_count(structure.objects[0])
    p = SX.sym("p", size)
    numbers = _scene_numbers(structure, p)
    state, first, middle, last = SX.sym("state", 2 * count), SX.sym("b0", 9), SX.sym("b1", 9), SX.sym("b2", 9)
    following = state
    if count:
        step = runge_kutta_step(
            lambda x, b, q: _rate(structure, _scene_numbers(structure, q), x, b),
            states=2 * count,
            inputs=9,
            parameters=size,
        )
        following = step(state, first, middle, last, p[2], p)
    tray = body_motion(last)
    q, qd = following[:count], following[count:]
    during = _worst(EvaluationPoint.OBJECT, structure, numbers, tray, q, qd, moving=True)
    worst = SX.sym("worst", 2 * len(during))
    kept = []
    for number, (_, figure) in enumerate(during):
        closer = figure[2] < worst[2 * number]
        kept.append(ca.if_else(closer, ca.vertcat(figure[2], figure[1]), worst[2 * number : 2 * number + 2]))
    # The numbers ride along in the state: what is accumulated may differ from sample to sample, the motion may not.
    before, after = ca.vertcat(p, state, worst), ca.vertcat(p, following, *kept)
    advance = ca.Function("advance", [before, ca.vertcat(first, middle, last)], [after], {"cse": True})
    rest = frame_at_rest(numbers.gravity)
    at_end = _worst(EvaluationPoint.END, structure, numbers, rest, state[:count], state[count:], moving=False)
    final = [ca.vertcat(figure[2], figure[1]) for _, figure in at_end]
    finish = ca.Function("finish", [before], [ca.densify(ca.vertcat(worst, *final, state))], {"cse": True})

    given, initial, motion = ca.MX.sym("p", size), ca.MX.sym("initial", 2 * count), ca.MX.sym("motion", 27, steps)
    start = ca.vertcat(given, initial, _NEVER * ca.MX.ones(2 * len(during)))
    one = ca.Function("one", [given, initial, motion], [finish(advance.fold(steps)(start, motion))])
    call = over_columns(one, batch, [1, 2], threads=thread_count())
    return _Made(call, tuple(constraint for constraint, _ in (*during, *at_end)))


def _play_on(
    structure: Structure,
    batch: Sequence[ObjectNumbers],
    names: Sequence[str],
    states: np.ndarray,
    margin: np.ndarray,
    limit: np.ndarray,
) -> None:
    """Residual heights as the judge finds them, from the free motion where a liquid has many modes.

    Args:
        structure: of the object alone.
        batch: its numbers, one per sample.
        names: of the constraints.
        states: (m, 2 k) at the end.
        margin: (m, n), changed here.
        limit: likewise, read.
    """
    (item,) = structure.objects
    if ResidualHeight.name not in names or item.modes < 2:
        return
    column = names.index(ResidualHeight.name)
    for index in range(len(batch)):
        q, qd = np.split(states[index], 2)
        allowed = abs(float(limit[index, column]))
        margin[index, column] = allowed - residual_height(item, batch[index], q, qd, allowed)


def _scene_numbers(structure: Structure, p: SX) -> SceneNumbers:
    """The numbers with gravity, residual fraction and the object's own from `p`; no more is read of them here."""
    (item,) = structure.objects
    blank = blank_numbers(structure)
    return replace(blank, gravity=p[0], residual_fraction=p[1], objects=(symbolic_object_numbers(item, p[3:]),))


def _rate(structure: Structure, numbers: SceneNumbers, state: SX, body: SX) -> SX:
    count = coordinate_count(structure)
    q, qd = state[:count], state[count:]
    return ca.vertcat(qd, slosh_accelerations(structure, numbers, body_motion(body), q, qd))


def _worst(
    point: EvaluationPoint,
    structure: Structure,
    numbers: SceneNumbers,
    tray: FrameMotion,
    q: SX,
    qd: SX,
    *,
    moving: bool,
) -> list[tuple[Constraint, SX]]:
    """Value, limit and margin (3, 1) of every constraint of one evaluation point that applies to the object."""
    count = coordinate_count(structure)
    qdd = slosh_accelerations(structure, numbers, tray, q, qd) if moving and count else SX.zeros(count)
    objects = sample_objects(structure, numbers, tray, split_states(structure, q, qd, qdd))
    sample = Sample(structure, numbers, objects=objects)
    found = []
    for constraint in constraints_of(structure):
        if constraint.evaluated_at is point:
            found += [(constraint, worst_figures(constraint, budgets)) for budgets in constraint.budgets(sample)]
    return found
