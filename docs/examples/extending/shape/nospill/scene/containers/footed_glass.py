"""A cylindrical glass on a foot that is wider than its bowl."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.core.arrays import read_only
from nospill.errors import ScenarioError
from nospill.scene.containers.base import MassProperties
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.containers.footprints import DiscFootprint
from nospill.scene.liquids import Liquid
from nospill.scene.sloshing.modes import SloshModes
from nospill.scene.sloshing.prism import check_size


@dataclass(frozen=True, slots=True)
class FootedGlass:
    """Cylindrical glass on a thin, wider foot: the liquid sees the bowl, the tray sees the foot.

    Attributes:
        radius: inner radius of the bowl, m (thin wall).
        foot_radius: radius of the foot, at least that of the bowl, m.
        height: rim, or top of a solid, above the bottom, m.
    """

    radius: float
    foot_radius: float
    height: float

    def __post_init__(self) -> None:
        check_size(self.foot_radius, "foot_radius")
        if self.foot_radius < self.radius:
            raise ScenarioError(
                f"foot_radius {1e3 * self.foot_radius:g} mm is less than the bowl's radius {1e3 * self.radius:g} mm; "
                "give a wider foot"
            )

    @property
    def _bowl(self) -> Cylinder:
        return Cylinder(self.radius, self.height)

    @property
    def footprint(self) -> DiscFootprint:
        """The foot."""
        return DiscFootprint(self.foot_radius)

    @property
    def outline(self) -> np.ndarray:
        """64 points on the edge of the foot, shape (64, 2), m."""
        return Cylinder(self.foot_radius, self.height).outline

    @property
    def inside(self) -> np.ndarray:
        """Bottom and wall of the bowl, (3, 2)."""
        return read_only(self._bowl.inside * (self.radius / self.foot_radius, 1.0))

    @property
    def outside(self) -> np.ndarray:
        """The thin foot and the wall of the bowl, (3, 2)."""
        bowl = self._bowl.outside * (self.radius / self.foot_radius, 1.0)
        return read_only(np.vstack([(1.0, 0.0), bowl]))

    def section(self, liquid_height: float) -> DiscFootprint:
        """The bowl's, the same at every height."""
        return self._bowl.footprint

    def frozen(self, mass: float, liquid_height: float) -> MassProperties:
        """Those of the bowl."""
        return self._bowl.frozen(mass, liquid_height)

    def volume(self, liquid_height: float) -> float:
        """Volume in the bowl up to `liquid_height` (m), m^3."""
        return self._bowl.volume(liquid_height)

    def level(self, volume: float) -> float:
        """Liquid height in m for a volume in m^3."""
        return self._bowl.level(volume)

    def solid_properties(self, mass: float) -> MassProperties:
        """Homogeneous solid of the bowl's shape; the thin foot is left out."""
        return self._bowl.solid_properties(mass)

    def shell_properties(self, mass: float) -> MassProperties:
        """Thin empty glass of `mass` kg: wall and foot of the same thickness."""
        wall = mass * 2 * self.radius * self.height / (2 * self.radius * self.height + self.foot_radius**2)
        foot = mass - wall
        centre = wall * self.height / 2 / mass if mass else self.height / 2
        side = wall * (self.radius**2 / 2 + self.height**2 / 12 + (self.height / 2 - centre) ** 2)
        side += foot * (self.foot_radius**2 / 4 + centre**2)
        axis = wall * self.radius**2 + foot * self.foot_radius**2 / 2
        return MassProperties(mass, read_only((0.0, 0.0, centre)), read_only(np.diag((side, side, axis))))

    def slosh_modes(self, liquid: Liquid, liquid_height: float, count: int, damping: float | None = None) -> SloshModes:
        """Those of the bowl; raises the same."""
        return self._bowl.slosh_modes(liquid, liquid_height, count, damping)
