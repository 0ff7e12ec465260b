"""Vessels by name, each with few sizes, and the vessel of any profile."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from nospill.core.units import format_quantity
from nospill.errors import ScenarioError
from nospill.scene.containers.vessel import Vessel, check_base
from nospill.scene.meridian import Meridian, arc, check_meridian, polyline, smooth_pieces
from nospill.scene.sloshing.prism import check_size

_WIDEST_AT = 0.45
"""Part of its bowl's height at which a wine glass is widest."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Profile(Vessel):
    """Vessel of any profile.

    Attributes:
        profile: points (r, z) of the inside from the bottom's centre to the rim, m.
        height: that of the last point, m.
        profile_spline: whether a smooth curve joins the points; a point given twice in a row stays a corner.
    """

    profile: tuple[tuple[float, float], ...]
    profile_spline: bool = False
    height: float = field(init=False, default=0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "height", self.profile[-1][1])
        for number, (before, point) in enumerate(zip(self.profile[:-1], self.profile[1:], strict=True), start=2):
            if before == point and not self.profile_spline:
                raise ScenarioError(f"profile entry {number} repeats the one before; leave it out")
        if len(self.meridian.pieces) == 0:
            raise ScenarioError("profile has no length: two different points are needed at least")
        check_meridian(self.meridian)
        check_base(self)

    @property
    def meridian(self) -> Meridian:
        """Lines or smooth curves through the points."""
        return Meridian(smooth_pieces(self.profile) if self.profile_spline else polyline(self.profile))


@dataclass(frozen=True, kw_only=True, slots=True)
class Tapered(Vessel):
    """Cup with a flat bottom and a straight wall.

    Attributes:
        bottom_radius: of the inside at the bottom, m.
        top_radius: of the inside at the rim, m.
        height: of the rim above the bottom, m.
    """

    bottom_radius: float
    top_radius: float

    def __post_init__(self) -> None:
        for name in ("bottom_radius", "top_radius", "height"):
            check_size(getattr(self, name), name)
        check_base(self)

    @property
    def meridian(self) -> Meridian:
        """Bottom and wall."""
        return Meridian(polyline(((0.0, 0.0), (self.bottom_radius, 0.0), (self.top_radius, self.height))))


@dataclass(frozen=True, kw_only=True, slots=True)
class Bowl(Vessel):
    """Part of a sphere on a flat bottom.

    Attributes:
        radius: of the inside at the rim, m.
        bottom_radius: of the flat bottom, less than that of the rim, m.
        height: of the rim above the bottom, m.
    """

    radius: float
    bottom_radius: float

    def __post_init__(self) -> None:
        for name in ("radius", "bottom_radius", "height"):
            check_size(getattr(self, name), name)
        _check_order(self.bottom_radius, "bottom_radius", self.radius, "radius")
        check_base(self)

    @property
    def meridian(self) -> Meridian:
        """Bottom and arc."""
        middle = (self.radius**2 - self.bottom_radius**2 + self.height**2) / (2 * self.height)
        sphere = math.hypot(self.bottom_radius, middle)
        first = -math.atan2(middle, self.bottom_radius)
        last = math.atan2(self.height - middle, self.radius)
        wall = arc((0.0, middle), (sphere, sphere), (first, last))
        return _on_flat_bottom(self.bottom_radius, 0.0, wall[1:-1], (self.radius, self.height))


@dataclass(frozen=True, kw_only=True, slots=True)
class WineGlass(Vessel):
    """Egg-shaped bowl on a stem; `base_radius` is that of its foot.

    Attributes:
        radius: of the inside where it is widest, m.
        rim_radius: at the rim, at most that, m.
        bowl_height: of the rim above the lowest point of the inside, m.
        height: of the rim above the tray, m.
    """

    radius: float
    rim_radius: float
    bowl_height: float

    def __post_init__(self) -> None:
        for name in ("radius", "rim_radius", "bowl_height", "height"):
            check_size(getattr(self, name), name)
        _check_order(self.rim_radius, "rim_radius", self.radius, "radius", equal=True)
        _check_order(self.bowl_height, "bowl_height", self.height, "height", equal=True)
        check_base(self)

    @property
    def meridian(self) -> Meridian:
        """A quarter of an ellipse up to the widest place, part of another one above it."""
        lower = _WIDEST_AT * self.bowl_height
        middle = self.height - self.bowl_height + lower
        last = math.acos(self.rim_radius / self.radius)
        bowl = arc((0.0, middle), (self.radius, lower), (-math.pi / 2, 0.0))
        if last == 0.0:
            return Meridian((bowl, (bowl[-1], (self.radius, self.height))))
        above = arc((0.0, middle), (self.radius, (self.bowl_height - lower) / math.sin(last)), (0.0, last))
        return Meridian((bowl, (bowl[-1], *above[1:-1], (self.rim_radius, self.height))))


@dataclass(frozen=True, kw_only=True, slots=True)
class ConicalFlask(Vessel):
    """Flat bottom, straight wall towards a cylindrical neck.

    Attributes:
        bottom_radius: of the inside at the bottom, m.
        neck_radius: of the inside of the neck, less than that of the bottom, m.
        shoulder_height: at which the neck begins, m.
        height: of the rim above the bottom, m.
    """

    bottom_radius: float
    neck_radius: float
    shoulder_height: float

    def __post_init__(self) -> None:
        for name in ("bottom_radius", "neck_radius", "shoulder_height", "height"):
            check_size(getattr(self, name), name)
        _check_order(self.neck_radius, "neck_radius", self.bottom_radius, "bottom_radius")
        _check_order(self.shoulder_height, "shoulder_height", self.height, "height")
        check_base(self)

    @property
    def meridian(self) -> Meridian:
        """Bottom, wall and neck."""
        bottom, shoulder = (self.bottom_radius, 0.0), (self.neck_radius, self.shoulder_height)
        return Meridian(polyline(((0.0, 0.0), bottom, shoulder, (self.neck_radius, self.height))))


@dataclass(frozen=True, kw_only=True, slots=True)
class RoundFlask(Vessel):
    """Ball on a flat bottom, with a cylindrical neck.

    Attributes:
        radius: of the inside of the ball, m.
        bottom_radius: of its flat bottom, less than that, m.
        neck_radius: of the inside of the neck, less than that of the ball, m.
        height: of the rim above the bottom, m.
    """

    radius: float
    bottom_radius: float
    neck_radius: float

    def __post_init__(self) -> None:
        for name in ("radius", "bottom_radius", "neck_radius", "height"):
            check_size(getattr(self, name), name)
        _check_order(self.bottom_radius, "bottom_radius", self.radius, "radius")
        _check_order(self.neck_radius, "neck_radius", self.radius, "radius")
        _check_order(self._shoulder, "the ball's top", self.height, "height")
        check_base(self)

    @property
    def _middle(self) -> float:
        return math.sqrt(self.radius**2 - self.bottom_radius**2)

    @property
    def _shoulder(self) -> float:
        return self._middle + math.sqrt(self.radius**2 - self.neck_radius**2)

    @property
    def meridian(self) -> Meridian:
        """Bottom, ball and neck."""
        first, last = -math.acos(self.bottom_radius / self.radius), math.acos(self.neck_radius / self.radius)
        ball = arc((0.0, self._middle), (self.radius, self.radius), (first, last), 65)
        shoulder = (self.neck_radius, self._shoulder)
        below = _on_flat_bottom(self.bottom_radius, 0.0, ball[1:-1], shoulder)
        return Meridian((*below.pieces, (shoulder, (self.neck_radius, self.height))))


@dataclass(frozen=True, kw_only=True, slots=True)
class TestTube(Vessel):
    """Tube with a hemispherical bottom; `base_radius` is that of the holder in which it stands.

    Attributes:
        radius: of the inside, m.
        height: of the rim above the lowest point of the inside, m.
    """

    __test__ = False

    radius: float

    def __post_init__(self) -> None:
        for name in ("radius", "height"):
            check_size(getattr(self, name), name)
        _check_order(self.radius, "radius", self.height, "height")
        check_base(self)

    @property
    def meridian(self) -> Meridian:
        """Quarter of a circle and wall."""
        bottom = arc((0.0, self.radius), (self.radius, self.radius), (-math.pi / 2, 0.0))
        return Meridian((bottom, (bottom[-1], (self.radius, self.height))))


def _on_flat_bottom(
    radius: float, height: float, wall: tuple[tuple[float, float], ...], end: tuple[float, float]
) -> Meridian:
    corner = (radius, height)
    return Meridian((((0.0, height), corner), (corner, *wall, end)))


def _check_order(smaller: float, smaller_name: str, larger: float, larger_name: str, *, equal: bool = False) -> None:
    """Refuse a size that is not below another.

    Raises:
        ScenarioError: naming both.
    """
    if smaller > larger or (smaller == larger and not equal):
        low, high = (format_quantity(length, "length", digits=4) for length in (smaller, larger))
        relation = "at most" if equal else "below"
        raise ScenarioError(f"{smaller_name} {low} must be {relation} {larger_name} {high}")
