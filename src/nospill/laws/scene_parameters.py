"""A scene's structure and numbers: what the laws read of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from nospill.laws.parameters import ObjectNumbers, ObjectStructure, OscillatorNumbers, SceneNumbers, Structure, flatten
from nospill.robots.description.urdf_tree import rotation_of
from nospill.robots.kinematics.dynamics import Load, load_of
from nospill.scene.cargo import Cargo
from nospill.scene.containers.base import DiscFootprint, Footprint, MassProperties
from nospill.scene.scene import Scene


@dataclass(frozen=True, slots=True, eq=False)
class _Known:
    """A scene and its payload as a key: the same objects, since they cannot be hashed by what they hold, nor change."""

    scene: Scene
    payload: Sequence[Cargo] | None = None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Known) and other.scene is self.scene and other.payload is self.payload

    def __hash__(self) -> int:
        return id(self.scene)


def structure_of(scene: Scene) -> Structure:
    """The structure of a scene; those of the last few scenes are kept."""
    return _structure(_Known(scene))


@lru_cache(maxsize=8)
def _structure(known: _Known) -> Structure:
    scene = known.scene
    axes = {"x": 0, "y": 1}
    objects = []
    for cargo in scene.cargo:
        oscillators = cargo.filling.modes.oscillators if cargo.filling else ()
        objects.append(
            ObjectStructure(
                footprint="disc" if isinstance(cargo.container.footprint, DiscFootprint) else "rectangle",
                oscillators=tuple(tuple(axes[d] for d in oscillator.directions) for oscillator in oscillators),
            )
        )
    return Structure(
        fidelity=scene.fidelity,
        tilt_free=scene.motion.tilt_free,
        end=scene.motion.end,
        spans=scene.path.coefficients.shape[1],
        degree=scene.path.coefficients.shape[0] - 1,
        urdf=scene.robot.urdf,
        joints=scene.robot.joints,
        tip=scene.robot.tip,
        objects=tuple(objects),
        joint_limits=tuple(name for name, limit in _further_limits(scene).items() if limit is not None),
        redundant=len(scene.robot.joints) > 6,
    )


def _further_limits(scene: Scene) -> dict[str, np.ndarray | None]:
    robot = scene.robot
    torque = robot.max_torque if robot.inertias_known else None
    return {"acceleration": robot.max_acceleration, "jerk": robot.max_jerk, "torque": torque}


def numbers_of(scene: Scene, payload: Sequence[Cargo] | None = None) -> SceneNumbers:
    """The numbers of a scene; those of the last few scenes are cached.

    `payload` is what the flange carries, where that is not the cargo of the scene.
    """
    return _numbers(_Known(scene, payload))


def flat_numbers(scene: Scene, payload: Sequence[Cargo] | None = None) -> np.ndarray:
    """The same as one vector, see `parameters.flatten`; read-only."""
    return _flat(_Known(scene, payload))


@lru_cache(maxsize=8)
def _flat(known: _Known) -> np.ndarray:
    flat = flatten(_numbers(known))
    flat.setflags(write=False)
    return flat


@lru_cache(maxsize=8)
def _numbers(known: _Known) -> SceneNumbers:
    scene = known.scene
    further = {
        name: np.zeros(len(scene.robot.joints)) if limit is None else limit
        for name, limit in _further_limits(scene).items()
    }
    load = flange_load(scene, known.payload)
    return SceneNumbers(
        gravity=scene.gravity,
        path_breaks=scene.path.breaks,
        path_coefficients=scene.path.coefficients,
        tool=scene.tray.tool.row,
        joint_lower=scene.robot.lower,
        joint_upper=scene.robot.upper,
        joint_speed_limit=scene.robot.max_speed,
        joint_acceleration_limit=further["acceleration"],
        joint_jerk_limit=further["jerk"],
        joint_torque_limit=further["torque"],
        self_motion=np.zeros(len(scene.robot.joints)),
        load_mass=load.mass,
        load_first_moment=load.first_moment,
        load_inertia=load.inertia,
        max_tilt=scene.motion.max_tilt,
        path_jerk_limit=scene.motion.path_jerk_limit,
        tilt_jerk_limit=scene.motion.tilt_jerk_limit,
        path_jerk_weight=scene.planning.path_jerk_weight,
        tilt_jerk_weight=scene.planning.tilt_jerk_weight,
        residual_fraction=scene.motion.residual_fraction,
        objects=tuple(object_numbers(cargo, scene) for cargo in scene.cargo),
    )


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
        own = turn @ rotation_of((0.0, 0.0, cargo.yaw))
        centre = tray.tool.position + turn @ np.append(cargo.position, 0.0) + own @ cargo.total.centre
        load += load_of(cargo.total.mass, centre, cargo.total.inertia, rotation=own)
    return load


def object_numbers(cargo: Cargo, scene: Scene) -> ObjectNumbers:
    """The numbers of one object for the scene's fidelity."""
    footprint, filling = cargo.container.footprint, cargo.filling
    mass, first_moment, inertia, spin_inertia = _rigid_part(cargo, scene)
    return ObjectNumbers(
        position=np.append(cargo.position, 0.0),
        yaw=cargo.yaw,
        mass=mass,
        first_moment=first_moment,
        inertia=inertia,
        spin_inertia=spin_inertia,
        weight=cargo.total.mass * scene.gravity,
        friction=cargo.planned_friction,
        footprint=_half_lengths(footprint),
        footprint_reserve=cargo.footprint_reserve,
        twist_radius=twist_radius(footprint),
        grip_radius=grip_radius(footprint),
        liquid_height=filling.liquid_height if filling else 0.0,
        max_slosh_height=filling.max_slosh_height if filling else 0.0,
        static_correction=np.asarray(filling.modes.static_correction) if filling else np.zeros(2),
        oscillators=tuple(
            OscillatorNumbers(
                frequency=mode.frequency,
                curvature=mode.curvature,
                mass=mode.mass,
                height=mode.height,
                damping=mode.damping,
                surface_gain=mode.surface_gain,
            )
            for mode in (filling.modes.oscillators if filling else ())
        ),
    )


def _rigid_part(cargo: Cargo, scene: Scene) -> tuple[float, np.ndarray, np.ndarray, float]:
    """Mass, first moment and inertia about the bottom centre of what moves with the container, and the spin inertia."""
    total = cargo.total
    if scene.fidelity == "deliverable":
        # The published object is a point mass at its centre of mass with an inertia against yaw.
        point = total.mass * _parallel_axis(total.centre)
        return total.mass, total.mass * total.centre, point, float(total.inertia[2, 2])
    if not cargo.filling:
        return total.mass, total.mass * total.centre, _about_bottom(total), 0.0
    empty, modes = cargo.empty, cargo.filling.modes
    # An ideal liquid in an upright cup does not take part in a turn about its axis: no yaw inertia.
    fixed = MassProperties(
        modes.fixed_mass, np.array([0.0, 0.0, modes.fixed_height]), np.diag([*np.asarray(modes.fixed_inertia), 0.0])
    )
    first_moment = empty.mass * empty.centre + fixed.mass * fixed.centre
    return empty.mass + fixed.mass, first_moment, _about_bottom(empty) + _about_bottom(fixed), 0.0


def _about_bottom(body: MassProperties) -> np.ndarray:
    return body.inertia + body.mass * _parallel_axis(body.centre)


def _parallel_axis(offset: np.ndarray) -> np.ndarray:
    return float(offset @ offset) * np.eye(3) - np.outer(offset, offset)


def _half_lengths(footprint: Footprint) -> np.ndarray:
    if isinstance(footprint, DiscFootprint):
        return np.array([footprint.radius, footprint.radius])
    return np.array([footprint.half_x, footprint.half_y])


def twist_radius(footprint: Footprint) -> float:
    """Mean distance of the footprint's points from its centre, m: friction moment per mu N under uniform pressure.

    2R/3 for a disc; for a rectangle with half lengths a, b and d = sqrt(a^2 + b^2):
    (d + a^2/(2b) log((b + d)/a) + b^2/(2a) log((a + d)/b)) / 3.
    """
    if isinstance(footprint, DiscFootprint):
        return 2.0 / 3.0 * footprint.radius
    a, b = footprint.half_x, footprint.half_y
    d = math.hypot(a, b)
    return (d + a * a / (2 * b) * math.log((b + d) / a) + b * b / (2 * a) * math.log((a + d) / b)) / 3.0


def grip_radius(footprint: Footprint) -> float:
    """Radius of gyration of the footprint about its weaker principal axis, m.

    R/2 for a disc, half the short side over sqrt(3) for a rectangle.
    Under uniform pressure and slip about a far centre at distance c, friction loses r^2/(2 c^2) of its force and gains
    a moment r^2/c per unit, so the ellipsoid |f|^2 + (M/r)^2 with this r touches the limit curve there from inside and
    stays inside everywhere.
    """
    if isinstance(footprint, DiscFootprint):
        return footprint.radius / 2.0
    return min(footprint.half_x, footprint.half_y) / math.sqrt(3.0)
