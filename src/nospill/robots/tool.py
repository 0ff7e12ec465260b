"""The tool on the flange: the frame that an arm carries, here the tray."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from nospill.robots.description.urdf_tree import rotation_of

TOOL_NUMBERS = 12
"""Length of `Tool.row`."""


@dataclass(frozen=True, eq=False)
class Tool:
    """Placement of the tool frame in the flange frame; `Tool()` is the flange itself.

    R = Rz(yaw) Ry(pitch) Rx(roll), tool to flange axes: roll first, yaw last, about the flange's axes.

    Attributes:
        position: (3,) origin in flange axes, m.
        yaw: turn about the flange's z, rad.
        roll, pitch: turns about the flange's x and y before it, rad; zero where the tool's z is the flange's.
    """

    position: np.ndarray = field(default_factory=lambda: np.zeros(3))
    yaw: float = 0.0
    roll: float = 0.0
    pitch: float = 0.0

    @property
    def row(self) -> np.ndarray:
        """Position and rotation, row by row, in one array (12,), in which form the kinematics take a tool."""
        return np.concatenate([np.asarray(self.position, dtype=float), self.rotation.ravel()])

    @cached_property
    def rotation(self) -> np.ndarray:
        """Rotation (3, 3), tool to flange axes."""
        return rotation_of((self.roll, self.pitch, self.yaw))

    @property
    def upright(self) -> bool:
        """Whether the tool's z is the flange's."""
        return self.roll == self.pitch == 0.0


FLANGE = Tool()
"""The tool of a bare flange."""
