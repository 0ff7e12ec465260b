"""The line of the surface on the wall: its edge in every column, and the curve through these.

Waves that a motion excites in a circular vessel vary with the cosine of the azimuth, so their line on the wall is that
of a plane. Seen from the side, u radii from the axis, it is

    z(u) = c + a u + e sqrt(1 - u^2)

on the front wall and on the rear one, with different e. Perspective and the second harmonic of a high wave add terms in
u sqrt(1 - u^2) and u^2. At u = -1 and 1 both lines end at the same heights, whichever of them is seen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.measuring.footage import opencv
from nospill.measuring.region import Region

_SOFT = 0.3e-3
"""m; standard deviation by which pictures are smoothed before edges are looked for."""
_EDGES = 4
"""Candidates in a column."""
_FAINT = 0.25
"""Part of the usual strength of the strongest edge below which an edge is none."""
_OUTER = 0.97
"""Radii from the axis up to which columns count: farther out the glass itself is seen."""
_DRAWS = 400
_NEAR = 0.6e-3
"""m; edges nearer to the curve belong to it."""
_ROUNDS = 6


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """Candidates for the surface: places (k,) in radii, levels (k,) m, strengths (k,), columns (k,); their number."""

    place: np.ndarray
    level: np.ndarray
    strength: np.ndarray
    column: np.ndarray
    columns: int


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """The surface in one frame.

    Attributes:
        left, right: heights at both walls above the marker's lower edge, m.
        deviation: standard deviation of the less certain of the two, m.
        confidence: part of the columns whose edge lies on the curve.
        sides: likewise of the outer thirds, left and right.
        strength: sum of the strengths of those edges.
        terms: (5,) of the curve.
    """

    left: float
    right: float
    deviation: float
    confidence: float
    sides: tuple[float, float]
    strength: float
    terms: np.ndarray


def edges(region: Region, sign: float) -> Edges:
    """Edges in every column, with their places between the pixels.

    Args:
        region: a vessel made straight.
        sign: 1 for a liquid that is brighter than what is above it, -1 for a darker one.
    """
    cv2 = opencv()
    soft = _SOFT / region.scale
    smooth = cv2.GaussianBlur(region.picture, (0, 0), sigmaX=soft, sigmaY=soft, borderType=cv2.BORDER_REPLICATE)
    rise = sign * 0.5 * (smooth[2:] - smooth[:-2])
    inside = np.flatnonzero(np.abs(region.place) < _OUTER)
    rise = np.where(region.seen[1:-1], rise, 0.0)[:, inside]
    peak = (rise[1:-1] > rise[:-2]) & (rise[1:-1] >= rise[2:])
    height = np.where(peak, rise[1:-1], 0.0)
    strongest = np.sort(height, axis=0)[-_EDGES:]
    usual = float(np.median(strongest[-1]))
    keep = (height >= strongest[0]) & (height > _FAINT * usual) & (height > 0.0)
    row, column = np.nonzero(keep)
    before, here, after = rise[row, column], rise[row + 1, column], rise[row + 2, column]
    between = 0.5 * (before - after) / np.minimum(before - 2.0 * here + after, -1e-12)
    level = region.level[0] - region.scale * (row + 2 + between)
    return Edges(region.place[inside][column], level, np.minimum(here, 1.5 * usual), column, len(inside))


def line(edges: Edges) -> Line | None:
    """The curve on which most of the edges lie; None where there are too few to tell.

    Draws of three edges each give a curve; that with the strongest edges near it is fitted to these again.
    """
    count = len(edges.level)
    if count < 12:
        return None
    terms = _terms(edges.place)
    generator = np.random.default_rng(0)
    drawn = generator.integers(count, size=(_DRAWS, 3))
    systems = terms[drawn][:, :, :3]
    usable = np.abs(np.linalg.det(systems)) > 1e-2
    if not np.any(usable):
        return None
    curves = np.linalg.solve(systems[usable], edges.level[drawn[usable]][:, :, None])[:, :, 0]
    distance = np.abs(curves @ terms[:, :3].T - edges.level)
    value = np.sum(np.where(distance < _NEAR, edges.strength * (1.0 - (distance / _NEAR) ** 2), 0.0), axis=1)
    best = np.append(curves[int(np.argmax(value))], (0.0, 0.0))
    on = np.abs(terms @ best - edges.level) < 1.5 * _NEAR
    for _ in range(_ROUNDS):
        if np.count_nonzero(on) < 12:
            return None
        weighted = terms[on] * np.sqrt(edges.strength[on])[:, None]
        best = np.linalg.lstsq(weighted, edges.level[on] * np.sqrt(edges.strength[on]), rcond=1e-6)[0]
        on = np.abs(terms @ best - edges.level) < _NEAR
    return _assess(edges, terms, best, on)


def _assess(edges: Edges, terms: np.ndarray, best: np.ndarray, on: np.ndarray) -> Line | None:
    left = edges.level[on] - terms[on] @ best
    if len(left) < 12:
        return None
    inverse = np.linalg.pinv(terms[on].T @ terms[on])
    # edges of neighbouring columns come from the same smoothed pixels
    variance = float(left @ left) / (len(left) - 5) * 8.0
    ends = np.array([[1.0, -1.0, 0.0, 0.0, 1.0], [1.0, 1.0, 0.0, 0.0, 1.0]])
    deviation = float(np.sqrt(np.max(np.sum(ends @ inverse * ends, axis=1)) * variance))
    hit = np.zeros(edges.columns, dtype=bool)
    hit[edges.column[on]] = True
    third = edges.columns // 3
    heights = ends @ best
    return Line(
        left=float(heights[0]),
        right=float(heights[1]),
        deviation=deviation,
        confidence=float(np.mean(hit)),
        sides=(float(np.mean(hit[:third])), float(np.mean(hit[-third:]))),
        strength=float(np.sum(edges.strength[on])),
        terms=best,
    )


def _terms(u: np.ndarray) -> np.ndarray:
    depth = np.sqrt(1.0 - u**2)
    return np.column_stack([np.ones_like(u), u, depth, u * depth, u**2])
