"""Triangles of the second order over the liquid's half of a meridian plane, fine at the surface and coarser below.

The nodes on the wall lie on the wall, so curved walls are met at the elements' own order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import Delaunay, KDTree

from nospill.errors import ModelError
from nospill.scene.meridian import Meridian

_GROWTH = 0.3
"""Growth of the distance of nodes per depth below the surface."""
_ACROSS = 12
"""Elements across the widest radius where nothing asks for more."""
_CLEAR = 0.62
"""Distances from the boundary within which no inner node is put."""
_DEEPEST = 100.0
"""Largest depth over the widest radius: nodes are as many as that, and below a few radii nothing moves."""
_TRIES = 8
_FINE = 64
"""Places at which a piece's length is measured."""


@dataclass(frozen=True, slots=True)
class MeridianMesh:
    """Quadratic triangles in the plane (r, z).

    Attributes:
        nodes: (n, 2), m.
        triangles: (t, 6) corners counter-clockwise, then the middles of the sides 01, 12, 20.
        surface: (e, 3) ends and middle of every edge on the free surface, from the axis to the wall.
        wall: (w, 3) the same on the wetted wall and bottom, from the axis to the surface.
    """

    nodes: np.ndarray
    triangles: np.ndarray
    surface: np.ndarray
    wall: np.ndarray


def mesh_liquid(meridian: Meridian, level: float, surface_elements: int, *, refinement: float = 1.0) -> MeridianMesh:
    """Divide the liquid below a level.

    Args:
        meridian: of the inside.
        level: height of the surface, m.
        surface_elements: elements along the surface's radius.
        refinement: how many times finer everything below is than it has to be.

    Raises:
        ModelError: the region is too intricate, or too deep for its width.
    """
    depth, widest = level - meridian.bottom, meridian.widest(level)
    if depth > _DEEPEST * widest:
        raise ModelError(
            f"the liquid is {depth / widest:.0f} times as deep as the widest radius of its vessel, "
            f"{1e3 * widest:.3g} mm; the slosh model takes up to {_DEEPEST:.0f}: a wider vessel or less liquid"
        )
    spacing = _Spacing(meridian, level, surface_elements, refinement)
    pieces = meridian.wetted(level)
    density = np.ones(len(pieces))
    for _ in range(_TRIES):
        walls = [_along_piece(piece, spacing, by) for piece, by in zip(pieces, density, strict=True)]
        wall = np.concatenate([walls[0][:1], *[line[1:] for line in walls]])
        radius = float(wall[-1, 0])
        wall[-1, 1] = level
        surface = np.linspace((0.0, level), (radius, level), 2 * surface_elements + 1)
        axis = _straight(np.array([0.0, wall[0, 1]]), np.array([0.0, level]), spacing)
        # Counter-clockwise: along the wall, back along the surface, down the axis.
        ring = np.concatenate([wall, surface[::-1][1:], axis[::-1][1:-1]])
        corners = ring[::2]
        points = np.concatenate([corners, _inner(corners, wall, spacing)])
        triangles = _triangles(points, wall[::2])
        missing = _missing(triangles, len(corners))
        if not len(missing):
            return _quadratic(points, triangles, ring, len(wall) // 2, surface_elements)
        ends = np.cumsum([len(line) // 2 for line in walls])
        hit = np.unique(np.searchsorted(ends, missing[missing < ends[-1]], side="right"))
        density[hit if len(hit) else slice(None)] *= 1.6
    raise ModelError("the inside of the vessel is too intricate for the slosh model; give a plainer profile")


class _Spacing:
    """Distance of nodes as a function of the height."""

    def __init__(self, meridian: Meridian, level: float, surface_elements: int, refinement: float) -> None:
        self.level, self.bottom = level, meridian.bottom
        radius = meridian.radius(level)
        self.fine = radius / surface_elements
        self.coarse = max(meridian.widest(level) / _ACROSS / refinement, self.fine)
        self.growth = _GROWTH / refinement

    def at(self, z: np.ndarray) -> np.ndarray:
        return np.minimum(self.fine + self.growth * np.maximum(self.level - z, 0.0), self.coarse)

    def rows(self) -> list[float]:
        """Heights of rows of inner nodes."""
        found, z = [], self.level
        while (z := z - 0.85 * float(self.at(np.array(z)))) > self.bottom:
            found.append(z)
        return found


def _straight(start: np.ndarray, end: np.ndarray, spacing: _Spacing) -> np.ndarray:
    return _along_piece(np.stack([start, end - start, 0 * end, 0 * end])[None], spacing, 1.0)


def _along_piece(piece: np.ndarray, spacing: _Spacing, density: float) -> np.ndarray:
    """Points (2n + 1, 2) along a piece of cubics: every other one is a corner of an element."""
    place = np.linspace(0.0, len(piece), _FINE * len(piece) + 1)
    points = _evaluate(piece, place)
    middle = (points[1:, 1] + points[:-1, 1]) / 2
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    count = np.concatenate([[0.0], np.cumsum(density * lengths / spacing.at(middle))])
    elements = max(int(np.ceil(count[-1] - 1e-6)), 1)
    wanted = np.linspace(0.0, count[-1], 2 * elements + 1)
    return _evaluate(piece, np.interp(wanted, count, place))


def _evaluate(piece: np.ndarray, place: np.ndarray) -> np.ndarray:
    index = np.minimum(place.astype(int), len(piece) - 1)
    return np.einsum("npx,pn->nx", piece[index], (place - index) ** np.arange(4)[:, None])


def _inner(corners: np.ndarray, wall: np.ndarray, spacing: _Spacing) -> np.ndarray:
    """Rows of nodes, each shifted by half a distance, clear of the boundary."""
    rows = []
    for number, z in enumerate(spacing.rows()):
        step = float(spacing.at(np.array(z)))
        reach = float(np.interp(z, wall[:, 1], wall[:, 0]))
        r = np.arange(0.5 if number % 2 else 1.0, reach / step, 1.0) * step
        rows.append(np.column_stack([r, np.full(len(r), z)]))
    points = np.concatenate(rows) if rows else np.zeros((0, 2))
    distance = KDTree(corners).query(points)[0]
    return points[distance > _CLEAR * spacing.at(points[:, 1])]


def _triangles(points: np.ndarray, wall: np.ndarray) -> np.ndarray:
    """Delaunay triangles (t, 3) inside the wall's corners, counter-clockwise."""
    found = Delaunay(points).simplices
    first, second, third = (points[found[:, corner]] for corner in range(3))
    area = (second - first)[:, 0] * (third - first)[:, 1] - (second - first)[:, 1] * (third - first)[:, 0]
    centre = (first + second + third) / 3
    inside = centre[:, 0] < np.interp(centre[:, 1], wall[:, 1], wall[:, 0])
    size = np.max(np.ptp(points, axis=0))
    found = np.where((area < 0.0)[:, None], found[:, ::-1], found)
    return found[inside & (np.abs(area) > 1e-12 * size**2)]


def _missing(triangles: np.ndarray, count: int) -> np.ndarray:
    """Indices of the edges round the boundary that are no triangle's side."""
    sides = np.sort(np.concatenate([triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1)
    known = set(map(tuple, sides.tolist()))
    edges = [tuple(sorted((index, (index + 1) % count))) for index in range(count)]
    return np.array([index for index, edge in enumerate(edges) if edge not in known], dtype=int)


def _quadratic(
    points: np.ndarray, triangles: np.ndarray, ring: np.ndarray, wall_edges: int, surface_edges: int
) -> MeridianMesh:
    """Add the middles of the sides; on the boundary they lie on it."""
    count = len(ring) // 2
    sides = np.stack([triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])], axis=1)
    edges, index = np.unique(np.sort(sides, axis=2).reshape(-1, 2).astype(np.int64), axis=0, return_inverse=True)
    middles = points[edges].mean(axis=1)
    around = np.arange(count)
    ends = np.sort(np.column_stack([around, (around + 1) % count]), axis=1)
    order = np.lexsort(edges.T[::-1])
    keys = edges[order, 0] * len(points) + edges[order, 1]
    on_boundary = order[np.searchsorted(keys, ends[:, 0] * len(points) + ends[:, 1])]
    middles[on_boundary] = ring[1::2]
    nodes = np.concatenate([points, middles])
    numbered = np.column_stack([triangles, len(points) + index.reshape(-1, 3)])
    boundary = np.column_stack([around, (around + 1) % count, len(points) + on_boundary])
    surface = boundary[wall_edges : wall_edges + surface_edges][::-1, [1, 0, 2]]
    return MeridianMesh(nodes, numbered, surface, boundary[:wall_edges])
