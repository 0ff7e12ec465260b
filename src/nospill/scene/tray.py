"""The tray: a rectangle fixed to the flange."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.robots.tool import Tool

TRAY_THICKNESS = 0.006
"""m; the board is taken and drawn this thick, below its upper surface."""


@dataclass(frozen=True, slots=True)
class Tray:
    """Tray frame: origin at the centre of its upper surface, z up out of the surface, x along the first side.

    Attributes:
        size: (2,) side lengths along x and y, m.
        tool: placement of the tray frame on the flange.
        mass: of the board itself, without its load, kg; spread evenly, at the height of the surface.
    """

    size: np.ndarray
    tool: Tool
    mass: float = 0.0
