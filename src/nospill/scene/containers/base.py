"""What every container answers, whatever its shape.

Container frame: origin at the centre of the bottom, z along the axis towards the rim, x and y along the tray's axes
turned by the yaw of the container on the tray.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from nospill.scene.containers.footprints import Footprint
from nospill.scene.liquids import Liquid
from nospill.scene.sloshing.modes import SloshModes


@dataclass(frozen=True, slots=True)
class MassProperties:
    """Mass in kg, centre of mass (3,) in m in the container frame, inertia about it (3, 3) kg m^2, container axes."""

    mass: float
    centre: np.ndarray
    inertia: np.ndarray


class Container(Protocol):
    """A shape that stands on the tray, solid or with liquid inside; immutable, SI units."""

    @property
    def height(self) -> float:
        """Height of the rim (or of the solid's top) above the bottom, m."""
        ...

    @property
    def footprint(self) -> Footprint:
        """The surface that touches the tray."""
        ...

    @property
    def outline(self) -> np.ndarray:
        """Corners of the footprint's convex hull in the container frame, shape (n, 2), m; a disc gives 64 points."""
        ...

    @property
    def inside(self) -> np.ndarray:
        """Section of the inside by height, from the bottom to the rim, (n, 2): (part of the outline, height in m)."""
        ...

    @property
    def outside(self) -> np.ndarray:
        """The same of the outside, from the footprint at height 0 to the rim."""
        ...

    def section(self, liquid_height: float) -> Footprint:
        """Horizontal section of the inside at a height in m: where the free surface lies."""
        ...

    def frozen(self, mass: float, liquid_height: float) -> MassProperties:
        """Mass properties of liquid of `mass` kg at rest up to `liquid_height` m, as a solid."""
        ...

    def volume(self, liquid_height: float) -> float:
        """Volume of liquid up to `liquid_height` m above the bottom, m^3."""
        ...

    def level(self, volume: float) -> float:
        """Inverse of `volume`: the liquid height in m for a volume in m^3."""
        ...

    def solid_properties(self, mass: float) -> MassProperties:
        """Mass properties of a homogeneous solid of this outer shape."""
        ...

    def shell_properties(self, mass: float) -> MassProperties:
        """Mass properties of the empty container: a thin shell of uniform thickness, wall and bottom, no lid."""
        ...

    def slosh_modes(self, liquid: Liquid, liquid_height: float, count: int, damping: float | None = None) -> SloshModes:
        """The first `count` modes in each direction; `damping` sets the slowest mode's ratio, the others scale."""
        ...
