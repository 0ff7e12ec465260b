"""The numbers of a scene, apart from its structure.

`Structure` says what there is (hashable; it decides the shape of every expression); `SceneNumbers` holds how large it
is. A law reads a numbers record whose leaves are floats or SX alike (`core.trees`). Each field of a record says its
shape, and where the scene has its number.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import accumulate, pairwise
from typing import Annotated, Any, NamedTuple, TypeVar, get_type_hints

import numpy as np

from nospill.core.frames import SX
from nospill.core.trees import flatten, symbolic
from nospill.paths.joint_curves import POSE
from nospill.potential_flow.driven_numbers import driven_size
from nospill.robots.tool import TOOL_NUMBERS
from nospill.scene.containers.footprints import Footprint
from nospill.scene.limits import Limit
from nospill.scene.scene import EndCondition, Fidelity
from nospill.scene.sloshing.modes import WALL_POINTS

YAW_AXES = (2,)
"""`ObjectStructure.oscillators` of a yaw mode."""

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


class Freedom(NamedTuple):
    """What the tray may do beside its way along the path; all of it starts and ends at zero.

    Attributes:
        tilt: pitch and roll.
        offset: its centre may leave the path, in any direction.
        yaw: it may turn otherwise than the path says.
        by_joints: the path is one of the joints, which lean the tray as they do; it has no freedom beside it.
    """

    tilt: bool = False
    offset: bool = False
    yaw: bool = False
    by_joints: bool = False

    @property
    def leans(self) -> bool:
        """Whether the tray may be other than level."""
        return self.tilt or self.by_joints

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
    return (driven_size() if item.driven else 0,)


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
        driven: of the modes of second order that are carried, `potential_flow.driven_numbers`; empty without any.
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


@dataclass(frozen=True, slots=True)
class ObjectStructure:
    """What decides the shape of one object's expressions.

    Attributes:
        footprint: its class.
        oscillators: per oscillator, the directions it moves in (0 = x, 1 = y; 2 alone of a yaw mode).
        flat: per oscillator, whether its mass moves on a plane, so that its law is linear.
        shallow: whether its surface may rise by more than its liquid is deep.
        tense: whether surface tension pulls at its surface.
        spread: whether its oscillators are those of liquids that it carries, off its middle.
        in_carrier: whether it stands in a carrier, which keeps it from sliding.
        slowed: whether it is moved at another speed than the others.
        constraints: given from Python, that are about it.
        fixed: whether it cannot move on what it stands on.
        lid: whether its liquid is closed in.
        driven: number of modes of second order among its slosh coordinates, after those of the modal masses.
    """

    footprint: type[Footprint]
    oscillators: tuple[tuple[int, ...], ...]
    flat: tuple[bool, ...]
    shallow: bool = False
    tense: bool = False
    spread: bool = False
    in_carrier: bool = False
    slowed: bool = False
    constraints: tuple[Limit, ...] = ()
    fixed: bool = False
    lid: bool = False
    driven: int = 0

    @property
    def yaws(self) -> bool:
        """Whether it has yaw modes."""
        return YAW_AXES in self.oscillators

    @property
    def liquid(self) -> bool:
        """Whether it has a surface of its own."""
        return bool(self.oscillators) and not self.spread

    @property
    def open(self) -> bool:
        """Whether its liquid may spill."""
        return self.liquid and not self.lid

    @property
    def coordinates(self) -> int:
        """Number of slosh coordinates of the object."""
        return self.linear_coordinates + self.driven

    @property
    def linear_coordinates(self) -> int:
        """Number of those of the modal masses."""
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
        torque_joints: indices of the joints whose torque is limited; others have zero in the place of a limit.
        motion_limits: which limits of the motion are stated that need not be, by their names in `MotionRules`.
        braking: whether joint speeds are limited near the ends of the ranges too.
        lagged: whether accelerations are limited of a command too, which compensates for lags of the joints.
        redundant: whether the arm has a seventh joint, and so a free parameter in every pose.
        regular: whether the problem keeps the arm away from singularities; off until a motion asks for it.
        slowed: whether objects are in it that are moved at another speed, and read where up is.
        vias: how many places the tray passes.
        corridor_steps: at how many places the width of the corridor is given; 0 where it is the same everywhere.
        constraints: given from Python.
        by_joints: whether the path is one of the joints.
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
    torque_joints: tuple[int, ...] = ()
    redundant: bool = False
    regular: bool = False
    offset_free: bool = False
    yaw_free: bool = False
    motion_limits: tuple[str, ...] = ()
    braking: bool = False
    lagged: bool = False
    slowed: bool = False
    vias: int = 0
    corridor_steps: int = 0
    constraints: tuple[Limit, ...] = ()
    by_joints: bool = False

    @property
    def freedom(self) -> Freedom:
        """What the tray may do beside its way along the path."""
        return Freedom(self.tilt_free, self.offset_free, self.yaw_free, self.by_joints)

    @property
    def path_columns(self) -> int:
        """Columns of what the path says, `Path.prescribed`."""
        return POSE + len(self.joints) if self.by_joints else 4

    @property
    def slosh_slices(self) -> tuple[slice, ...]:
        """Of each object, among the slosh coordinates of all; empty for a solid."""
        return _consecutive([item.coordinates for item in self.objects])


def _consecutive(lengths: Sequence[int]) -> tuple[slice, ...]:
    ends = list(accumulate(lengths, initial=0))
    return tuple(slice(start, stop) for start, stop in pairwise(ends))


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
