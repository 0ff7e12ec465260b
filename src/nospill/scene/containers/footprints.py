"""Footprints: the surface with which an object touches the tray, as far as contact, layout and liquid depend on it.

Symbols: a footprint frame has its origin in the middle, half lengths (a, b) along its x and y. The static methods take
numbers or CasADi expressions, whose half lengths may differ from those of any object at hand.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from nospill.core.arrays import read_only


class Footprint(Protocol):
    """What every footprint answers; a new kind is a class like those below."""

    @property
    def half_lengths(self) -> np.ndarray:
        """Reach along x and y from the middle, (2,), m."""
        ...

    @property
    def core(self) -> np.ndarray:
        """Corners (n, 2), m, of the convex polygon whose points, widened by `rounding`, are the footprint."""
        ...

    @property
    def rounding(self) -> float:
        """Radius by which `core` is widened, m."""
        ...

    @property
    def twist_radius(self) -> float:
        """Mean distance of the points from the middle, m: friction moment per mu N under uniform pressure."""
        ...

    @property
    def grip_radius(self) -> float:
        """Radius of gyration about the weaker principal axis, m.

        Under uniform pressure and slip about a far centre at distance c, friction loses r^2/(2 c^2) of its force and
        gains a moment r^2/c per unit, so the ellipsoid |f|^2 + (M/r)^2 with this r touches the limit curve there from
        inside and stays inside everywhere.
        """
        ...

    @property
    def sides(self) -> tuple[float, ...]:
        """Lengths that state it, m: the diameter, or both sides."""
        ...

    def gap(self, point: np.ndarray) -> float:
        """Distance of `point` (2,), m, outside the footprint, m; negative inside."""
        ...

    def mode_shape(self, wave_number: float, points: np.ndarray, axis: int) -> np.ndarray:
        """Height (u,) of a slosh mode under a wall over the edge, 1 at the wall on the axis' positive side.

        Args:
            wave_number: of the mode, 1/m.
            points: in the footprint frame, m.
            axis: 0 for a mode along x, 1 along y.
        """
        ...

    @staticmethod
    def bounds(offset: Any, half: Any) -> tuple[tuple[Any, Any], ...]:
        """Pairs of vector and bound: `offset` (2) is inside half lengths `half` (2) where no norm exceeds its bound."""
        ...

    @staticmethod
    def eccentricity(offset: Any, half: Any, least: Any) -> Any:
        """Distance of `offset` (2) from the middle as a part of the footprint, never less than `least`, smooth."""
        ...

    @staticmethod
    def crest_vectors(height: Any) -> tuple[Any, ...]:
        """Vectors whose norms bound the height round a wall over the edge, from the heights (2) along x and y."""
        ...


@dataclass(frozen=True, slots=True)
class DiscFootprint:
    """A disc, or the ring on which a vessel with a foot ring stands.

    Attributes:
        radius: m.
        hole: inner radius of a ring, m; 0 for a full disc.
    """

    radius: float
    hole: float = 0.0

    @property
    def half_lengths(self) -> np.ndarray:
        """The radius, twice."""
        return read_only((self.radius, self.radius))

    @property
    def core(self) -> np.ndarray:
        """The middle alone, (1, 2)."""
        return read_only(np.zeros((1, 2)))

    @property
    def rounding(self) -> float:
        """The radius."""
        return self.radius

    @property
    def twist_radius(self) -> float:
        """2R/3; of a ring 2 (R^3 - r^3)/(3 (R^2 - r^2))."""
        if not self.hole:
            return 2.0 / 3.0 * self.radius
        return 2.0 / 3.0 * (self.radius**3 - self.hole**3) / (self.radius**2 - self.hole**2)

    @property
    def grip_radius(self) -> float:
        """R/2; of a ring sqrt(R^2 + r^2)/2."""
        return math.hypot(self.radius, self.hole) / 2.0

    @property
    def sides(self) -> tuple[float, ...]:
        """The diameter."""
        return (2.0 * self.radius,)

    def gap(self, point: np.ndarray) -> float:
        """Distance from the middle less the radius, m."""
        return math.hypot(*point) - self.radius

    def mode_shape(self, wave_number: float, points: np.ndarray, axis: int) -> np.ndarray:
        """J_1(k r)/J_1(k R) times the cosine of the angle from the axis."""
        from scipy.special import j1

        distance = np.hypot(*points.T)
        along = np.divide(points[:, axis], distance, out=np.zeros(len(points)), where=distance > 0)
        return j1(wave_number * distance) / j1(wave_number * self.radius) * along

    @staticmethod
    def bounds(offset: Any, half: Any) -> tuple[tuple[Any, Any], ...]:
        """One: the radius for the vector itself."""
        return ((offset, half[0]),)

    @staticmethod
    def eccentricity(offset: Any, half: Any, least: Any) -> Any:
        """Distance over the radius, rounded off at the middle."""
        return (offset[0] ** 2 + offset[1] ** 2 + (least * half[0]) ** 2) ** 0.5 / half[0]

    @staticmethod
    def crest_vectors(height: Any) -> tuple[Any, ...]:
        """The vector itself: the crest of a circular wall is where it points."""
        return (height,)


@dataclass(frozen=True, slots=True)
class RectangleFootprint:
    """A full rectangle.

    Attributes:
        half_x: half length along its x, m.
        half_y: half length along its y, m.
    """

    half_x: float
    half_y: float

    @property
    def half_lengths(self) -> np.ndarray:
        """Half of both sides."""
        return read_only((self.half_x, self.half_y))

    @property
    def core(self) -> np.ndarray:
        """The four corners, counter-clockwise, (4, 2)."""
        return read_only(np.array(((-1, -1), (1, -1), (1, 1), (-1, 1))) * (self.half_x, self.half_y))

    @property
    def rounding(self) -> float:
        """None: 0."""
        return 0.0

    @property
    def twist_radius(self) -> float:
        """(d + a^2/(2b) log((b + d)/a) + b^2/(2a) log((a + d)/b)) / 3 with d = sqrt(a^2 + b^2)."""
        a, b = self.half_x, self.half_y
        d = math.hypot(a, b)
        return (d + a * a / (2 * b) * math.log((b + d) / a) + b * b / (2 * a) * math.log((a + d) / b)) / 3.0

    @property
    def grip_radius(self) -> float:
        """Half the short side over sqrt(3)."""
        return min(self.half_x, self.half_y) / math.sqrt(3.0)

    @property
    def sides(self) -> tuple[float, ...]:
        """Both sides."""
        return 2.0 * self.half_x, 2.0 * self.half_y

    def gap(self, point: np.ndarray) -> float:
        """Distance beyond the farther of the two pairs of sides, m."""
        return max(abs(float(point[0])) - self.half_x, abs(float(point[1])) - self.half_y)

    def mode_shape(self, wave_number: float, points: np.ndarray, axis: int) -> np.ndarray:
        """sin(k x)/sin(k a) along the axis."""
        half = (self.half_x, self.half_y)[axis]
        return np.sin(wave_number * points[:, axis]) / np.sin(wave_number * half)

    @staticmethod
    def bounds(offset: Any, half: Any) -> tuple[tuple[Any, Any], ...]:
        """One band for each pair of sides."""
        return (offset[0], half[0]), (offset[1], half[1])

    @staticmethod
    def eccentricity(offset: Any, half: Any, least: Any) -> Any:
        """Norm of order four of the parts of both half lengths: smooth, at least the larger and near it."""
        return (((offset[0] / half[0]) ** 4 + (offset[1] / half[1]) ** 4 + least**4) ** 0.5) ** 0.5

    @staticmethod
    def crest_vectors(height: Any) -> tuple[Any, ...]:
        """The heights in the corners of both diagonals."""
        return height[0] + height[1], height[0] - height[1]
