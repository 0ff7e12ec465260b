"""One thing that stands on the tray."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from nospill.core.arrays import parallel_axis, read_only
from nospill.scene.containers.base import Container, MassProperties
from nospill.scene.limits import Limit
from nospill.scene.liquids import Liquid
from nospill.scene.sloshing.modes import Oscillator, SloshModes
from nospill.scene.surface_tension.tension import ContactLine
from nospill.scene.swing import Swing, coordinates


@dataclass(frozen=True, slots=True)
class Filling:
    """The liquid in a container.

    Attributes:
        liquid: which.
        liquid_height: of its surface at rest above the container's bottom, m.
        max_slosh_height: how far the surface may rise above that, m.
        modes: its equivalent mechanical model.
        floor: height of the lowest point of the inside above the container's bottom, m.
        freeboard_reserve: fraction of the way from the surface at rest to the rim that should be kept back.
        contact_line: how the surface meets the wall; empty where surface tension is left out.
        contact_angle: between wall and surface at rest, measured in the liquid, rad; None where it is not stated.
        initial_swing: of the liquid when the motion begins; None where it is at rest then.
        frequency_factor: on the frequencies of its modes, which `modes` have: what they are off by.
        turns: whether its container turns about its own axis, which makes yaw modes swing (`scene.turning`).
        lid: whether the container is closed, so that its surface may rise to any height.
        drives: whether the waves of second order that its modes drive are states of a problem.
    """

    liquid: Liquid
    liquid_height: float
    max_slosh_height: float
    modes: SloshModes
    freeboard_reserve: float = 0.1
    floor: float = 0.0
    contact_line: ContactLine = ""
    contact_angle: float | None = None
    initial_swing: Swing | None = None
    turns: bool = False
    frequency_factor: float = 1.0
    lid: bool = False
    drives: bool = False

    @property
    def oscillators(self) -> tuple[Oscillator, ...]:
        """Its modal masses, yaw modes among them where it turns."""
        yaw = self.modes.yaw if self.turns else None
        return self.modes.oscillators if yaw is None else (*self.modes.oscillators, *yaw.oscillators)

    @property
    def fixed(self) -> MassProperties:
        """What of the liquid moves with its container; in a body of revolution a turn about the axis moves nothing."""
        modes, yaw = self.modes, self.modes.yaw
        about_axis = 0.0 if yaw is None else yaw.fixed_inertia if self.turns else yaw.inertia
        inertia = np.diag([*np.asarray(modes.fixed_inertia), about_axis])
        return MassProperties(modes.fixed_mass, np.array([0.0, 0.0, modes.fixed_height]), inertia)

    @property
    def depth(self) -> float:
        """Depth of the liquid at rest, m."""
        return self.liquid_height - self.floor

    @property
    def breaking_height(self) -> float:
        """g/omega_1^2 without surface tension, m: where the crest of a standing wave of the slowest mode falls at g.

        0.54 R in a deep cylinder. Higher crests let go of the water below them and break [Penney and Price 1952,
        Taylor 1953]; no model of waves holds there.
        """
        return 1.0 / min(mode.stiffness for mode in self.modes.oscillators)

    @property
    def shallow(self) -> bool:
        """Whether the surface may rise on one side by more than the liquid is deep on the other."""
        return not self.lid and self.max_slosh_height > self.depth


@dataclass(frozen=True, slots=True)
class Tolerance:
    """How far the numbers of an object may be off; what is not given is certain.

    Attributes:
        friction: relative, either side, of the measured coefficient.
        liquid_height: either side, m, of the liquid at rest.
        damping: lowest and highest factor on the damping ratios.
        position: either side, m, in x and in y of the tray.
        mass: relative, either side, of the empty container or of the solid.
        pinned: whether the contact line may be pinned as well as free.
        contact_angle: either side, rad.
        frequency: relative, either side, of all modes of the liquid.
    """

    friction: float = 0.0
    liquid_height: float = 0.0
    damping: tuple[float, float] = (1.0, 1.0)
    position: float = 0.0
    mass: float = 0.0
    pinned: bool = False
    contact_angle: float = 0.0
    frequency: float = 0.0


@dataclass(frozen=True, slots=True)
class CarrierContents:
    """What stands in a carrier, as the carrier feels it, about its bottom centre, in its axes.

    Attributes:
        content: the objects, at their places on the tray, with the modes that are counted here.
        mass: of the parts of the liquids that move with it, kg; may be negative, see `SloshModes.fixed_mass`.
        first_moment: (3,) of the same, kg m.
        inertia: (3, 3) of the same, kg m^2.
        oscillators: modal masses that stand for those of all liquids.
        slosh_height: the least `max_slosh_height` of the liquids, m; 0 without any.
    """

    content: tuple[Cargo, ...]
    mass: float
    first_moment: np.ndarray
    inertia: np.ndarray
    oscillators: tuple[Oscillator, ...]
    slosh_height: float


@dataclass(frozen=True, slots=True)
class Cargo:
    """A named object on the tray, loose or fixed, standing on its bottom, or in another object that does.

    Attributes:
        name: unique on its tray.
        shape: key of the shape in the table of containers, as written in the scenario.
        container: its geometry.
        position: (2,) bottom centre in the tray frame, m.
        yaw: turn of the container frame about the tray's z, rad.
        total: mass properties of everything at rest (container and liquid frozen), container frame.
        empty: mass properties without the liquid (equal to `total` for a solid), container frame.
        friction: coefficient as measured between object and tray.
        friction_reserve: fraction of it kept back, 0 to below 1.
        footprint_reserve: fraction of the footprint kept back from tipping, 0 to below 1.
        filling: the liquid, or None for a solid object.
        tolerance: how far these numbers may be off, or None where all are certain.
        label: what people call it, of any letters; empty where that is the name.
        carrier: name of the object in which it stands, whose friction it has; empty where it stands on the tray.
        seat: height of its bottom above the tray, m.
        wall: height of the carrier's top above its bottom, m; 0 where it stands on the tray.
        contents: what stands in it; its masses are in `total` and, without the liquids, in `empty`.
        speed: part of the planned speed at which the tray moves it; below 1 of variants alone (`MotionRules.speeds`).
        constraints: those of `Scene.constraints` that are about it.
        fixed: whether it cannot move on what it stands on.
    """

    name: str
    shape: str
    container: Container
    position: np.ndarray
    yaw: float
    total: MassProperties
    empty: MassProperties
    friction: float
    friction_reserve: float
    footprint_reserve: float
    filling: Filling | None
    tolerance: Tolerance | None = None
    label: str = ""
    carrier: str = ""
    seat: float = 0.0
    wall: float = 0.0
    contents: CarrierContents | None = None
    speed: float = 1.0
    constraints: tuple[Limit, ...] = ()
    fixed: bool = False

    @property
    def is_slowed(self) -> bool:
        """Whether the tray moves it at another speed than planned."""
        return self.speed != 1.0

    @property
    def place(self) -> np.ndarray:
        """Bottom centre in the tray frame, (3,), m."""
        return np.append(self.position, self.seat)

    @property
    def held_at(self) -> float:
        """Height above its bottom, m, at which walls about it push at most, so as not to tip it the other way."""
        return min(self.wall, max(float(self.total.centre[2]), 0.0))

    @property
    def title(self) -> str:
        """What it is called wherever people read it: its label, or its name."""
        return self.label or self.name

    @property
    def planned_friction(self) -> float:
        """Friction the plan may use: measured value less the reserve."""
        return self.friction * (1.0 - self.friction_reserve)

    @property
    def oscillators(self) -> tuple[Oscillator, ...]:
        """Modal masses of the liquid, or of the liquids that it carries; none of another solid."""
        if self.contents is not None:
            return self.contents.oscillators
        return self.filling.oscillators if self.filling else ()

    @property
    def initial_coordinates(self) -> np.ndarray:
        """Displacements (m) and velocities (m/s) of its slosh coordinates when the motion begins, shape (2, k)."""
        return coordinates(self.filling.initial_swing if self.filling else None, self.oscillators)


def titles_of(cargo: Sequence[Cargo]) -> dict[str, str]:
    """What objects are called, by name; a name next to the label where two have the same one."""
    titles = [item.title for item in cargo]
    return {item.name: item.title if titles.count(item.title) == 1 else f"{item.title} ({item.name})" for item in cargo}


def frozen_liquid(container: Container, liquid: Liquid, liquid_height: float) -> MassProperties:
    """The liquid at rest up to a height (m) as a solid."""
    return container.frozen(liquid.density * container.volume(liquid_height), liquid_height)


def mass_at_rest(
    container: Container, empty: MassProperties, frozen: MassProperties, *, homogeneous: bool
) -> MassProperties:
    """Container and frozen liquid as one body.

    Args:
        container: its outer shape.
        empty: without liquid.
        frozen: the liquid at rest.
        homogeneous: take the whole as the homogeneous solid of the outer shape with its centre where it is, as the
            published computations do, instead of adding the inertias by the parallel-axis theorem.
    """
    total = combine_bodies([empty, frozen])
    return replace(container.solid_properties(total.mass), centre=total.centre) if homogeneous else total


def combine_bodies(bodies: Sequence[MassProperties]) -> MassProperties:
    """Bodies in one frame as one: inertias moved to the common centre by the parallel-axis theorem."""
    mass = sum(body.mass for body in bodies)
    centre = sum((body.mass * body.centre for body in bodies), np.zeros(3)) / mass
    inertia = sum((body.inertia + body.mass * parallel_axis(body.centre - centre) for body in bodies), np.zeros((3, 3)))
    return MassProperties(mass, read_only(centre), read_only(inertia))
