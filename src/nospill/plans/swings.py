"""How the liquids of a plan swing at any instant of its motion and after it, in the form that a motion begins with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace

import numpy as np

from nospill.certification.by_flow import beyond_masses_at
from nospill.certification.full_model import full_scene
from nospill.certification.replay import Replay, replay, states_at
from nospill.certification.run import run_of
from nospill.certification.second_order import waves_along
from nospill.errors import ScenarioError
from nospill.laws.scene_parameters import structure_of
from nospill.motion.holds import held_trajectory
from nospill.motion.trajectory import Trajectory
from nospill.scene.cargo import Cargo
from nospill.scene.heights import to_second_order
from nospill.scene.perturbation import Perturbation, perturbed
from nospill.scene.scene import Scene
from nospill.scene.swing import LiquidOffset, Swing, swing_of
from nospill.scene.variants import liquid_offsets


def swings_at(
    record: Trajectory, scene: Scene, t: np.ndarray | None, wait: float = 0.0, following: Sequence[Cargo] = ()
) -> list[dict[str, Swing]]:
    """How the liquids of a planned motion swing at some times, all modes of the full model, by object, for each.

    Args:
        record: of the motion.
        scene: of it, with the swing that it begins with. Times within a motion by the published equations follow these.
        t: (m,) s on the record's clock; None for the end of all, the wait included, of which no flow is told.
        wait: s, for which the arm stands after the motion and its hold; rounded up to whole samples.
        following: the objects of the next motion: where the numbers of one may be off, its liquid is carried through
            the plan's motion with every one of these numbers, from the swing that it began that motion with.

    Raises:
        ScenarioError: the motion begins with a swing that is not known of a liquid whose numbers are off.
        ModelError: the liquids cannot be integrated.
    """
    if t is None or scene.fidelity == "full":
        scene = full_scene(scene)
    held = held_trajectory(record, replace(scene.motion, hold_after=scene.motion.hold_after + wait))
    run = run_of(held, scene.controller)

    def left(cargo: Sequence[Cargo]) -> list[list[Swing]]:
        """Of liquids, at every time."""
        carried = replace(scene, cargo=tuple(cargo))
        played, slices = replay(run.record, carried, motion=run.motion), structure_of(carried).slosh_slices
        times = played.t[-1:] if t is None else t
        displacement, velocity = states_at(played, times)
        found = []
        for item, own in zip(cargo, slices, strict=True):
            coordinates = zip(displacement[own].T, velocity[own].T, strict=True)
            swings = [swing_of(item.oscillators, q, rate) for q, rate in coordinates]
            is_known = scene.fidelity == "full" and to_second_order(item, "second order")
            found.append(_with_second(swings, item, played, own, times) if is_known else swings)
        if scene.fidelity != "full" or t is None:
            return found
        beyond = beyond_masses_at(carried, played, t)
        return [
            _with_flow(swings, beyond[item.name]) if item.name in beyond else swings
            for item, swings in zip(cargo, found, strict=True)
        ]

    liquids = {cargo.name: cargo for cargo in scene.cargo if cargo.filling is not None}
    swings = dict(zip(liquids, left([*liquids.values()]), strict=True)) if liquids else {}
    offsets = {cargo.name: liquid_offsets(cargo) for cargo in following if cargo.name in liquids}
    variants: dict[str, list[tuple[LiquidOffset, list[Swing]]]] = {name: [] for name in offsets}
    for number in range(max(map(len, offsets.values()), default=0)):
        some = {name: own[number] for name, own in offsets.items() if number < len(own)}
        changed = [_offset(liquids[name], offset, scene) for name, offset in some.items()]
        for (name, offset), own in zip(some.items(), left(changed), strict=True):
            variants[name].append((offset, own))
    return [
        {
            name: replace(
                own[index], variants=tuple((offset, swings[index]) for offset, swings in variants.get(name, ()))
            )
            for name, own in swings.items()
        }
        for index in range(1 if t is None else len(t))
    ]


def with_own_second_order(
    swings: Sequence[dict[str, Swing]], record: Trajectory, scene: Scene, t: np.ndarray
) -> list[dict[str, Swing]]:
    """Swings of the full model at some times with the second order that the scene's own modes drive.

    A motion that goes on in the same scene is judged with as many modes as it states; with the second order of all of
    them its crests would be others than those of the whole motion.

    Args:
        swings: at the times, as `swings_at` has them.
        record: of the motion.
        scene: of it; as they are where it has all modes.
        t: (m,) s, the times.

    Raises:
        ModelError: the liquids cannot be integrated.
    """
    known = list(map(dict, swings))
    if scene.fewer_modes is None or scene.fidelity != "full":
        return known
    run = run_of(held_trajectory(record, scene.motion), scene.controller)
    played = replay(run.record, scene, motion=run.motion)
    for item, part in zip(scene.cargo, structure_of(scene).slosh_slices, strict=True):
        if item.filling is None or not to_second_order(item, "second order"):
            continue
        own = _with_second([found[item.name] for found in known], item, played, part, t)
        for found, swing in zip(known, own, strict=True):
            found[item.name] = swing
    return known


def _with_second(swings: list[Swing], cargo: Cargo, played: Replay, own: slice, times: np.ndarray) -> list[Swing]:
    """The swings of a liquid at some times with what they drive to the second order."""
    q, qd = played.slosh_displacement[:, own], played.slosh_velocity[:, own]
    states = waves_along(cargo, played.body, q, qd, 1.0 / played.rate).added.reshape(len(played.t), -1)
    columns = [np.interp(times, played.t, column) for column in states.T]
    at_times = np.stack(columns, axis=1).reshape(len(times), 2, -1)
    return [
        replace(swing, second_height=tuple(height.tolist()), second_velocity=tuple(rate.tolist()))
        for swing, (height, rate) in zip(swings, at_times, strict=True)
    ]


def _with_flow(swings: list[Swing], beyond: np.ndarray) -> list[Swing]:
    """The swings of a liquid at some times with what its flow has beyond them, (m, 2, J); as is where it broke down."""
    return [
        replace(swing, flow_height=tuple(height.tolist()), flow_potential=tuple(potential.tolist()))
        if np.all(np.isfinite(height))
        else swing
        for swing, (height, potential) in zip(swings, beyond, strict=True)
    ]


def _offset(cargo: Cargo, offset: LiquidOffset, scene: Scene) -> Cargo:
    """An object of a motion whose liquid is off as one of the next motion is."""
    by = Perturbation(
        liquid_height=offset.liquid_height,
        damping=offset.damping,
        position=offset.position,
        pinned=offset.pinned,
        contact_angle=offset.contact_angle,
        frequency=offset.frequency,
    )
    swing = cargo.filling.initial_swing if cargo.filling else None
    if swing is not None and swing.of(offset) is None:
        raise ScenarioError(
            f'cargo "{cargo.name}": {scene.name}, the motion before, begins with a swing that is not known with '
            f"{by.text(cargo)}; give both motions, and those before them, the same tolerance"
        )
    return perturbed(cargo, by, fidelity=scene.fidelity)


def swing_table(swing: Swing) -> dict[str, object]:
    """A swing as a scenario states it."""
    table: dict[str, object] = {
        "displacement": [*map(list, swing.displacement)],
        "velocity": [*map(list, swing.velocity)],
    }
    if swing.yaw_displacement:
        table |= {"yaw_displacement": [*swing.yaw_displacement], "yaw_velocity": [*swing.yaw_velocity]}
    if swing.second_height:
        table |= {"second_height": [*swing.second_height], "second_velocity": [*swing.second_velocity]}
    if swing.variants:
        table["variant"] = [_perturbation_table(offset) | swing_table(item) for offset, item in swing.variants]
    return table


def _perturbation_table(offset: LiquidOffset) -> dict[str, object]:
    values = asdict(offset) | {"position": list(offset.position)}
    usual = asdict(LiquidOffset()) | {"position": [0.0, 0.0]}
    return {key: value for key, value in values.items() if value != usual[key]}
