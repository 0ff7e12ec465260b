"""The numbers of a scene, apart from its structure.

`laws.structure` says what there is (hashable; it decides the shape of every expression); `SceneNumbers` holds how large
it is. A law reads a numbers record whose leaves are floats or SX alike (`core.trees`). Each field of a record says its
shape, and where the scene has its number.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, TypeVar, get_type_hints

import numpy as np

from nospill.core.frames import SX
from nospill.core.trees import flatten, symbolic
from nospill.laws.structure import YAW_AXES, ObjectStructure, Structure
from nospill.potential_flow.driven_numbers import driven_size
from nospill.robots.tool import TOOL_NUMBERS
from nospill.scene.sloshing.modes import WALL_POINTS

Number = Any
"""A float, a numpy array, or the SX expression that stands for it."""

Record = TypeVar("Record")


@dataclass(frozen=True, slots=True)
class Of:
    """What a field of a record of numbers says beside its name.

    Attributes:
        source: where the scene has the number as it is, by attributes ("motion.max_tilt"); empty where it is computed.
            A limit that is None there is zero here, and no law reads it.
        shape: of an array, or how the structure decides it; () of a scalar.
    """

    source: str = ""
    shape: tuple[int, ...] | Callable[[Any], tuple[int, ...]] = ()


def joints(structure: Structure) -> tuple[int, ...]:
    """Shape of one number a joint."""
    return (len(structure.joints),)


def wall_points(item: ObjectStructure) -> tuple[int, ...]:
    """Shape of one number a place of a box's wall, where its yaw modes swing."""
    return (WALL_POINTS * int(item.yaws),)


@dataclass(frozen=True, slots=True)
class OscillatorNumbers:
    """One modal mass; fields as in `scene.containers.modes.Oscillator`, a curvature of zero where it is flat.

    The tension is (1,) where the object's structure is tense, else there is none; the place (2,) where it is spread;
    of a yaw mode the arm (1,), m, and the wall gains (9,), else there is none.
    """

    frequency: Number
    stiffness: Number
    curvature: Number
    mass: Number
    height: Number
    damping: Number
    surface_gain: Number
    tension: Annotated[Number, Of(shape=lambda item: (int(item.tense),))] = 0.0
    place: Annotated[Number, Of(shape=lambda item: (2 * int(item.spread),))] = 0.0
    arm: Annotated[Number, Of(shape=lambda item: (int(item.yaws),))] = 0.0
    wall_gains: Annotated[Number, Of(shape=wall_points)] = 0.0


def _driven(item: ObjectStructure) -> tuple[int, ...]:
    return (driven_size(item.driven),)


@dataclass(frozen=True, slots=True)
class ObjectNumbers:
    """One object on the tray, SI.

    Attributes:
        position: (3,) bottom centre in the tray frame.
        yaw: of the object on the tray.
        mass, first_moment, inertia: of the part that moves with the container, about the bottom centre, object axes:
            () kg, (3,) kg m, (3, 3) kg m^2. Referred to a fixed point, they stay regular when the fixed liquid's mass
            is small or negative.
        spin_inertia: kg m^2, an inertia that counts for turns about the z axis only.
        weight: of everything, N, the scale of forces.
        planned_friction: coefficient the plan may use: the stated one less its reserve.
        half_lengths: (2,) of the footprint, m.
        footprint_reserve: part of them that the plan keeps from tipping.
        twist_radius: of the footprint, m, see `Footprint`.
        grip_radius: likewise.
        held_at: height at which the walls of a carrier hold it, m, see `Tip`; zero on the tray.
        liquid_height: of the surface at rest above the bottom, m, zero for a solid.
        liquid_depth: m, zero for a solid.
        max_slosh_height: m, zero for a solid; of a carrier the least of the liquids in it.
        static_correction: (2,) m, see `slosh.height`.
        yaw_correction: (9,) m^2 where the object's structure yaws, see `slosh.height`, else there is none.
        added_gravity: (1,) m/s^2 where the object's structure is slowed, else there is none.
        driven: of the waves carried beside the modal masses, `potential_flow.driven_numbers`; empty without any.
        oscillators: the modal masses.
    """

    position: Annotated[Number, Of(shape=(3,))]
    yaw: Number
    mass: Number
    first_moment: Annotated[Number, Of(shape=(3,))]
    inertia: Annotated[Number, Of(shape=(3, 3))]
    spin_inertia: Number
    weight: Number
    planned_friction: Number
    half_lengths: Annotated[Number, Of(shape=(2,))]
    footprint_reserve: Number
    twist_radius: Number
    grip_radius: Number
    held_at: Number
    liquid_height: Number
    liquid_depth: Number
    max_slosh_height: Number
    static_correction: Annotated[Number, Of(shape=(2,))]
    yaw_correction: Annotated[Number, Of(shape=wall_points)]
    added_gravity: Annotated[Number, Of(shape=lambda item: (int(item.slowed),))]
    driven: Annotated[Number, Of(shape=_driven)]
    oscillators: tuple[OscillatorNumbers, ...]


def _braking(structure: Structure) -> tuple[int, ...]:
    return (len(structure.joints) if structure.braking else 0,)


@dataclass(frozen=True, slots=True)
class BrakingNumbers:
    """Fields as in `robots.robot.Braking`, the time (1,); empty where there is none."""

    lower: Annotated[Number, Of(shape=_braking)]
    upper: Annotated[Number, Of(shape=_braking)]
    deceleration: Annotated[Number, Of(shape=_braking)]
    offset: Annotated[Number, Of(shape=_braking)]
    ahead: Annotated[Number, Of(shape=lambda whole: (int(whole.braking),))]


@dataclass(frozen=True, slots=True)
class ViaNumbers:
    """Of each place that the tray passes: s on the path, radius, m, and the length of the path, m; (k,) each."""

    parameter: Annotated[Number, Of(shape=lambda whole: (whole.vias,))]
    radius: Annotated[Number, Of(shape=lambda whole: (whole.vias,))]
    way: Annotated[Number, Of(shape=lambda whole: (whole.vias,))]


@dataclass(frozen=True, slots=True)
class SceneNumbers:
    """Everything the laws read, SI; arrays as in the records of the same names in scene, paths, tray and robots.

    Limits that are not set are zero and not read (`Structure.joint_limits`, `Structure.motion_limits`). The load is
    what the flange carries, tray and cargo with their liquids at rest: kg, first moment (3,) kg m and inertia (3, 3)
    kg m^2 about the flange's origin, flange axes. tool (12,): `Tool.row` of the tray. base (4,): x, y, z in m and yaw
    in rad of the arm's base in the world of path and gravity.
    """

    gravity: Annotated[Number, Of("gravity")]
    path_breaks: Annotated[Number, Of("path.prescribed.breaks", lambda whole: (whole.spans + 1,))]
    path_coefficients: Annotated[
        Number,
        Of("path.prescribed.coefficients", lambda whole: (whole.degree + 1, whole.spans, whole.path_columns)),
    ]
    tool: Annotated[Number, Of("tray.tool.row", (TOOL_NUMBERS,))]
    base: Annotated[Number, Of(shape=(4,))]
    joint_lower: Annotated[Number, Of("robot.lower", joints)]
    joint_upper: Annotated[Number, Of("robot.upper", joints)]
    max_speed: Annotated[Number, Of("robot.max_speed", joints)]
    braking: BrakingNumbers
    lag: Annotated[Number, Of(shape=lambda whole: (len(whole.joints) if whole.lagged else 0,))]
    max_acceleration: Annotated[Number, Of("robot.max_acceleration", joints)]
    max_jerk: Annotated[Number, Of("robot.max_jerk", joints)]
    max_torque: Annotated[Number, Of(shape=joints)]
    load_mass: Number
    load_first_moment: Annotated[Number, Of(shape=(3,))]
    load_inertia: Annotated[Number, Of(shape=(3, 3))]
    max_tilt: Annotated[Number, Of("motion.max_tilt")]
    max_tray_speed: Annotated[Number, Of("motion.max_speed")]
    max_tray_acceleration: Annotated[Number, Of("motion.max_acceleration")]
    corridor: Annotated[Number, Of("motion.corridor")]
    corridor_shares: Annotated[Number, Of("motion.corridor_shares", lambda whole: (whole.corridor_steps,))]
    via: ViaNumbers
    path_jerk_limit: Annotated[Number, Of("motion.path_jerk_limit")]
    tilt_jerk_limit: Annotated[Number, Of("motion.tilt_jerk_limit")]
    offset_jerk_limit: Number
    residual_fraction: Annotated[Number, Of("motion.residual_fraction")]
    objects: tuple[ObjectNumbers, ...]


def parameter_count(structure: Structure) -> int:
    """Number of leaves of the numbers of a structure."""
    return len(flatten(blank_numbers(structure)))


def symbolic_numbers(structure: Structure, vector: SX) -> SceneNumbers:
    """The numbers of a structure whose leaves are the entries of `vector`, in the order of `flatten`.

    Where the structure knows a number, the expressions have no symbol for it (`with_known_curvatures`).
    """
    numbers = symbolic(blank_numbers(structure), vector)
    pairs = zip(structure.objects, numbers.objects, strict=True)
    return dataclasses.replace(numbers, objects=tuple(with_known_curvatures(item, own) for item, own in pairs))


def with_known_curvatures(structure: ObjectStructure, numbers: ObjectNumbers) -> ObjectNumbers:
    """An object's symbolic numbers with a curvature of zero for its flat modes, of their stiffness for the others."""
    oscillators = tuple(
        dataclasses.replace(own, curvature=SX(0) if flat else own.stiffness)
        for own, flat in zip(numbers.oscillators, structure.flat, strict=True)
    )
    return dataclasses.replace(numbers, oscillators=oscillators)


def object_parameter_count(structure: ObjectStructure) -> int:
    """Number of leaves of the numbers of one object."""
    return len(flatten(_blank_object(structure)))


def symbolic_object_numbers(structure: ObjectStructure, vector: SX) -> ObjectNumbers:
    """`symbolic_numbers` of one object alone."""
    return with_known_curvatures(structure, symbolic(_blank_object(structure), vector))


def blank_numbers(structure: Structure) -> SceneNumbers:
    """Zeros of the shapes that a structure decides."""
    return _zeros(
        SceneNumbers,
        structure,
        braking=_zeros(BrakingNumbers, structure),
        via=_zeros(ViaNumbers, structure),
        objects=tuple(_blank_object(item) for item in structure.objects),
    )


def _blank_object(item: ObjectStructure) -> ObjectNumbers:
    yaw, plain = (
        _zeros(OscillatorNumbers, item),
        _zeros(OscillatorNumbers, item, arm=np.zeros(0), wall_gains=np.zeros(0)),
    )
    oscillators = tuple(yaw if directions == YAW_AXES else plain for directions in item.oscillators)
    return _zeros(ObjectNumbers, item, oscillators=oscillators)


def _zeros(record: type[Record], whole: Structure | ObjectStructure, **parts: Any) -> Record:
    """A record of zeros, apart from its parts."""
    found = dict(parts)
    for name, field in _fields(record).items():
        shape = field.shape if isinstance(field.shape, tuple) else field.shape(whole)
        found.setdefault(name, np.zeros(shape) if field.shape else 0.0)
    return record(**found)


def sources(record: type) -> dict[str, str]:
    """Names of a record's numbers -> where the scene has each, of those that it has as they are."""
    return {name: field.source for name, field in _fields(record).items() if field.source}


@cache
def _fields(record: type) -> Mapping[str, Of]:
    """What the fields of a record say, by name."""
    hints = get_type_hints(record, include_extras=True)
    said = ((name, getattr(hint, "__metadata__", ())) for name, hint in hints.items())
    return {name: next((item for item in items if isinstance(item, Of)), Of()) for name, items in said}
