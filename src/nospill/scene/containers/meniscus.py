"""Surface at rest of a liquid that wets the wall of a round vessel: higher at the wall than on the axis.

With c^2 = sigma/(rho g) the surface at the height u over the level of no pressure difference and with the slope angle
psi obeys d(r sin psi)/dr = r u/c^2 [Young, Laplace], integrated here over psi from a nearly flat start on, where
u = u_0 I_0(r/c), to the vertical at the wall. The weight of what is lifted hangs on the wall, so the mean of u is
2 c^2/R: the heights below count from the flat surface of the same volume.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

from nospill.scene.containers.base import Container
from nospill.scene.containers.footprints import DiscFootprint
from nospill.scene.containers.modes import STANDARD_GRAVITY
from nospill.scene.containers.tension import wetting_rise
from nospill.scene.liquids import Liquid

_FLAT = 1e-3
"""rad; slope up to which the surface is the linear one."""
_LEAST = 1e-6
"""m; of a capillary length: less is no surface tension."""


class Meniscus(NamedTuple):
    """The surface at rest against the flat one of the same volume.

    Attributes:
        rise: how much higher it stands at the wall, m.
        drop: how much lower on the axis, m.
    """

    rise: float
    drop: float


def meniscus(liquid: Liquid, radius: float) -> Meniscus:
    """The meniscus of a liquid that wets an upright wall wholly: the highest at the wall of all contact angles.

    Args:
        liquid: what is in it.
        radius: of the surface, m.
    """
    length = math.sqrt(liquid.surface_tension / (liquid.density * STANDARD_GRAVITY))
    return Meniscus(0.0, 0.0) if length < _LEAST else _meniscus(length, radius)


def meniscus_in(container: Container, liquid: Liquid, level: float) -> Meniscus:
    """The meniscus at a level (m); between the straight walls of a box that at one of them, which is higher."""
    section = container.section(level)
    if isinstance(section, DiscFootprint):
        return meniscus(liquid, section.radius)
    return Meniscus(wetting_rise(liquid), 0.0)


@lru_cache(maxsize=256)
def _meniscus(length: float, radius: float) -> Meniscus:
    from scipy.integrate import solve_ivp  # slow to load, and few scenarios have small vessels
    from scipy.optimize import brentq
    from scipy.special import ive

    wanted = radius / length

    def slopes(psi: float, place: tuple[float, float]) -> tuple[float, float]:
        r, u = place
        turn = u - math.sin(psi) / r
        return math.cos(psi) / turn, math.sin(psi) / turn

    def wall(start: float) -> tuple[float, float]:
        """Radius and height at the wall, capillary lengths, of the surface that is flat up to a radius."""
        height = _FLAT * float(ive(0, start) / ive(1, start))
        found = solve_ivp(slopes, (_FLAT, math.pi / 2), (start, height), rtol=1e-8, atol=1e-12)
        return float(found.y[0, -1]), float(found.y[1, -1])

    # a small surface is a hemisphere, r = psi R; a large one is flat but for a rim
    start = float(brentq(lambda value: wall(value)[0] - wanted, 0.1 * _FLAT * wanted, wanted, rtol=1e-10))  # type: ignore[arg-type]
    lowest = _FLAT * math.exp(-start) / float(ive(1, start))
    mean = 2.0 / wanted
    return Meniscus(length * (wall(start)[1] - mean), length * (mean - lowest))
