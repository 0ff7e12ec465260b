"""One thing that stands on the tray."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.containers.base import Container, MassProperties
from nospill.liquids import Liquid
from nospill.slosh.modes import SloshModes


@dataclass(frozen=True, slots=True)
class Filling:
    """The liquid in a container: which, how high at rest (m), and how far its surface may rise (m above rest)."""

    liquid: Liquid
    liquid_height: float
    max_slosh_height: float
    modes: SloshModes


@dataclass(frozen=True, slots=True)
class Cargo:
    """A named object on the tray, loose, standing on its bottom.

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

    @property
    def planned_friction(self) -> float:
        """Friction the plan may use: measured value less the reserve."""
        return self.friction * (1.0 - self.friction_reserve)
