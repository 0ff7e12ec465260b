"""The structure of a scene: what there is, apart from how large it is. It decides the shape of every expression."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import NamedTuple

from nospill.paths.joint_curves import POSE
from nospill.potential_flow.driven_numbers import DrivenKind, driven_modes
from nospill.scene.containers.footprints import Footprint
from nospill.scene.limits import Limit
from nospill.scene.scene import EndCondition, Fidelity

YAW_AXES = (2,)
"""`ObjectStructure.oscillators` of a yaw mode."""


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
        driven: what kind of waves that the modal masses leave out is among its slosh coordinates, after those of these.
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
    driven: DrivenKind = ""

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
        return self.linear_coordinates + self.driven_coordinates

    @property
    def driven_coordinates(self) -> int:
        """Number of those of waves that the modal masses leave out."""
        return driven_modes(self.driven).states if self.driven else 0

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
