"""Where a plane surface that leans meets the wall, in vessels that are no prisms too.

The slosh model counts its crest upright at the radius of the surface at rest. The liquid under a plane that leans keeps
its volume, and its edge runs along the wall: higher than the crest where the wall opens, lower where it closes.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from nospill.scene.containers.base import Container
from nospill.scene.containers.footprints import DiscFootprint

_SLICES = 400
"""Horizontal slices below the rest level, and as many above it: the edge of a cone's plane is met to 1e-5 of its
crest."""
_LEAST = 1e-6
"""m; crests below this are this high."""


class Edge(NamedTuple):
    """The highest point of a plane surface on the wall.

    Attributes:
        height: above the container's bottom, m; of what goes over the rim, as if the wall went on upright.
        below_rim: upright distance to the rim, m; negative over it.
        along_wall: distance to the rim along the wall, m; negative over it.
    """

    height: float
    below_rim: float
    along_wall: float


@lru_cache(maxsize=512)
def edge_of_plane(container: Container, level: float, crest: float) -> Edge:
    """The edge of the plane whose slope is the crest over the radius, or half the side, of the surface at rest.

    Exact for a liquid at rest in an apparent gravity that leans so far. Of a moving liquid the first mode is nearly
    plane. In a box the crest itself, of which nothing says along which side it leans.

    Args:
        container: of any shape.
        level: of the surface at rest above the bottom, m.
        crest: its greatest height above that at the wall by the slosh model, m.
    """
    section = container.section(level)
    if not isinstance(section, DiscFootprint):
        left = container.height - level - crest
        return Edge(level + crest, left, left)
    wall = container.inside * (container.footprint.half_lengths[0], 1.0)
    slope = max(crest, _LEAST) / section.radius
    middle = _height_on_axis(wall, level, slope)
    above = wall[:, 1] - middle - slope * wall[:, 0]
    reached = np.flatnonzero(above >= 0.0)
    if not len(reached):
        height = middle + slope * float(wall[-1, 0])
        return Edge(height, container.height - height, container.height - height)
    end = int(reached[0])
    place = wall[end]
    if end:
        place = wall[end - 1] + (wall[end] - wall[end - 1]) * above[end - 1] / (above[end - 1] - above[end])
    steps = np.diff(np.vstack([place, wall[end:]]), axis=0)
    return Edge(float(place[1]), container.height - float(place[1]), float(np.sum(np.linalg.norm(steps, axis=1))))


def _height_on_axis(wall: np.ndarray, level: float, slope: float) -> float:
    """Where a plane of a slope cuts the axis that leaves the volume below it as it is at rest.

    Args:
        wall: the meridian of the inside, (n, 2), m.
        level: of the surface at rest, m.
        slope: rise per length.
    """
    # Within this height of the level the plane meets the wall, wherever it cuts the axis.
    rise = slope * float(np.max(wall[:, 0]))
    ends = np.concatenate(
        [
            np.linspace(max(level - 2 * rise, wall[0, 1]), level, _SLICES + 1),
            np.linspace(level, level + 2 * rise, _SLICES + 1)[1:],
        ]
    )
    heights, sizes = (ends[1:] + ends[:-1]) / 2, np.diff(ends)
    radii = np.interp(heights, wall[:, 1], wall[:, 0])
    if level - rise >= wall[0, 1] and np.ptp(radii[np.abs(heights - level) <= rise]) == 0.0:
        return level  # an upright wall: what the plane takes on one side it gives on the other
    at_rest = np.pi * radii**2 * (heights < level)

    def gained(middle: float) -> float:
        # Of a slice the part of the disc that lies beyond the line in which the plane cuts it.
        line = np.clip((heights - middle) / slope, -radii, radii)
        covered = radii**2 * np.arccos(line / radii) - line * np.sqrt(radii**2 - line**2)
        return float(np.sum(sizes * (covered - at_rest)))

    from scipy.optimize import brentq  # slow to load, and most walls are upright

    return float(brentq(gained, level - rise, level + rise, xtol=1e-12))  # type: ignore[arg-type]
