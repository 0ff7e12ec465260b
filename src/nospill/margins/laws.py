"""The margins of objects along a given motion of the tray, for many sets of their numbers, by the judge's functions.

The tray moves the same way whatever stands on it, and objects do not touch each other. So each object of each sample is
a problem of its own: its liquid is integrated by Runge-Kutta steps, several of a kind at once, and at the end of each
step every constraint of the object is looked at; of each the instant that uses most of its limit counts.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from nospill.certification.after_end import residual_height
from nospill.certification.replay import liquid_steps, tray_from_joints
from nospill.certification.run import run_of
from nospill.certification.second_order import left_to_second_order, waves_along
from nospill.certification.traces import object_figures_function
from nospill.certification.verdict import limit_use
from nospill.core.batches import evaluate
from nospill.core.trees import flatten
from nospill.laws.constraints import by_name
from nospill.laws.constraints.base import Constraint, EvaluationPoint
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.kinds import limited_object_kind, object_kind
from nospill.laws.parameters import ObjectNumbers
from nospill.laws.scene_parameters import object_numbers, structure_of
from nospill.laws.slosh.integrate import integrate
from nospill.laws.structure import ObjectStructure, Structure
from nospill.motion.control import commanded, followed
from nospill.motion.interpolation import QUINTIC_SPLINE, JointMotion
from nospill.motion.tracking import swung
from nospill.motion.trajectory import Trajectory
from nospill.scene.cargo import Cargo
from nospill.scene.heights import to_second_order
from nospill.scene.scene import Scene
from nospill.scene.tracking import Arm

STEP = 1e-3
"""s; longest step of the integration, after each of which the margins are looked at."""


@dataclass(frozen=True, slots=True)
class TrayMotion:
    """A motion of the tray in n steps.

    Attributes:
        body: (9, 2 n + 1) rates and specific force (as `Replay.body`) at the ends and the middles of the steps.
        step: length of a step, s.
    """

    body: np.ndarray
    step: float


def tray_motion(trajectory: Trajectory, scene: Scene, *, after: float = 0.0) -> TrayMotion:
    """The tray's motion from the first joint sample to the end of the motion, from the joint positions alone.

    Args:
        trajectory: the plan's.
        scene: with the controller that the command was made for.
        after: s of rest that are added to the end.
    """
    run = run_of(trajectory, scene.controller)
    return _sample(run.motion or trajectory.motion, scene, float(trajectory.t[0]), run.record.end_time + after)


def simulate_arms(trajectory: Trajectory, scene: Scene, arms: Iterable[Arm], *, after: float) -> Iterator[TrayMotion]:
    """The tray's motion as each of some arms follows the command of a plan.

    Args:
        trajectory: the plan's.
        scene: with the controller that the command was made for.
        arms: how their joints follow.
        after: s that are added to the end, in which a late arm comes to rest.
    """
    samples = commanded(trajectory, scene.controller)
    command, span = QUINTIC_SPLINE.motion(samples), (float(samples.t[0]), float(samples.t[-1]))
    start, end = float(trajectory.t[0]), run_of(trajectory, scene.controller).record.end_time + after
    for arm in arms:
        drives = followed(command, arm.controller, *span)
        yield _sample(swung(drives, arm, start - arm.controller.latest, end + STEP), scene, start, end)


def _sample(motion: JointMotion, scene: Scene, start: float, end: float) -> TrayMotion:
    count = int(np.ceil((end - start) / STEP - 1e-9))
    t = np.linspace(start, end, 2 * count + 1)
    _, body = tray_from_joints(scene, [motion(t, order) for order in range(3)])
    return TrayMotion(body, (end - start) / count)


@dataclass(frozen=True, slots=True)
class Margins:
    """Figures of one object in m samples where most of a limit is used, per constraint that applies to it.

    Attributes:
        constraints: which.
        margin: (m, n) in the constraint's unit.
        limit: likewise.
    """

    constraints: tuple[Constraint, ...]
    margin: np.ndarray
    limit: np.ndarray


def object_margins(scene: Scene, objects: Sequence[Sequence[Cargo]], motion: TrayMotion) -> tuple[Margins, ...]:
    """Margins of every object for some sets of its numbers, along one motion of the tray.

    Args:
        scene: of the objects.
        objects: of each object one per sample, with these numbers, of the structure the object has in the scene.
        motion: of the tray.

    Returns:
        Of each object, samples in their order.
    """
    structure = structure_of(scene)
    shared = (scene.gravity, scene.motion.residual_fraction)
    numbers = [
        [object_numbers(item, fidelity=scene.fidelity, gravity=scene.gravity) for item in drawn] for drawn in objects
    ]
    columns = [[np.array(flatten((*shared, item))) for item in drawn] for drawn in numbers]
    states = _states(scene, structure, columns, motion)
    known = by_name(scene)
    found = [
        _margins(structure, item, drawn, columns[index], states[index], motion, known)
        for index, (item, drawn) in enumerate(zip(structure.objects, numbers, strict=True))
    ]
    order = scene.motion.slosh_height
    return tuple(
        _to_second_order(own, drawn, own_states, motion, scene) if to_second_order(drawn[0], order) else own
        for own, drawn, own_states in zip(found, objects, states, strict=True)
    )


def _states(
    scene: Scene, structure: Structure, columns: Sequence[Sequence[np.ndarray]], motion: TrayMotion
) -> list[np.ndarray]:
    """Of each object its liquid in every sample, (m, n + 1, 2 k); all objects of a kind at once."""
    steps = (motion.body.shape[1] - 1) // 2
    all_states = [np.empty((len(of_object), steps + 1, 0)) for of_object in columns]
    alike: dict[Structure, list[int]] = {}
    for index, item in enumerate(structure.objects):
        if item.coordinates:
            alike.setdefault(object_kind(structure, item), []).append(index)
    for kind, indices in alike.items():
        starts = [
            np.tile(scene.cargo[index].initial_coordinates.ravel(), (len(columns[index]), 1)) for index in indices
        ]
        played = integrate(
            liquid_steps(kind),
            np.concatenate(starts),
            inputs=motion.body,
            lengths=np.full(steps, motion.step),
            parameters=np.array([one for index in indices for one in columns[index]]),
        ).transpose(1, 0, 2)
        for index, of_object in zip(indices, np.split(played, len(indices)), strict=True):
            all_states[index] = of_object
    return all_states


def _margins(
    structure: Structure,
    item: ObjectStructure,
    numbers: Sequence[ObjectNumbers],
    columns: Sequence[np.ndarray],
    states: np.ndarray,
    motion: TrayMotion,
    known: Mapping[str, Constraint],
) -> Margins:
    """Margins of one object from its liquid in every sample."""
    kind = limited_object_kind(structure, item)
    during, names = object_figures_function(kind, EvaluationPoint.OBJECT)
    ending = limited_object_kind(structure, item, end=structure.end)
    at_end, last_names = object_figures_function(ending, EvaluationPoint.END)
    constraints = tuple(known[name] for name in (*names, *last_names))
    body, figures = motion.body[:, ::2], np.empty((len(numbers), len(constraints), 2))
    for index, (drawn, parameters, state) in enumerate(zip(numbers, columns, states, strict=True)):
        q, qd = np.split(state.T, 2)
        rows = _worst(evaluate(during, [body, q, qd], parameters), constraints[: len(names)]) if names else []
        if last_names:
            final = evaluate(at_end, [q[:, -1:], qd[:, -1:]], parameters)
            rows = [*rows, *_worst(final, constraints[len(names) :])]
        figures[index] = np.reshape(rows, figures[index].shape)
        if item.modes > 1:
            _play_on(item, drawn, constraints, q[:, -1], qd[:, -1], figures[index])
    margin, limit = figures[..., 0], figures[..., 1]
    return Margins(constraints, np.where(np.isnan(margin), -np.inf, margin), limit)


def _to_second_order(
    found: Margins, objects: Sequence[Cargo], states: np.ndarray, motion: TrayMotion, scene: Scene
) -> Margins:
    """The same with heights of second order, during the motion and after it, in the place of the linear ones."""
    margin, body = found.margin.copy(), motion.body[:, ::2]
    columns = {constraint.name: index for index, constraint in enumerate(found.constraints)}
    for index, (drawn, state) in enumerate(zip(objects, states, strict=True)):
        q, qd = np.split(state, 2, axis=1)
        waves = waves_along(drawn, body, q, qd, motion.step)
        heights = {SloshHeight.name: float(np.max(waves.crests))}
        if left_to_second_order(scene):
            heights[ResidualHeight.name] = waves.highest_after(-1, scene.gravity)
        for column, height in ((columns[name], height) for name, height in heights.items() if name in columns):
            margin[index, column] = abs(found.limit[index, column]) - height
    return replace(found, margin=margin)


def _worst(figures: np.ndarray, constraints: Sequence[Constraint]) -> list[tuple[float, float]]:
    """Margin and limit of each constraint where most of it is used, from (3 c, m) values, limits and margins."""
    found = []
    for constraint, (_, limit, margin) in zip(constraints, figures.reshape(len(constraints), 3, -1), strict=True):
        place = int(np.argmax(limit_use(constraint, limit, margin)))
        found.append((float(margin[place]), float(limit[place])))
    return found


def _play_on(
    item: ObjectStructure,
    numbers: ObjectNumbers,
    constraints: Sequence[Constraint],
    q: np.ndarray,
    qd: np.ndarray,
    figures: np.ndarray,
) -> None:
    """Put the residual height as the judge finds it, from the free motion of many modes, in the place of its bound."""
    for figure, constraint in zip(figures, constraints, strict=True):
        if constraint.name == ResidualHeight.name:
            allowed = abs(float(figure[1]))
            figure[0] = allowed - residual_height(item, numbers, flatten(numbers), q, qd, allowed)
