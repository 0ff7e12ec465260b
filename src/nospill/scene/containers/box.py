"""The upright rectangular box."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from nospill.core.arrays import read_only
from nospill.scene.containers.base import MassProperties
from nospill.scene.containers.footprints import RectangleFootprint
from nospill.scene.liquids import Liquid
from nospill.scene.sloshing.modes import SloshModes
from nospill.scene.sloshing.prism import (
    EMPIRICAL_DAMPING,
    LARGEST_DAMPING,
    FrozenLiquid,
    PrismMode,
    check_filling,
    check_size,
    inverse_sinh_ratio,
    prism_inside,
    prism_outside,
    slosh_model,
    thick_damping,
)
from nospill.scene.sloshing.yaw_modes import yaw_modes

_TORSION_TERMS = 400


@dataclass(frozen=True, slots=True)
class Box:
    """Upright box.

    Attributes:
        length: side along its x, inside and outside (thin wall), m.
        width: side along its y, m.
        height: rim, or top of a solid, above the bottom, m.
    """

    length: float
    width: float
    height: float

    def __post_init__(self) -> None:
        check_size(self.length, "length")
        check_size(self.width, "width")
        check_size(self.height, "height")

    @property
    def footprint(self) -> RectangleFootprint:
        """The whole bottom."""
        return RectangleFootprint(self.length / 2, self.width / 2)

    @property
    def outline(self) -> np.ndarray:
        """The four corners of the bottom, counter-clockwise, shape (4, 2), m."""
        return self.footprint.core

    @property
    def inside(self) -> np.ndarray:
        """Bottom and wall, (3, 2)."""
        return prism_inside(self.height)

    @property
    def outside(self) -> np.ndarray:
        """The wall, (2, 2)."""
        return prism_outside(self.height)

    def section(self, liquid_height: float) -> RectangleFootprint:
        """The same at every height."""
        return self.footprint

    def frozen(self, mass: float, liquid_height: float) -> MassProperties:
        """A solid that is as high as the liquid."""
        return replace(self, height=liquid_height).solid_properties(mass)

    def volume(self, liquid_height: float) -> float:
        """Volume up to `liquid_height` (m), m^3."""
        return self.length * self.width * liquid_height

    def level(self, volume: float) -> float:
        """Liquid height in m for a volume in m^3."""
        return volume / (self.length * self.width)

    def solid_properties(self, mass: float) -> MassProperties:
        """Homogeneous solid block of `mass` kg."""
        squares = np.array((self.length, self.width, self.height)) ** 2
        return MassProperties(
            mass,
            read_only((0.0, 0.0, self.height / 2)),
            read_only(mass * np.diag(squares.sum() - squares) / 12),
        )

    def shell_properties(self, mass: float) -> MassProperties:
        """Thin empty box of `mass` kg: four walls and bottom of the same thickness, no lid."""
        sides = np.array((self.length, self.width, self.height))
        half = sides / 2
        # The plates: size in x, y, z (zero across the plate) and place of the centre from the middle of the box.
        plates = [
            (sides * (0, 1, 1), half * (sign, 0, 0)) for sign in (-1, 1)
        ] + [
            (sides * (1, 0, 1), half * (0, sign, 0)) for sign in (-1, 1)
        ] + [(sides * (1, 1, 0), half * (0, 0, -1))]  # fmt: skip
        areas = np.array([np.prod(size[size > 0]) for size, _ in plates])
        masses = mass * areas / areas.sum()
        places = np.array([place for _, place in plates])
        centre = (areas / areas.sum()) @ places
        squares = np.array([size**2 for size, _ in plates]) / 12 + (places - centre) ** 2
        return MassProperties(
            mass,
            read_only(centre + half * (0, 0, 1)),
            read_only(np.diag(masses @ (squares.sum(1)[:, None] - squares))),
        )

    def slosh_modes(self, liquid: Liquid, liquid_height: float, count: int, damping: float | None = None) -> SloshModes:
        """The first `count` modes along x and as many along y, x first [linear potential theory].

        Along a side a, with k_n = (2n - 1) pi/a and T = tanh(k_n h): m_n/m_F = 8 T a/(((2n - 1) pi)^3 h), and the
        height at the wall towards which the mass has moved is C_n = 4 T/((2n - 1) pi) times its displacement, positive
        for every n.

        All these masses are taken from one fixed mass; a mass that moves along x is carried along y like a rigid one.
        In a shallow box of two similar sides the fixed mass is therefore negative, which is right and harmless.

        Translation, pitch and roll excite only modes along one side; a turn about the vertical axis excites those that
        are odd along both (`yaw_modes`).

        Args:
            liquid: what is in it.
            liquid_height: h at rest, m.
            count: number of modes along each side.
            damping: ratio of the first mode along the longer side; default `boundary_layer_damping`. The other modes
                scale with their laminar damping.

        Raises:
            ScenarioError: nothing in the box, more than it holds, or a liquid too viscous to slosh.
        """
        check_filling(liquid, liquid_height, count, rim=self.height, damping=damping)
        sides = {"x": (self.length, self.width), "y": (self.width, self.length)}
        modes = [
            _mode(number, along=along, across=across, liquid_height=liquid_height, direction=direction)
            for number in range(1, count + 1)
            for direction, (along, across) in sides.items()
        ]
        mass = liquid.density * self.volume(liquid_height)
        frozen = FrozenLiquid(
            mass=mass,
            centre_height=liquid_height / 2,
            enclosed_inertia=mass
            * np.array([enclosed_liquid_inertia(side, liquid_height) for side in (self.width, self.length)]),
            quasi_static_gain=np.array((self.length, self.width)) / 2,
        )
        ratio = boundary_layer_damping(liquid, self, liquid_height) if damping is None else damping
        model = slosh_model(modes, frozen, liquid=liquid, liquid_height=liquid_height, damping=ratio)
        slowest = min(modes, key=lambda mode: mode.wave_number)
        yaw = yaw_modes(
            (self.length, self.width),
            liquid,
            liquid_height,
            count,
            inertia=mass * enclosed_liquid_inertia(self.length, self.width),
            damping_scale=ratio / slowest.laminar_damping(liquid, liquid_height),
            most_damping=max(ratio, LARGEST_DAMPING),
        )
        return replace(model, yaw=yaw)


def boundary_layer_damping(liquid: Liquid, box: Box, liquid_height: float) -> float:
    """Damping ratio of the first mode along the longer side a; b is the shorter one.

    Laminar Stokes layers of phi = cos(k x) cosh(k z), k = pi/a, on the four walls and the bottom give
    sqrt(nu/(2 omega)) [1/a + 1/b + k (1 - 2h/a)/sinh(2 k h)]; times the same factor by which the published formula for
    cylinders exceeds its own laminar value, since nothing measured is at hand for small boxes.
    A thick liquid has `thick_damping`.
    """
    along, across = max(box.length, box.width), min(box.length, box.width)
    mode = _mode(1, along=along, across=across, liquid_height=liquid_height, direction="x")
    return thick_damping(EMPIRICAL_DAMPING * mode.layer_damping(liquid, liquid_height), mode, liquid, liquid_height)


def enclosed_liquid_inertia(side: float, liquid_height: float) -> float:
    """Inertia over mass of ideal liquid filling a closed rectangle side x height, about the axis across it, m^2.

    Rigid rotation splits into the liquid's potential flow and the flow of the stress function of Saint-Venant torsion,
    orthogonal to it, so J = polar moment - torsion constant of the rectangle [Timoshenko and Goodier, sec. 109].
    """
    long, short = max(side, liquid_height), min(side, liquid_height)
    odd = np.arange(1, 2 * _TORSION_TERMS, 2)
    series = np.sum(np.tanh(odd * np.pi * long / (2 * short)) / odd**5)
    torsion = short**2 * (1 / 3 - 64 * short / (np.pi**5 * long) * series)
    return float((long**2 + short**2) / 12 - torsion)


def _mode(number: int, *, along: float, across: float, liquid_height: float, direction: str) -> PrismMode:
    half_waves = (2 * number - 1) * math.pi
    wave = half_waves / along
    depth = math.tanh(wave * liquid_height)
    end_walls_and_bottom = 2 / along + 2 * wave * (1 - 2 * liquid_height / along) * inverse_sinh_ratio(
        2 * wave * liquid_height
    )
    return PrismMode(
        wave_number=wave,
        mass_fraction=8 * depth * along / (half_waves**3 * liquid_height),
        surface_gain=4 * depth / half_waves,
        layer_ratio=2 / across + end_walls_and_bottom,
        directions=(direction,),
    )
