"""What every body of revolution answers, given the meridian of its inside and the base on which it stands."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from nospill.core.arrays import read_only
from nospill.core.units import format_quantity
from nospill.errors import ScenarioError
from nospill.scene.containers.base import MassProperties
from nospill.scene.containers.footprints import DiscFootprint
from nospill.scene.liquids import Liquid
from nospill.scene.meridian import Meridian
from nospill.scene.sloshing.modes import STANDARD_GRAVITY, SloshModes
from nospill.scene.sloshing.prism import (
    EMPIRICAL_DAMPING,
    FrozenLiquid,
    check_filling,
    check_size,
    slosh_model,
    thick_damping,
)

_OUTLINE_POINTS = 64
_STEM = 0.004
"""m; radius with which the stem of a vessel is drawn whose inside begins above its base."""
_FOOT = 0.004
"""m; height of the foot of such a vessel."""
_UNMOVED = 1e-6
"""Part of the liquid's mass below which a mode is not moved by a surge."""


@dataclass(frozen=True, slots=True)
class RevolvedMode:
    """One mode of a given vessel and level, as `slosh_model` wants it; see `RevolvedModes`.

    Attributes:
        curvature: omega_n^2/g, 1/m.
        wave_number: k_n, 1/m.
        mass_fraction: m_n/m_F.
        height: H_n above the bottom, m.
        surface_gain: height at the wall per displacement of the modal mass.
        layer_ratio: squared velocity over the wetted wall over that in the volume, 1/m.
        directions: horizontal directions it moves in.
    """

    curvature: float
    wave_number: float
    mass_fraction: float
    height: float
    surface_gain: float
    layer_ratio: float
    directions: tuple[str, ...] = ("x", "y")

    def frequency(self, liquid_height: float) -> float:
        """omega_n under standard gravity, rad/s; of the level it was computed for."""
        return math.sqrt(STANDARD_GRAVITY * self.curvature)

    def mass_height(self, liquid_height: float) -> float:
        """H_n, m; of the level it was computed for."""
        return self.height

    def layer_damping(self, liquid: Liquid, liquid_height: float) -> float:
        """Damping ratio by laminar Stokes layers on the wetted wall, as for a prism."""
        return math.sqrt(liquid.kinematic_viscosity / (2 * self.frequency(liquid_height))) * self.layer_ratio / 2

    def laminar_damping(self, liquid: Liquid, liquid_height: float) -> float:
        """Stokes layers and the interior, as for a prism."""
        interior = 2 * liquid.kinematic_viscosity * self.wave_number**2 / self.frequency(liquid_height)
        return self.layer_damping(liquid, liquid_height) + interior


@dataclass(frozen=True, kw_only=True, slots=True)
class Vessel(ABC):
    """An open body of revolution; subclasses say what its inside looks like.

    Attributes:
        height: of the rim above the tray, m.
        wall: thickness of the wall, m, by which the outside is wider than the inside; the masses of the empty vessel
            follow from `empty_mass`.
        base_radius: outer radius of the surface on which it stands, m; None for that of a flat bottom and the wall.
        base_inner_radius: inner radius of that surface where it is a ring, m.
    """

    height: float
    wall: float = 0.0
    base_radius: float | None = None
    base_inner_radius: float = 0.0

    @property
    @abstractmethod
    def meridian(self) -> Meridian:
        """Of the inside, from the bottom's centre to the rim."""

    @property
    def footprint(self) -> DiscFootprint:
        """The base: a disc or a ring."""
        radius = self.base_radius or _flat_bottom(self.meridian) + self.wall
        return DiscFootprint(radius, self.base_inner_radius)

    @property
    def outline(self) -> np.ndarray:
        """64 points on the edge of the base, shape (64, 2), m."""
        angle = 2 * np.pi * np.arange(_OUTLINE_POINTS) / _OUTLINE_POINTS
        return read_only(self.footprint.radius * np.column_stack((np.cos(angle), np.sin(angle))))

    @property
    def inside(self) -> np.ndarray:
        """The meridian, (n, 2): (radius over that of the base, height in m)."""
        return read_only(self.meridian.points / (self.footprint.radius, 1.0))

    @property
    def outside(self) -> np.ndarray:
        """The base, a foot and a stem where the inside begins above them, and the wall, (n, 2) as `inside`."""
        base, points = self.footprint.radius, self.meridian.points + np.array((self.wall, 0.0))
        bottom = self.meridian.bottom
        if bottom > 2 * _FOOT:
            stem = min(_STEM, base)
            foot = [(base, 0.0), (base, _FOOT), (stem, _FOOT), (stem, bottom)]
            points = points[points[:, 0] > stem]
        else:
            foot = [(base, 0.0)]
            points = points[points[:, 1] > bottom]
        return read_only(np.vstack([foot, points]) / (base, 1.0))

    def section(self, liquid_height: float) -> DiscFootprint:
        """The free surface of a liquid at a height in m."""
        return DiscFootprint(self.meridian.radius(liquid_height))

    def volume(self, liquid_height: float) -> float:
        """Volume up to `liquid_height` (m), m^3."""
        return self.meridian.volume(liquid_height)

    def level(self, volume: float) -> float:
        """Liquid height in m for a volume in m^3; the rim's where it does not hold so much."""
        return self.meridian.level(volume)

    def frozen(self, mass: float, liquid_height: float) -> MassProperties:
        """Liquid of `mass` kg up to a height in m, as a solid."""
        return _properties(mass, *self.meridian.body(liquid_height)[1:])

    def solid_properties(self, mass: float) -> MassProperties:
        """Homogeneous solid of `mass` kg that fills the inside to the rim."""
        return self.frozen(mass, self.height)

    def shell_properties(self, mass: float) -> MassProperties:
        """Thin empty vessel of `mass` kg, of the same thickness everywhere; stem and foot are not counted."""
        return _properties(mass, *self.meridian.shell())

    def slosh_modes(self, liquid: Liquid, liquid_height: float, count: int, damping: float | None = None) -> SloshModes:
        """The first `count` modes with one nodal diameter, by finite elements [docs/physics/vessels.md].

        Args:
            liquid: what is in it.
            liquid_height: h at rest above the bottom, m.
            count: number of modes.
            damping: ratio of the first mode; default the laminar boundary layers' times `EMPIRICAL_DAMPING`, as for a
                box. The other modes scale with their laminar damping.

        Raises:
            ScenarioError: nothing in it, more than it holds, or a liquid too viscous to slosh.
            ModelError: its inside is too intricate.
        """
        check_filling(liquid, liquid_height, count, rim=self.height, damping=damping)
        if liquid_height <= self.meridian.bottom:
            raise ScenarioError(
                f"liquid_height {format_quantity(liquid_height, 'length', digits=4)} is not above the inside's bottom "
                f"(height {format_quantity(self.meridian.bottom, 'length', digits=4)}): heights count from the tray"
            )
        # Only a vessel with liquid needs the solver, and SciPy with it.
        from nospill.scene.sloshing.revolved_modes import revolved_modes

        solved = revolved_modes(self.meridian, liquid_height, count)
        volume, centre, _ = self.meridian.body(liquid_height)
        fractions = solved.volume[:count] / volume
        # A mode that no surge moves has no place for its mass.
        heights = np.where(fractions > _UNMOVED, solved.height[:count], liquid_height)
        modes = [
            RevolvedMode(*numbers)
            for numbers in zip(
                solved.curvature[:count].tolist(),
                solved.wave_number[:count].tolist(),
                fractions.tolist(),
                heights.tolist(),
                solved.surface_gain[:count].tolist(),
                solved.layer_ratio[:count].tolist(),
                strict=True,
            )
        ]
        mass = liquid.density * volume
        frozen = FrozenLiquid(
            mass=mass,
            centre_height=centre,
            enclosed_inertia=np.full(2, liquid.density * solved.inertia - mass * (liquid_height - centre) ** 2),
            quasi_static_gain=np.full(2, self.meridian.radius(liquid_height)),
        )
        layers = modes[0].layer_damping(liquid, liquid_height)
        ratio = damping
        if ratio is None:
            ratio = thick_damping(EMPIRICAL_DAMPING * layers, modes[0], liquid, liquid_height)
        return slosh_model(modes, frozen, liquid=liquid, liquid_height=liquid_height, damping=ratio)


def check_base(vessel: Vessel) -> None:
    """Refuse a wall or a base that cannot be.

    Raises:
        ScenarioError: naming the key.
    """
    if not 0.0 <= vessel.wall < math.inf:
        raise ScenarioError(f"wall = {vessel.wall:g} m: a thickness of 0 or more is needed")
    if vessel.base_radius is None and not _flat_bottom(vessel.meridian):
        raise ScenarioError(
            "base_radius is missing: the inside has no flat bottom at the tray; give the radius on which it stands, "
            'for example base_radius = "30 mm"'
        )
    if vessel.base_radius is not None:
        check_size(vessel.base_radius, "base_radius")
    if not 0.0 <= vessel.base_inner_radius < vessel.footprint.radius:
        shown, outer = (
            format_quantity(length, "length", digits=4)
            for length in (vessel.base_inner_radius, vessel.footprint.radius)
        )
        raise ScenarioError(f"base_inner_radius {shown} is not inside the base (radius {outer}); give a smaller one")


def _flat_bottom(meridian: Meridian) -> float:
    """Radius of the flat part of the inside's bottom, m; 0 where it is pointed or round."""
    points = meridian.points
    flat = points[np.abs(points[:, 1] - points[0, 1]) < 1e-9]
    return float(np.max(flat[:, 0]))


def _properties(mass: float, centre: float, inertia: np.ndarray) -> MassProperties:
    return MassProperties(mass, read_only((0.0, 0.0, centre)), read_only(mass * inertia))
