"""The free surface of a liquid as a mesh that follows the slosh coordinates.

A mode raises the surface by C_n q at the wall and by C_n q times its shape elsewhere; for a circular wall the shape is
J1(k_n r)/J1(k_n R) along the mode's direction, for a box sin(k_n x)/sin(k_n a/2) along its side. With the quasi-static
correction of `slosh.height` all modes that are not carried follow the apparent gravity at once, so together they are
the plane that leans with it less the carried modes' own share: -(a_x/a_z) (x - sum C_n g/omega_n^2 shape_n(x)), which
at the wall is `static_correction` times the lean.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.film.geometry import Mesh, shrunk, wall_thickness
from nospill.scene.cargo import Cargo
from nospill.scene.containers.footprints import Footprint

_RING_POINTS = 32
"""Points round the wall, at least."""
_RINGS = 4
_AXES = {"x": 0, "y": 1}


@dataclass(frozen=True, slots=True)
class LiquidSurface:
    """Mesh of one liquid at rest, container frame, and what moves its upper vertices.

    Attributes:
        rest: the liquid's body at rest, m. Drawn inside the wall, so a little narrower than the liquid is.
        upper: (u,) indices of the vertices on the free surface.
        points: (u, 2) where in the liquid these are, m: out to the true wall.
        basis: (u, k + 2): rise in m of every upper vertex per slosh coordinate (k, in the order of the trajectory) and
            per lean of the apparent gravity along x and y.
        wall: (2, k + 2): the same at the wall on the positive side of x and of y.
        footprint: of the container, whose edge the wall follows.
        floor: height of the floor inside, m, below which no surface is drawn.
    """

    rest: Mesh
    upper: np.ndarray
    points: np.ndarray
    basis: np.ndarray
    wall: np.ndarray
    footprint: Footprint
    floor: float

    @property
    def upper_faces(self) -> int:
        """How many of the first faces are the free surface; the others are the side."""
        return len(self.rest.faces) - 2 * len(self.edge)

    @property
    def edge(self) -> np.ndarray:
        """Indices of the vertices (n,) along the line where the free surface meets the wall, counter-clockwise."""
        count = len(self.rest.vertices) - len(self.upper)
        return self.upper[-count:]

    def rise(self, coordinates: np.ndarray) -> np.ndarray:
        """Height above rest of every upper vertex, (u,) m, from (k + 2,) coordinates and leans."""
        return self.basis @ coordinates

    def crest(self, coordinates: np.ndarray) -> np.ndarray:
        """Greatest height round the wall, (m,) m, as `slosh.height` bounds it, from (m, k + 2)."""
        vectors = self.footprint.crest_vectors((coordinates @ self.wall.T).T)
        return np.max([np.linalg.norm(np.atleast_2d(vector), axis=0) for vector in vectors], axis=0)

    def vertices(self, coordinates: np.ndarray) -> np.ndarray:
        """All vertices (n, 3), m, for (k + 2,) coordinates and leans."""
        moved = self.rest.vertices.copy()
        moved[self.upper, 2] = np.maximum(moved[self.upper, 2] + self.rise(coordinates), self.floor)
        return moved


def liquid_surface(cargo: Cargo) -> LiquidSurface:
    """The surface of the liquid in an object.

    Raises:
        ValueError: there is no liquid in it.
    """
    if cargo.filling is None:
        raise ValueError(f"{cargo.name} holds no liquid")
    outline = _ring(cargo)
    wall = wall_thickness(cargo.container)
    # Slightly inside the wall, or both surfaces flicker where they meet.
    drawn = shrunk(outline, 1.02 * wall)
    level, floor = cargo.filling.liquid_height, min(1.02 * wall, 0.5 * cargo.filling.liquid_height)
    count = len(outline)
    radii = np.arange(1, _RINGS + 1) / _RINGS
    true = np.concatenate([np.zeros((1, 2)), *[radius * outline for radius in radii], outline])
    flat = np.concatenate([np.zeros((1, 2)), *[radius * drawn for radius in radii], drawn])
    upper = np.column_stack([flat, np.full(len(flat), level)])
    vertices = np.concatenate([upper, np.column_stack([drawn, np.full(count, floor)])])
    return LiquidSurface(
        rest=Mesh(vertices, _faces(count)),
        upper=np.arange(len(flat)),
        points=true,
        basis=_basis(cargo, true),
        wall=_basis(cargo, np.diag(np.max(np.abs(outline), axis=0))),
        footprint=cargo.container.footprint,
        floor=floor,
    )


def _ring(cargo: Cargo) -> np.ndarray:
    """The container's outline with points between its corners, (n, 2), m."""
    outline = cargo.container.outline
    if len(outline) >= _RING_POINTS:
        return outline[:: len(outline) // _RING_POINTS]
    parts = -(-_RING_POINTS // len(outline))
    fractions = np.arange(parts)[:, None] / parts
    pairs = zip(outline, np.roll(outline, -1, axis=0), strict=True)
    return np.concatenate([(1 - fractions) * start + fractions * end for start, end in pairs])


def _faces(count: int) -> np.ndarray:
    """Fan round the centre, bands between the rings, and the side down to the floor."""
    here = np.arange(count)
    after = (here + 1) % count
    faces = [np.column_stack([np.zeros(count, dtype=int), 1 + here, 1 + after])]
    starts = [1 + ring * count for ring in range(_RINGS)]
    bands = list(zip(starts[1:], starts[:-1], strict=True))
    side = 1 + _RINGS * count
    # The side has its own copy of the rim, so that light breaks there; its lower ring comes last.
    bands.append((side + count, side))
    for outer, inner in bands:
        faces.append(np.column_stack([inner + here, outer + here, outer + after]))
        faces.append(np.column_stack([inner + here, outer + after, inner + after]))
    return np.concatenate(faces)


def _basis(cargo: Cargo, points: np.ndarray) -> np.ndarray:
    """Rise of the surface at points (u, 2) per slosh coordinate and per lean, (u, k + 2)."""
    assert cargo.filling is not None
    columns, leans = [], points.copy()
    for mode in cargo.filling.modes.oscillators:
        for direction in mode.directions:
            axis = _AXES[direction]
            shape = mode.surface_gain * cargo.container.footprint.mode_shape(mode.wave_number, points, axis)
            columns.append(shape)
            leans[:, axis] -= shape / mode.stiffness
    return np.column_stack([*columns, -leans])
