"""The tool on the flange: the frame that an arm carries, here the tray."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True, slots=True, eq=False)
class Tool:
    """Placement of the tool frame in the flange frame; `Tool()` is the flange itself.

    Attributes:
        position: (3,) origin in flange axes, m.
        yaw: turn about the flange's z, rad.
    """

    position: np.ndarray = field(default_factory=lambda: np.zeros(3))
    yaw: float = 0.0

    @property
    def row(self) -> np.ndarray:
        """Position and yaw in one array (4,), the form in which expressions of the kinematics take a tool."""
        return np.array([*self.position, self.yaw], dtype=float)

    @property
    def rotation(self) -> np.ndarray:
        """Rotation (3, 3), tool to flange axes."""
        cosine, sine = np.cos(self.yaw), np.sin(self.yaw)
        return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


FLANGE = Tool()
"""The tool of a bare flange."""
