"""A scene's structure and numbers: what the laws read of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from functools import lru_cache
from operator import attrgetter
from typing import Any

import numpy as np

from nospill.core.arrays import parallel_axis, read_only
from nospill.core.trees import flatten
from nospill.laws.kinds import numbers_of_object
from nospill.laws.parameters import (
    BrakingNumbers,
    ObjectNumbers,
    OscillatorNumbers,
    SceneNumbers,
    ViaNumbers,
    blank_numbers,
    sources,
)
from nospill.laws.structure import YAW_AXES, ObjectStructure, Structure
from nospill.potential_flow.driven_numbers import driven_kind, driven_modes, driven_vector
from nospill.robots.description.urdf import without_place
from nospill.robots.description.urdf_tree import rotation_of
from nospill.robots.kinematics.dynamics import NO_LOAD, Load, load_of, torque_joints
from nospill.robots.robot import Robot
from nospill.scene.cargo import Cargo
from nospill.scene.containers.base import MassProperties
from nospill.scene.scene import Fidelity, MotionRules, Scene
from nospill.scene.sloshing.modes import WALL_POINTS, YAW
from nospill.scene.tray import Tray


@lru_cache(maxsize=8)
def structure_of(scene: Scene) -> Structure:
    """The structure of a scene; those of the last few scenes are cached."""
    return Structure(
        fidelity=scene.fidelity,
        tilt_free=scene.motion.tilt_free,
        end=scene.motion.end,
        spans=scene.path.prescribed.coefficients.shape[1],
        degree=scene.path.prescribed.coefficients.shape[0] - 1,
        urdf=without_place(scene.robot.urdf)[0],
        joints=scene.robot.joints,
        tip=scene.robot.tip,
        objects=tuple(object_structure(cargo) for cargo in scene.cargo),
        joint_limits=joint_limits(scene.robot),
        torque_joints=torque_joints(scene.robot),
        redundant=len(scene.robot.joints) > 6 and scene.path.joint_curve is None,
        offset_free=scene.motion.corridor is not None,
        vias=len(scene.motion.via),
        corridor_steps=len(scene.motion.corridor_shares),
        yaw_free=scene.motion.yaw_free,
        motion_limits=_motion_limits(scene.motion),
        braking=scene.robot.braking is not None,
        lagged=_lagged(scene),
        slowed=any(cargo.is_slowed for cargo in scene.cargo),
        constraints=tuple(item.on(scene) for item in scene.constraints),
        by_joints=scene.path.joint_curve is not None,
    )


def object_structure(cargo: Cargo) -> ObjectStructure:
    """The structure of one object."""
    axes = {"x": 0, "y": 1, YAW: YAW_AXES[0]}
    return ObjectStructure(
        footprint=type(cargo.container.footprint),
        oscillators=tuple(tuple(axes[axis] for axis in mode.directions) for mode in cargo.oscillators),
        flat=tuple(mode.curvature == 0.0 for mode in cargo.oscillators),
        shallow=cargo.filling is not None and cargo.filling.shallow,
        tense=_tense(cargo),
        spread=cargo.contents is not None and bool(cargo.oscillators),
        in_carrier=bool(cargo.carrier),
        slowed=cargo.is_slowed,
        constraints=cargo.constraints,
        fixed=cargo.fixed,
        lid=cargo.filling is not None and cargo.filling.lid,
        driven=driven_kind(cargo) if _drives(cargo) else "",
    )


def _drives(cargo: Cargo) -> bool:
    return cargo.filling is not None and cargo.filling.drives


def _tense(cargo: Cargo) -> bool:
    return any(mode.tension != 0.0 for mode in cargo.oscillators)


def joint_limits(robot: Robot) -> tuple[str, ...]:
    """`Structure.joint_limits` of a robot."""
    return tuple(name for name, limit in _further_limits(robot).items() if limit is not None)


def _lagged(scene: Scene) -> bool:
    """Whether accelerations are limited of a command that is not the motion itself."""
    controller = scene.controller
    compensated = controller is not None and controller.compensate and bool(np.any(controller.lag))
    return compensated and scene.robot.max_acceleration is not None


def _motion_limits(rules: MotionRules) -> tuple[str, ...]:
    """Limits of the motion that may be left out and are stated."""
    limits = {item.name: getattr(rules, item.name) for item in fields(rules) if item.default is None}
    own = (source.removeprefix("motion.") for source in sources(SceneNumbers).values())
    return tuple(name for name in own if limits.get(name) is not None)


def _further_limits(robot: Robot) -> dict[str, np.ndarray | None]:
    limited = torque_joints(robot)
    torque = None if robot.max_torque is None or not limited else np.zeros(len(robot.joints))
    if torque is not None and robot.max_torque is not None:
        torque[list(limited)] = robot.max_torque[list(limited)]
    return {"acceleration": robot.max_acceleration, "jerk": robot.max_jerk, "torque": torque}


def initial_coordinates(scene: Scene) -> np.ndarray:
    """Displacements (m) and velocities (m/s) of all slosh coordinates when the motion begins, shape (2, k)."""
    parts = [np.zeros((2, 0))]
    for cargo in scene.cargo:
        further = driven_modes(driven_kind(cargo)).states if _drives(cargo) else 0
        parts += [cargo.initial_coordinates, np.zeros((2, further))]
    return np.hstack(parts)


def numbers_of(scene: Scene, payload: Sequence[Cargo] | None = None) -> SceneNumbers:
    """The numbers of a scene; those of the last few scenes are cached.

    `payload` is what the flange carries, where that is not the cargo of the scene.
    """
    numbers = _numbers(scene)
    return numbers if payload is None else replace(numbers, **_load_numbers(scene, payload))


def flat_numbers(scene: Scene, payload: Sequence[Cargo] | None = None) -> np.ndarray:
    """The same as one vector, see `parameters.flatten`; read-only."""
    return _flat(scene) if payload is None else read_only(flatten(numbers_of(scene, payload)))


@lru_cache(maxsize=8)
def _flat(scene: Scene) -> np.ndarray:
    return read_only(flatten(_numbers(scene)))


@lru_cache(maxsize=8)
def flat_object_numbers(scene: Scene) -> tuple[np.ndarray, ...]:
    """Of every object what its laws read, `kinds.numbers_of_object`, as one vector; read-only.

    A judge reads them at every evaluation point, and of twenty modes they are hundreds.
    """
    numbers = _numbers(scene)
    return tuple(read_only(flatten(numbers_of_object(numbers, index))) for index in range(len(scene.cargo)))


@lru_cache(maxsize=8)
def _numbers(scene: Scene) -> SceneNumbers:
    blank, torque = blank_numbers(structure_of(scene)), _further_limits(scene.robot)["torque"]
    return replace(
        blank,
        **{name: value for name, value in _as_they_are(scene).items() if value is not None},
        base=without_place(scene.robot.urdf)[1],
        braking=_braking_numbers(scene.robot),
        lag=scene.controller.lag if scene.controller is not None and _lagged(scene) else np.zeros(0),
        max_torque=blank.max_torque if torque is None else torque,
        **_load_numbers(scene, scene.cargo),
        via=_via_numbers(scene),
        offset_jerk_limit=scene.motion.path_jerk_limit * scene.path_length,
        objects=tuple(object_numbers(cargo, fidelity=scene.fidelity, gravity=scene.gravity) for cargo in scene.cargo),
    )


def _as_they_are(scene: Scene) -> dict[str, Any]:
    """Numbers that the scene has as they are; None where a limit is not stated."""
    found = {name: attrgetter(source)(scene) for name, source in sources(SceneNumbers).items()}
    return {name: np.array(value) if isinstance(value, tuple) else value for name, value in found.items()}


def _via_numbers(scene: Scene) -> ViaNumbers:
    passed = scene.motion.via
    parameters, radii = (np.array([getattr(item, name) for item in passed]) for name in ("parameter", "radius"))
    return ViaNumbers(parameters, radii, np.full(len(passed), scene.path.length))


def _braking_numbers(robot: Robot) -> BrakingNumbers:
    own, none = robot.braking, np.zeros(0)
    if own is None:
        return BrakingNumbers(none, none, none, none, none)
    return BrakingNumbers(own.lower, own.upper, own.deceleration, own.offset, np.array([own.ahead]))


def _load_numbers(scene: Scene, payload: Sequence[Cargo]) -> dict[str, Any]:
    load = flange_load(scene, payload)
    return {"load_mass": load.mass, "load_first_moment": load.first_moment, "load_inertia": load.inertia}


def flange_load(scene: Scene, payload: Sequence[Cargo] | None = None) -> Load:
    """What the flange carries as one rigid body, flange axes: tray as an even plate, liquids at rest.

    On the tray stands `payload`, the cargo of the scene where there is none.
    """
    tray = scene.tray
    turn = tray.tool.rotation
    x, y = tray.size
    plate = tray.mass / 12.0 * np.diag([y * y, x * x, x * x + y * y])
    load = load_of(tray.mass, np.asarray(tray.tool.position), plate, rotation=turn)
    for cargo in scene.cargo if payload is None else payload:
        load += NO_LOAD if cargo.carrier else object_load(cargo, tray)
    return load


def object_load(cargo: Cargo, tray: Tray) -> Load:
    """What one object on the tray is for the flange, its liquid at rest, flange axes."""
    turn = tray.tool.rotation
    own = turn @ rotation_of((0.0, 0.0, cargo.yaw))
    centre = tray.tool.position + turn @ cargo.place + own @ cargo.total.centre
    return load_of(cargo.total.mass, centre, cargo.total.inertia, rotation=own)


def object_numbers(cargo: Cargo, *, fidelity: Fidelity, gravity: float) -> ObjectNumbers:
    """The numbers of one object at a fidelity, under a gravity in m/s^2.

    A motion at the part v of its speed is, in the time t v, the motion as planned in the gravity g/v^2 [equations of
    motion, t replaced]. A liquid has in it the frequencies omega/v and the damping ratios it had; forces and moments
    are those of the slow motion over v^2, and every limit on them is a ratio.
    """
    footprint, filling, speed = cargo.container.footprint, cargo.filling, cargo.speed
    mass, first_moment, inertia, spin_inertia = _rigid_part(cargo, fidelity)
    return ObjectNumbers(
        position=cargo.place,
        yaw=cargo.yaw,
        mass=mass,
        first_moment=first_moment,
        inertia=inertia,
        spin_inertia=spin_inertia,
        weight=cargo.total.mass * gravity / speed**2,
        planned_friction=cargo.planned_friction,
        half_lengths=footprint.half_lengths,
        footprint_reserve=cargo.footprint_reserve,
        twist_radius=footprint.twist_radius,
        grip_radius=footprint.grip_radius,
        held_at=cargo.held_at,
        liquid_height=filling.liquid_height if filling else 0.0,
        liquid_depth=filling.depth if filling else 0.0,
        max_slosh_height=_slosh_height(cargo),
        static_correction=np.asarray(filling.modes.static_correction) if filling else np.zeros(2),
        yaw_correction=_yaw_correction(cargo),
        added_gravity=np.full(int(cargo.is_slowed), gravity / speed**2 - gravity),
        driven=driven_vector(cargo) if _drives(cargo) else np.zeros(0),
        oscillators=tuple(
            OscillatorNumbers(
                frequency=mode.frequency / speed,
                stiffness=mode.stiffness,
                curvature=mode.curvature,
                mass=mode.mass,
                height=mode.height,
                damping=mode.damping,
                surface_gain=mode.surface_gain,
                tension=np.full(int(_tense(cargo)), mode.tension / speed**2),
                place=np.zeros(0) if cargo.contents is None else np.array(mode.place),
                arm=np.full(int(mode.yaws), mode.arm),
                wall_gains=np.array(mode.wall_gains),
            )
            for mode in cargo.oscillators
        ),
    )


def _yaws(cargo: Cargo) -> bool:
    return any(mode.yaws for mode in cargo.oscillators)


def _yaw_correction(cargo: Cargo) -> np.ndarray:
    """Of the yaw modes that are not carried; what a carrier feels has no surface of its own."""
    yaw = None if cargo.filling is None else cargo.filling.modes.yaw
    size = WALL_POINTS * int(_yaws(cargo))
    return np.zeros(size) if yaw is None or not size else np.asarray(yaw.static_correction)


def _slosh_height(cargo: Cargo) -> float:
    if cargo.contents is not None:
        return cargo.contents.slosh_height
    return cargo.filling.max_slosh_height if cargo.filling else 0.0


def _rigid_part(cargo: Cargo, fidelity: Fidelity) -> tuple[float, np.ndarray, np.ndarray, float]:
    """Mass, first moment and inertia about the bottom centre of what moves with the container, and the spin inertia."""
    total = cargo.total
    if fidelity == "deliverable":
        # The published object is a point mass at its centre of mass with an inertia against yaw.
        point = total.mass * parallel_axis(total.centre)
        return total.mass, total.mass * total.centre, point, float(total.inertia[2, 2])
    if cargo.contents is not None:
        empty, liquids = cargo.empty, cargo.contents
        first_moment = empty.mass * empty.centre + liquids.first_moment
        return empty.mass + liquids.mass, first_moment, _about_bottom(empty) + liquids.inertia, 0.0
    if not cargo.filling:
        return total.mass, total.mass * total.centre, _about_bottom(total), 0.0
    empty, fixed = cargo.empty, cargo.filling.fixed
    first_moment = empty.mass * empty.centre + fixed.mass * fixed.centre
    return empty.mass + fixed.mass, first_moment, _about_bottom(empty) + _about_bottom(fixed), 0.0


def _about_bottom(body: MassProperties) -> np.ndarray:
    return body.inertia + body.mass * parallel_axis(body.centre)
