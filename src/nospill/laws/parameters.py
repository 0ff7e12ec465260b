"""The numbers of a scene, apart from its structure.

`Structure` says what there is (hashable; it decides the shape of every expression); `SceneNumbers` holds how large it
is. A law reads a numbers record whose leaves are floats or SX alike: `flatten` turns a record into one parameter
vector, `symbolic` makes the same record with the entries of an SX vector as leaves.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import accumulate, pairwise
from typing import Any, NamedTuple, TypeVar

import casadi as ca
import numpy as np

from nospill.core.frames import SX
from nospill.scene.containers.footprints import Footprint
from nospill.scene.limits import Limit
from nospill.scene.scene import EndCondition, Fidelity

Number = Any
"""A float, a numpy array, or the SX expression that stands for it."""

Record = TypeVar("Record")


class Freedom(NamedTuple):
    """What the tray may do beside its way along the path; all of it starts and ends at zero.

    Attributes:
        tilt: pitch and roll.
        offset: its centre may leave the path, in any direction.
        yaw: it may turn otherwise than the path says.
    """

    tilt: bool = False
    offset: bool = False
    yaw: bool = False

    @property
    def tilt_chains(self) -> range:
        """Which of the tray's chains, of which s is the first, are the tilt angles."""
        return range(1, 3 if self.tilt else 1)

    @property
    def offset_chains(self) -> range:
        """Which of them are the offset from the path."""
        start = self.tilt_chains.stop
        return range(start, start + 3 * self.offset)

    @property
    def turn_chains(self) -> range:
        """Which of them is the yaw beside the path's."""
        start = self.offset_chains.stop
        return range(start, start + self.yaw)

    @property
    def chains(self) -> int:
        """How many chains move the tray, s among them."""
        return self.turn_chains.stop


@dataclass(frozen=True, slots=True)
class OscillatorNumbers:
    """One modal mass; fields as in `scene.containers.modes.Oscillator`, a curvature of zero where it is flat.

    The tension is (1,) where the object's structure is tense, else there is none; the place (2,) where it is spread.
    """

    frequency: Number
    stiffness: Number
    curvature: Number
    mass: Number
    height: Number
    damping: Number
    surface_gain: Number
    tension: Number = 0.0
    place: Number = 0.0


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
        liquid_height: of the surface at rest above the bottom, m, zero for a solid.
        liquid_depth: m, zero for a solid.
        max_slosh_height: m, zero for a solid; of a carrier the least of the liquids in it.
        static_correction: (2,) m, see `slosh.height`.
        added_gravity: (1,) m/s^2 where the object's structure is slowed, else there is none.
        oscillators: the modal masses.
    """

    position: Number
    yaw: Number
    mass: Number
    first_moment: Number
    inertia: Number
    spin_inertia: Number
    weight: Number
    planned_friction: Number
    half_lengths: Number
    footprint_reserve: Number
    twist_radius: Number
    grip_radius: Number
    liquid_height: Number
    liquid_depth: Number
    max_slosh_height: Number
    static_correction: Number
    added_gravity: Number
    oscillators: tuple[OscillatorNumbers, ...]


@dataclass(frozen=True, slots=True)
class BrakingNumbers:
    """Fields as in `robots.robot.Braking`; empty where there is none."""

    lower: Number
    upper: Number
    deceleration: Number
    offset: Number


@dataclass(frozen=True, slots=True)
class ViaNumbers:
    """Of each place that the tray passes: s on the path, radius, m, and the length of the path, m; (k,) each."""

    parameter: Number
    radius: Number
    way: Number


@dataclass(frozen=True, slots=True)
class SceneNumbers:
    """Everything the laws read, SI; arrays as in the records of the same names in scene, paths, tray and robots.

    Limits that are not set are zero and not read (`Structure.joint_limits`, `Structure.tray_limits`). The load is what
    the flange carries, tray and cargo with their liquids at rest: kg, first moment (3,) kg m and inertia (3, 3) kg m^2
    about the flange's origin, flange axes. self_motion (n,): direction whose product with q is the free parameter of a
    seven-joint arm, zero where there is none or a motion has not been chosen yet. tool (4,): `Tool.row` of the tray.
    base (4,): x, y, z in m and yaw in rad of the arm's base in the world of path and gravity.
    """

    gravity: Number
    path_breaks: Number
    path_coefficients: Number
    tool: Number
    base: Number
    joint_lower: Number
    joint_upper: Number
    max_speed: Number
    braking: BrakingNumbers
    max_acceleration: Number
    max_jerk: Number
    max_torque: Number
    self_motion: Number
    load_mass: Number
    load_first_moment: Number
    load_inertia: Number
    max_tilt: Number
    max_tray_speed: Number
    max_tray_acceleration: Number
    corridor: Number
    corridor_shares: Number
    via: ViaNumbers
    path_jerk_limit: Number
    tilt_jerk_limit: Number
    offset_jerk_limit: Number
    path_jerk_weight: Number
    tilt_jerk_weight: Number
    offset_jerk_weight: Number
    residual_fraction: Number
    objects: tuple[ObjectNumbers, ...]


@dataclass(frozen=True, slots=True)
class ObjectStructure:
    """What decides the shape of one object's expressions.

    Attributes:
        footprint: its class.
        oscillators: per oscillator, the horizontal directions it moves in (0 = x, 1 = y).
        flat: per oscillator, whether its mass moves on a plane, so that its law is linear.
        shallow: whether its surface may rise by more than its liquid is deep.
        tense: whether surface tension pulls at its surface.
        spread: whether its oscillators are those of liquids that it carries, off its middle.
        carried: whether it stands in a carrier, and no law of contact is its own.
        slowed: whether it is moved at another speed than the others.
        constraints: given from Python, that are about it.
    """

    footprint: type[Footprint]
    oscillators: tuple[tuple[int, ...], ...]
    flat: tuple[bool, ...]
    shallow: bool = False
    tense: bool = False
    spread: bool = False
    carried: bool = False
    slowed: bool = False
    constraints: tuple[Limit, ...] = ()

    @property
    def liquid(self) -> bool:
        """Whether it has a surface of its own."""
        return bool(self.oscillators) and not self.spread

    @property
    def coordinates(self) -> int:
        """Number of slosh coordinates of the object."""
        return sum(len(directions) for directions in self.oscillators)

    @property
    def modes(self) -> int:
        """Number of modes in each direction."""
        return max((sum(axis in own for own in self.oscillators) for axis in (0, 1)), default=0)

    @property
    def oscillator_slices(self) -> tuple[slice, ...]:
        """Of each oscillator, among the slosh coordinates of the object."""
        return _consecutive([len(directions) for directions in self.oscillators])


@dataclass(frozen=True, slots=True)
class Structure:
    """What decides the shape of the expressions.

    Attributes:
        joint_limits: which of "acceleration", "jerk" and "torque" are limited, beside position and speed.
        tray_limits: which of "speed" and "acceleration" of the tray's centre are limited.
        braking: whether joint speeds are limited near the ends of the ranges too.
        redundant: whether the arm has a seventh joint, and so a free parameter in every pose.
        regular: whether the problem keeps the arm away from singularities; off until a motion asks for it.
        slowed: whether objects are in it that are moved at another speed, and read where up is.
        vias: how many places the tray passes.
        corridor_steps: at how many places the width of the corridor is given; 0 where it is the same everywhere.
        constraints: given from Python.
    """

    fidelity: Fidelity
    tilt_free: bool
    end: EndCondition
    spans: int
    degree: int
    urdf: str
    joints: tuple[str, ...]
    tip: str
    objects: tuple[ObjectStructure, ...]
    joint_limits: tuple[str, ...] = ()
    redundant: bool = False
    regular: bool = False
    offset_free: bool = False
    yaw_free: bool = False
    tray_limits: tuple[str, ...] = ()
    braking: bool = False
    slowed: bool = False
    vias: int = 0
    corridor_steps: int = 0
    constraints: tuple[Limit, ...] = ()

    @property
    def freedom(self) -> Freedom:
        """What the tray may do beside its way along the path."""
        return Freedom(self.tilt_free, self.offset_free, self.yaw_free)

    @property
    def slosh_slices(self) -> tuple[slice, ...]:
        """Of each object, among the slosh coordinates of all; empty for a solid."""
        return _consecutive([item.coordinates for item in self.objects])


def _consecutive(lengths: Sequence[int]) -> tuple[slice, ...]:
    ends = list(accumulate(lengths, initial=0))
    return tuple(slice(start, stop) for start, stop in pairwise(ends))


def flatten(record: object) -> np.ndarray:
    """All leaves of a numbers record in field order (arrays column by column), shape (n,)."""
    leaves: list[float] = []
    _gather(record, leaves)
    return np.array(leaves, dtype=float)


def _gather(record: Any, leaves: list[float]) -> None:
    # A scene has hundreds of leaves, most of them numbers: a list of these is made in a sixth of the time of arrays.
    if isinstance(record, float):
        leaves.append(record)
    elif isinstance(record, np.ndarray):
        leaves.extend(record.ravel(order="F").tolist())
    elif isinstance(record, tuple):
        for item in record:
            _gather(item, leaves)
    elif names := _field_names(type(record)):
        for name in names:
            _gather(getattr(record, name), leaves)
    else:
        leaves.extend(np.asarray(record, dtype=float).ravel(order="F").tolist())


@cache
def _field_names(kind: type) -> tuple[str, ...]:
    """Of the records of a class, none where it is no class of records."""
    return tuple(field.name for field in dataclasses.fields(kind)) if dataclasses.is_dataclass(kind) else ()


def symbolic(template: Record, vector: SX) -> Record:
    """The record of the shape of `template` whose leaves are the entries of `vector`, in the order of `flatten`.

    Raises:
        ValueError: the vector has another length than the record has leaves.
    """
    size = len(flatten(template))
    if vector.numel() != size:
        raise ValueError(f"vector has {vector.numel()} entries, the record {size}")
    record, _ = _unflatten(template, vector, 0, _shaped)
    return record


def places(record: Record) -> Record:
    """The record whose leaves say where each entry stands in `flatten`: arrays of indices of the leaves' shapes."""
    found, _ = _unflatten(
        record, np.arange(len(flatten(record))), 0, lambda piece, shape: piece.reshape(shape, order="F")
    )
    return found


def constants(record: Record) -> Record:
    """The record with every leaf as a constant SX, so that laws can be evaluated on plain numbers."""
    return symbolic(record, SX(ca.DM(flatten(record))))


def _unflatten(template: Any, vector: Any, start: int, shaped: Callable[[Any, tuple[int, ...]], Any]) -> Any:
    if isinstance(template, tuple):
        items = []
        for item in template:
            value, start = _unflatten(item, vector, start, shaped)
            items.append(value)
        return tuple(items), start
    if names := _field_names(type(template)):
        values = {}
        for name in names:
            values[name], start = _unflatten(getattr(template, name), vector, start, shaped)
        return type(template)(**values), start
    shape = np.shape(template)
    size = math.prod(shape)
    return shaped(vector[start : start + size], shape), start + size


def _shaped(piece: SX, shape: tuple[int, ...]) -> Any:
    if len(shape) == 2:
        return ca.reshape(piece, *shape)
    if len(shape) == 3:
        # CasADi has no third axis: a list of matrices over the last one, which column order makes contiguous.
        step = shape[0] * shape[1]
        return [ca.reshape(piece[i * step : (i + 1) * step], shape[0], shape[1]) for i in range(shape[2])]
    return piece


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
    spans, joints, scalar = structure.spans, np.zeros(len(structure.joints)), 0.0
    braking = joints if structure.braking else np.zeros(0)
    return SceneNumbers(
        gravity=scalar,
        path_breaks=np.zeros(spans + 1),
        path_coefficients=np.zeros((structure.degree + 1, spans, 4)),
        tool=np.zeros(4),
        base=np.zeros(4),
        joint_lower=joints,
        joint_upper=joints,
        max_speed=joints,
        braking=BrakingNumbers(braking, braking, braking, braking),
        max_acceleration=joints,
        max_jerk=joints,
        max_torque=joints,
        self_motion=joints,
        load_mass=scalar,
        load_first_moment=np.zeros(3),
        load_inertia=np.zeros((3, 3)),
        max_tilt=scalar,
        max_tray_speed=scalar,
        max_tray_acceleration=scalar,
        corridor=scalar,
        corridor_shares=np.zeros(structure.corridor_steps),
        via=ViaNumbers(*[np.zeros(structure.vias)] * 3),
        path_jerk_limit=scalar,
        tilt_jerk_limit=scalar,
        offset_jerk_limit=scalar,
        path_jerk_weight=scalar,
        tilt_jerk_weight=scalar,
        offset_jerk_weight=scalar,
        residual_fraction=scalar,
        objects=tuple(_blank_object(item) for item in structure.objects),
    )


def _blank_object(item: ObjectStructure) -> ObjectNumbers:
    scalar = 0.0
    oscillator = OscillatorNumbers(
        frequency=scalar,
        stiffness=scalar,
        curvature=scalar,
        mass=scalar,
        height=scalar,
        damping=scalar,
        surface_gain=scalar,
        tension=np.zeros(int(item.tense)),
        place=np.zeros(2 * int(item.spread)),
    )
    return ObjectNumbers(
        position=np.zeros(3),
        yaw=scalar,
        mass=scalar,
        first_moment=np.zeros(3),
        inertia=np.zeros((3, 3)),
        spin_inertia=scalar,
        weight=scalar,
        planned_friction=scalar,
        half_lengths=np.zeros(2),
        footprint_reserve=scalar,
        twist_radius=scalar,
        grip_radius=scalar,
        liquid_height=scalar,
        liquid_depth=scalar,
        max_slosh_height=scalar,
        static_correction=np.zeros(2),
        added_gravity=np.zeros(int(item.slowed)),
        oscillators=(oscillator,) * len(item.oscillators),
    )
