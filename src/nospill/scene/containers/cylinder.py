"""The upright circular cylinder."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from nospill.core.arrays import read_only
from nospill.scene.containers.base import MassProperties
from nospill.scene.containers.footprints import DiscFootprint
from nospill.scene.liquids import Liquid
from nospill.scene.sloshing.modes import STANDARD_GRAVITY, SloshModes
from nospill.scene.sloshing.prism import (
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

_OUTLINE_POINTS = 64
_INERTIA_TERMS = 200
_FIRST_ROOTS = (
    1.8411837813406595,
    5.3314427735250325,
    8.536316366346286,
    11.706004902592063,
    14.863588633909034,
    18.015527862681804,
    21.164369859188792,
    24.311326857210776,
    27.457050571059245,
    30.601922972669094,
)


@dataclass(frozen=True, slots=True)
class Cylinder:
    """Upright circular cylinder.

    Attributes:
        radius: inner radius of the cup and radius of its footprint, m (thin wall).
        height: rim, or top of a solid, above the bottom, m.
    """

    radius: float
    height: float

    def __post_init__(self) -> None:
        check_size(self.radius, "radius")
        check_size(self.height, "height")

    @property
    def footprint(self) -> DiscFootprint:
        """The whole bottom."""
        return DiscFootprint(self.radius)

    @property
    def outline(self) -> np.ndarray:
        """64 points on the rim of the bottom, shape (64, 2), m."""
        angle = 2 * np.pi * np.arange(_OUTLINE_POINTS) / _OUTLINE_POINTS
        return read_only(self.radius * np.column_stack((np.cos(angle), np.sin(angle))))

    @property
    def inside(self) -> np.ndarray:
        """Bottom and wall, (3, 2)."""
        return prism_inside(self.height)

    @property
    def outside(self) -> np.ndarray:
        """The wall, (2, 2)."""
        return prism_outside(self.height)

    def section(self, liquid_height: float) -> DiscFootprint:
        """The same at every height."""
        return self.footprint

    def frozen(self, mass: float, liquid_height: float) -> MassProperties:
        """A solid that is as high as the liquid."""
        return replace(self, height=liquid_height).solid_properties(mass)

    def volume(self, liquid_height: float) -> float:
        """Volume up to `liquid_height` (m), m^3."""
        return math.pi * self.radius**2 * liquid_height

    def level(self, volume: float) -> float:
        """Liquid height in m for a volume in m^3."""
        return volume / (math.pi * self.radius**2)

    def solid_properties(self, mass: float) -> MassProperties:
        """Homogeneous solid cylinder of `mass` kg."""
        side = self.radius**2 / 4 + self.height**2 / 12
        return MassProperties(
            mass,
            read_only((0.0, 0.0, self.height / 2)),
            read_only(mass * np.diag((side, side, self.radius**2 / 2))),
        )

    def shell_properties(self, mass: float) -> MassProperties:
        """Thin empty cup of `mass` kg: wall and bottom of the same thickness, no lid."""
        wall = mass * 2 * self.height / (2 * self.height + self.radius)
        bottom = mass - wall
        centre = wall * self.height / 2 / mass if mass else self.height / 2
        side = (
            wall * (self.radius**2 / 2 + self.height**2 / 12 + (self.height / 2 - centre) ** 2)
            + bottom * (self.radius**2 / 4 + centre**2)
        )  # fmt: skip
        return MassProperties(
            mass,
            read_only((0.0, 0.0, centre)),
            read_only(np.diag((side, side, wall * self.radius**2 + bottom * self.radius**2 / 2))),
        )

    def slosh_modes(self, liquid: Liquid, liquid_height: float, count: int, damping: float | None = None) -> SloshModes:
        """The first `count` modes with one nodal diameter, the only ones a motion of the cup excites linearly.

        With X = xi_n h/R [D3; Abramson, NASA SP-106, ch. 6]: m_n/m_F = 2R tanh X/(xi_n h (xi_n^2 - 1)) and
        C_n = 2 xi_n tanh X/(xi_n^2 - 1), the height at the wall per displacement.

        Args:
            liquid: what is in it.
            liquid_height: h at rest, m.
            count: number of modes.
            damping: ratio of the first mode; default `published_damping`, `thick_damping` of a thick liquid. Higher
                modes scale with their laminar damping.

        Raises:
            ScenarioError: nothing in the cup, more than it holds, or a liquid too viscous to slosh.
        """
        check_filling(liquid, liquid_height, count, rim=self.height, damping=damping)
        fill = liquid_height / self.radius
        mass = liquid.density * self.volume(liquid_height)
        modes = [self._mode(root, fill) for root in bessel_roots(count).tolist()]
        frozen = FrozenLiquid(
            mass=mass,
            centre_height=liquid_height / 2,
            enclosed_inertia=np.full(2, mass * enclosed_liquid_inertia(self.radius, liquid_height)),
            quasi_static_gain=np.full(2, self.radius),
        )
        ratio = damping
        if ratio is None:
            formula = published_damping(liquid, self.radius, liquid_height)
            ratio = thick_damping(formula, modes[0], liquid, liquid_height)
        return slosh_model(modes, frozen, liquid=liquid, liquid_height=liquid_height, damping=ratio)

    def _mode(self, root: float, fill: float) -> PrismMode:
        depth = math.tanh(root * fill)
        layers = (root**2 + 1) / (root**2 - 1) + 2 * root * (1 - fill) * inverse_sinh_ratio(2 * root * fill)
        return PrismMode(
            wave_number=root / self.radius,
            mass_fraction=2 * depth / (root * fill * (root**2 - 1)),
            surface_gain=2 * root * depth / (root**2 - 1),
            layer_ratio=layers / self.radius,
            directions=("x", "y"),
        )


@cache
def bessel_roots(count: int) -> np.ndarray:
    """The first `count` positive roots xi_n of J_1'(xi) = 0, shape (count,), to 1e-12; read-only.

    Tabulated up to the tenth, then McMahon's expansion [Abramowitz and Stegun, 9.5.13].
    """
    beyond = np.arange(len(_FIRST_ROOTS) + 1, count + 1)
    b = 8 * (beyond - 0.25) * np.pi
    later = b / 8 - 7 / b - 1724 / (3 * b**3) - 956_576 / (15 * b**5) - 1_573_778_752 / (105 * b**7)
    return read_only(np.concatenate((_FIRST_ROOTS[:count], later)))


def enclosed_liquid_inertia(radius: float, liquid_height: float) -> float:
    """Inertia over mass of ideal liquid filling a closed cylinder, about a horizontal axis through its centre, m^2.

    Turning about y, the potential is x z plus modes J_1(k r) sinh(k z) cos(theta) that correct top and bottom; summed
    with sum 1/(xi^2 (xi^2 - 1)) = 1/8: J/m = h^2/12 - 3 R^2/4 + (16/h) sum tanh(k_n h/2)/(k_n^3 (xi_n^2 - 1)), terms
    like n^-5. It is the Stokes-Joukowski inertia, 0.18 of the frozen liquid's for h = 1.4 R.
    """
    roots = bessel_roots(_INERTIA_TERMS)
    wave = roots / radius
    series = np.sum(np.tanh(wave * liquid_height / 2) / (wave**3 * (roots**2 - 1)))
    return float(liquid_height**2 / 12 - 0.75 * radius**2 + 16 / liquid_height * series)


def published_damping(liquid: Liquid, radius: float, liquid_height: float) -> float:
    """Damping ratio of the first mode, 0.92 S [1 + 0.318/sinh(1.84 h/R) (1 + (1 - h/R)/cosh(1.84 h/R))] [D3].

    S = sqrt(nu/sqrt(g R^3)). Other sources print 0.79 for 0.92; free decays of water in small cups (R = 35 to 49 mm)
    scatter from 0.004 to 0.019 about 0.006 to 0.010, so state a measured value where a residual matters.
    """
    fill = liquid_height / radius
    shallow = inverse_sinh_ratio(1.84 * fill)
    # 1/cosh from 1/sinh, which cannot overflow.
    inverse_cosh = shallow * math.tanh(1.84 * fill)
    thickness = math.sqrt(liquid.kinematic_viscosity / math.sqrt(STANDARD_GRAVITY * radius**3))
    return 0.92 * thickness * (1 + 0.318 * shallow * (1 + (1 - fill) * inverse_cosh))
