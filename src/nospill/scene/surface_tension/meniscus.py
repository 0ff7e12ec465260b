"""Surface at rest of a liquid in a small vessel: higher at a wall that it wets than on the axis.

With c^2 = sigma/(rho g) the surface at the height u over the level of no pressure difference and with the slope angle
psi obeys d(r sin psi)/dr = r u/c^2 [Young, Laplace], integrated here over psi from a nearly flat start on, where
u = u_0 I_0(r/c), to the slope at the wall, which the contact angle gives. The weight of what is lifted hangs on the
wall, so the mean of u is 2 c^2 sin(psi)/R: the heights below count from the flat surface of the same volume. On a wall
that leans the surface is that of an upright wall of its radius at the level, with the slope that the angle gives there.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from nospill.core.arrays import read_only
from nospill.scene.containers.base import Container
from nospill.scene.containers.footprints import DiscFootprint
from nospill.scene.containers.vessel import Vessel
from nospill.scene.liquids import Liquid
from nospill.scene.sloshing.modes import STANDARD_GRAVITY

WETTED = 0.0
"""rad; contact angle of a wall that is wholly wet: the highest meniscus of all."""

_FLAT = 1e-3
"""rad; slope up to which the surface is the linear one, or a tenth of that at the wall where this is less."""
_LEAST = 1e-6
"""m; of a capillary length: less is no surface tension. rad: of a slope at the wall, less is a flat surface."""
_STEEP = 0.9
"""Largest product of the slopes of surface and wall, both per upright way: beyond it the one lies along the other, or
overhangs."""
_POINTS = 200


class Meniscus(NamedTuple):
    """The surface at rest against the flat one of the same volume.

    Attributes:
        rise: how much higher it stands at the wall, m; negative where the liquid does not wet it.
        drop: how much lower on the axis, m; likewise.
    """

    rise: float
    drop: float


class RestSurface(NamedTuple):
    """A surface at rest from the axis to the wall.

    Attributes:
        radius: (n,) m.
        height: (n,) above the flat surface of the same volume, m.
    """

    radius: np.ndarray
    height: np.ndarray

    @property
    def meniscus(self) -> Meniscus:
        """Its ends."""
        return Meniscus(float(self.height[-1]), -float(self.height[0]))


def capillary_length(liquid: Liquid) -> float:
    """sqrt(sigma/(rho g)), m; 0 without surface tension."""
    length = math.sqrt(liquid.surface_tension / (liquid.density * STANDARD_GRAVITY))
    return 0.0 if length < _LEAST else length


def meniscus(liquid: Liquid, radius: float, contact_angle: float = WETTED) -> Meniscus:
    """The meniscus between upright walls.

    Args:
        liquid: what is in it.
        radius: of the surface, m.
        contact_angle: between wall and surface, measured in the liquid, rad.
    """
    return rest_surface(capillary_length(liquid), radius, math.pi / 2 - contact_angle).meniscus


def meniscus_in(container: Container, liquid: Liquid, level: float, contact_angle: float | None = None) -> Meniscus:
    """The meniscus at a level (m), without an angle that of a wetted wall; in a box that at one plane wall, higher."""
    angle = WETTED if contact_angle is None else contact_angle
    section = container.section(level)
    if not isinstance(section, DiscFootprint):
        return Meniscus(plane_wall_rise(liquid, angle), 0.0)
    lean = container.meridian.lean(level) if isinstance(container, Vessel) else 0.0
    return rest_surface(capillary_length(liquid), section.radius, slope_at_wall(lean, angle)).meniscus


def plane_wall_rise(liquid: Liquid, contact_angle: float = WETTED) -> float:
    """How much higher a liquid stands at an upright plane wall than far from it, m [Landau, Lifshitz, sec. 61]."""
    rise = capillary_length(liquid) * math.sqrt(2.0 * (1.0 - math.sin(contact_angle)))
    return math.copysign(rise, math.pi / 2 - contact_angle)


def slope_at_wall(lean: float, contact_angle: float) -> float:
    """Slope angle of the surface at the wall, rad, upwards from the axis.

    Args:
        lean: of the wall from upright, rad, positive where it opens.
        contact_angle: rad; a surface that would overhang, or lie along the wall, stops short of that.
    """
    slope = math.pi / 2 - lean - contact_angle
    most = math.atan(_STEEP / abs(math.tan(lean))) if lean else math.pi / 2
    return min(max(slope, -most), most)


def rest_surface(length: float, radius: float, slope: float) -> RestSurface:
    """The surface with a slope at the wall.

    Args:
        length: capillary length, m; 0 without surface tension.
        radius: of the wall, m.
        slope: slope angle at the wall, rad, within pi/2.
    """
    if length == 0.0 or abs(slope) < _LEAST:
        return RestSurface(read_only((0.0, radius)), read_only((0.0, 0.0)))
    return _rest_surface(length, radius, slope)


@lru_cache(maxsize=256)
def _rest_surface(length: float, radius: float, slope: float) -> RestSurface:
    from scipy.integrate import solve_ivp  # slow to load, and few scenarios have small vessels
    from scipy.optimize import brentq
    from scipy.special import ive

    wanted, end = radius / length, abs(slope)
    flat = min(_FLAT, end / 10)

    def slopes(psi: float, place: tuple[float, float]) -> tuple[float, float]:
        r, u = place
        turn = u - math.sin(psi) / r
        return math.cos(psi) / turn, math.sin(psi) / turn

    def towards_wall(start: float, at: np.ndarray | None = None) -> np.ndarray:
        """Radii and heights (2, n), capillary lengths, of the surface that is flat up to a radius."""
        height = flat * float(ive(0, start) / ive(1, start))
        return solve_ivp(slopes, (flat, end), (start, height), t_eval=at, rtol=1e-8, atol=1e-12).y

    # A small surface is part of a sphere, r sin(end) = R sin(psi); a large one is flat but for a rim.
    start = float(brentq(lambda value: towards_wall(value)[0, -1] - wanted, 0.1 * flat * wanted, wanted, rtol=1e-10))  # type: ignore[arg-type]
    inner = np.linspace(0.0, start, _POINTS // 4, endpoint=False)
    level = flat * np.exp(inner - start) * ive(0, inner) / ive(1, start)
    outer = towards_wall(start, np.linspace(flat, end, _POINTS))
    heights = np.concatenate([level, outer[1]]) - 2.0 * math.sin(end) / wanted
    radii = np.concatenate([inner, outer[0]])
    return RestSurface(read_only(length * radii), read_only(math.copysign(length, slope) * heights))
