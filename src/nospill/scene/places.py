"""Places on the way of a tray: some that it passes, and boxes that it stays in."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nospill.core.arrays import read_only
from nospill.core.shapes import halfspace_shape
from nospill.robots.description.urdf_tree import about_axis
from nospill.scene.obstacles import Obstacle

_SIDES = {(0, 1.0): "+x", (0, -1.0): "-x", (1, 1.0): "+y", (1, -1.0): "-y", (2, 1.0): "top", (2, -1.0): "bottom"}
"""Axis of a box and direction -> what the side there is called."""


@dataclass(frozen=True, slots=True)
class Via:
    """A place that the tray's centre passes; the frame is that of the path.

    Attributes:
        name: unique in its scenario.
        position: m.
        radius: how near it has to come, m.
        parameter: s of the path's own nearest point, 0 to 1.
    """

    name: str
    position: tuple[float, float, float]
    radius: float
    parameter: float


@dataclass(frozen=True, slots=True)
class Region:
    """A box that tray and cargo stay in; the frame is that of the path.

    Attributes:
        name: unique in its scenario.
        position: its centre, m.
        size: side lengths along its own x, y and z, m.
        yaw: its turn about z, rad.
    """

    name: str
    position: tuple[float, float, float]
    size: tuple[float, float, float]
    yaw: float

    @property
    def sides(self) -> tuple[Obstacle, ...]:
        """The six half-spaces outside, named as "region top"."""
        return tuple(self._side(axis, sign) for axis in range(3) for sign in (1.0, -1.0))

    def slack(self, point: np.ndarray) -> float:
        """Distance of a point (3,) from the nearest side, m; negative outside."""
        inside = about_axis((0.0, 0.0, 1.0), self.yaw).T @ (np.asarray(point) - self.position)
        return float(np.min(np.array(self.size) / 2.0 - np.abs(inside)))

    def _side(self, axis: int, sign: float) -> Obstacle:
        """The half-space beyond a side; its z axis points into the region."""
        normal = np.zeros(3)
        normal[axis] = sign * self.size[axis] / 2.0
        position = self.position + about_axis((0.0, 0.0, 1.0), self.yaw) @ normal
        turn = self.yaw + (math.pi / 2.0 if axis == 1 else 0.0)
        # pitch turns z to (sin, 0, cos), yaw turns that x to the axis of the side
        pitch = -sign * math.pi / 2.0 if axis < 2 else (math.pi if sign > 0.0 else 0.0)
        name = f"{self.name} {_SIDES[axis, sign]}"
        return Obstacle(name, halfspace_shape(), read_only(position), read_only([0.0, pitch, turn]), 0.0)
