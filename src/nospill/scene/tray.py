"""The tray: a rectangle fixed to the flange."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class Tray:
    """Tray frame: origin at the centre of its upper surface, z up out of the surface, x along the first side.

    Attributes:
        size: (2,) side lengths along x and y, m.
        offset: (3,) origin of the tray frame in the flange frame, m.
        yaw_on_flange: turn of the tray frame about the flange's z, rad.
        mass: of the board itself, without its load, kg; spread evenly, at the height of the surface.
    """

    size: np.ndarray
    offset: np.ndarray
    yaw_on_flange: float
    mass: float = 0.0
