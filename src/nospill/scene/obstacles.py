"""What stands around the arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.core.shapes import Shape, point_distance
from nospill.robots.description.urdf_tree import rotation_of


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A convex solid that stands still; the frame is that of the path.

    Attributes:
        name: unique in its scenario.
        shape: its geometry, in its own frame.
        position: (3,) origin of that frame: the centre of a solid, a point on the surface of a half-space, m.
        rpy: (3,) roll, pitch and yaw of that frame, rad: roll first, yaw last, about the fixed axes.
        clearance: distance that arm, tray and cargo keep from it, m.
    """

    name: str
    shape: Shape
    position: np.ndarray
    rpy: np.ndarray
    clearance: float

    @property
    def rotation(self) -> np.ndarray:
        """(3, 3) from its own axes to those of the path."""
        return rotation_of(tuple(self.rpy.tolist()))

    def distance(self, point: np.ndarray) -> float:
        """Signed distance of a point (3,) of the path's frame from its surface, m; negative inside."""
        return point_distance(self.shape, self.rotation.T @ (np.asarray(point) - self.position))
