"""The free surface of a liquid as a mesh that follows the slosh coordinates.

A mode raises the surface by C_n q at the wall and by C_n q times its shape elsewhere; for a circular wall the shape is
J1(k_n r)/J1(k_n R) along the mode's direction (nearly so where the wall is not upright), for a box
sin(k_n x)/sin(k_n a/2) along its side. With the quasi-static correction of `slosh.height` all modes that are not
carried follow the apparent gravity at once, so together they are the plane that leans with it less the carried modes'
own share: -(a_x/a_z) (x - sum C_n g/omega_n^2 shape_n(x)), which at the wall is `static_correction` times the lean.
The yaw modes of a box that turns have shapes of their own, and what of them is not carried follows alpha_z/a_z.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.drawing.geometry import Mesh, drawn_section, half_width, shrunk, wall_thickness
from nospill.potential_flow import driven_shapes
from nospill.scene.cargo import Cargo
from nospill.scene.containers.footprints import Footprint
from nospill.scene.heights import HeightOrder, to_second_order
from nospill.scene.sloshing.modes import WALL_POINTS
from nospill.scene.sloshing.yaw_modes import mode_shapes, zhukovsky_potential

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
            per lean of the apparent gravity along x and y; of a box that turns a column more, per alpha_z/a_z, 1/m;
            then one for each mode of the second order, where that is drawn.
        wall: (2, k + 2): the same at the wall on the positive side of x and of y; of a box that turns nine rows more,
            of its yaw modes at places of its wall.
        section: of the container at rest level, whose edge the wall follows.
        floor: height of the floor inside, m, below which no surface is drawn.
        around: number of points round the wall.
        widths: (k, 2) height in m and size of the inside, as a part of that at rest level.
    """

    rest: Mesh
    upper: np.ndarray
    points: np.ndarray
    basis: np.ndarray
    wall: np.ndarray
    section: Footprint
    floor: float
    around: int
    widths: np.ndarray

    @property
    def upper_faces(self) -> int:
        """How many of the first faces are the free surface; the others are the side."""
        return (2 * _RINGS - 1) * self.around

    @property
    def edge(self) -> np.ndarray:
        """Indices of the vertices (n,) along the line where the free surface meets the wall, counter-clockwise."""
        return self.upper[-self.around :]

    def rise(self, coordinates: np.ndarray) -> np.ndarray:
        """Height above rest of every upper vertex, (u,) m, from (k + 2,) coordinates and leans."""
        return self.basis @ coordinates

    def crest(self, coordinates: np.ndarray) -> np.ndarray:
        """Greatest height round the wall, (m,) m, as `slosh.height` bounds it, from (m, k + 2): the linear one."""
        along, yaw = np.split((coordinates[:, : self.wall.shape[1]] @ self.wall.T).T, [2])
        vectors = self.section.crest_vectors(along)
        height = np.max([np.linalg.norm(np.atleast_2d(vector), axis=0) for vector in vectors], axis=0)
        return height + np.max(np.abs(yaw), axis=0, initial=0.0)

    def vertices(self, coordinates: np.ndarray) -> np.ndarray:
        """All vertices (n, 3), m, for (k + 2,) coordinates and leans.

        The surface is as wide as the inside where it meets the wall, and what is below the surface stays below it.
        """
        moved = self.rest.vertices.copy()
        moved[self.upper, 2] = np.maximum(moved[self.upper, 2] + self.rise(coordinates), self.floor)
        edge = moved[self.edge, 2]
        rings = len(self.upper) // self.around
        moved[self.upper[1:], :2] *= np.tile(np.interp(edge, *self.widths.T), rings)[:, None]
        below = moved[len(self.upper) :].reshape(-1, self.around, 3)
        below[..., 2] = np.minimum(below[..., 2], edge)
        return moved


def liquid_surface(cargo: Cargo, order: HeightOrder = "linear") -> LiquidSurface:
    """The surface of the liquid in an object, to the order to which the scene judges heights.

    Raises:
        ValueError: there is no liquid in it.
    """
    if cargo.filling is None:
        raise ValueError(f"{cargo.name} holds no liquid")
    container, level = cargo.container, cargo.filling.liquid_height
    section = container.section(level)
    size = float(section.half_lengths[0] / container.footprint.half_lengths[0])
    # Slightly inside the wall, or both surfaces flicker where they meet.
    gap = 1.2 * wall_thickness(container)
    picked = _ring(container.outline)
    outline = size * picked
    drawn = shrunk(outline, gap)
    floor = container.inside[0, 1] + min(gap, 0.5 * cargo.filling.depth)
    inside = drawn_section(container.inside, half_width(container))
    below = [(part * picked, height) for part, height in inside if floor < height < level]
    bottom = [part for part, height in container.inside if height <= floor]
    sides = [(shrunk(ring, gap), height) for ring, height in below[::-1]]
    sides.append((shrunk(max(bottom[-1], 1e-3) * picked, gap), floor))
    count = len(outline)
    radii = np.arange(1, _RINGS + 1) / _RINGS
    true = np.concatenate([np.zeros((1, 2)), *[radius * outline for radius in radii], outline])
    flat = np.concatenate([np.zeros((1, 2)), *[radius * drawn for radius in radii], drawn])
    upper = np.column_stack([flat, np.full(len(flat), level)])
    lower = [np.column_stack([ring, np.full(count, height)]) for ring, height in sides]
    added = [driven_shapes(container, true)] if to_second_order(cargo, order) else []
    return LiquidSurface(
        rest=Mesh(np.concatenate([upper, *lower]), _faces(count, len(sides))),
        upper=np.arange(len(flat)),
        points=true,
        basis=np.column_stack([_basis(cargo, section, true), *added]),
        wall=_wall(cargo, section),
        section=section,
        floor=floor,
        around=count,
        widths=np.column_stack([container.inside[:, 1], container.inside[:, 0] / size]),
    )


def _ring(outline: np.ndarray) -> np.ndarray:
    """An outline with points between its corners, (n, 2), m."""
    if len(outline) >= _RING_POINTS:
        return outline[:: len(outline) // _RING_POINTS]
    parts = -(-_RING_POINTS // len(outline))
    fractions = np.arange(parts)[:, None] / parts
    pairs = zip(outline, np.roll(outline, -1, axis=0), strict=True)
    return np.concatenate([(1 - fractions) * start + fractions * end for start, end in pairs])


def _faces(count: int, bands_below: int) -> np.ndarray:
    """Fan round the centre, bands between the rings, and the side down to the floor."""
    here = np.arange(count)
    after = (here + 1) % count
    faces = [np.column_stack([np.zeros(count, dtype=int), 1 + here, 1 + after])]
    starts = [1 + ring * count for ring in range(_RINGS)]
    bands = list(zip(starts[1:], starts[:-1], strict=True))
    side = 1 + _RINGS * count
    # The side has its own copy of the rim, so that light breaks there; its lower rings come last.
    bands += [(side + (number + 1) * count, side + number * count) for number in range(bands_below)]
    for outer, inner in bands:
        faces.append(np.column_stack([inner + here, outer + here, outer + after]))
        faces.append(np.column_stack([inner + here, outer + after, inner + after]))
    return np.concatenate(faces)


def _basis(cargo: Cargo, section: Footprint, points: np.ndarray) -> np.ndarray:
    """Rise of the surface at points (u, 2) per slosh coordinate and per lean, (u, k + 2); one more of a turning box."""
    assert cargo.filling is not None
    filling, modes = cargo.filling, cargo.filling.modes
    # a surface that surface tension holds leans less than a plane does; this is its rise at the wall, linear inside
    columns, leans = [], points * (modes.quasi_static_gain / section.half_lengths)
    for mode in modes.oscillators:
        for direction in mode.directions:
            axis = _AXES[direction]
            shape = mode.surface_gain * section.mode_shape(mode.wave_number, points, axis)
            columns.append(shape)
            leans[:, axis] -= shape * mode.compliance
    if not filling.turns or modes.yaw is None:
        return np.column_stack([*columns, -leans])
    shapes, at_once = mode_shapes(modes.yaw, points), zhukovsky_potential(modes.yaw.sides, points)
    at_once = at_once - shapes @ np.array([mode.arm * mode.compliance for mode in modes.yaw.oscillators])
    return np.column_stack([*columns, shapes, -leans, -at_once])


def _wall(cargo: Cargo, section: Footprint) -> np.ndarray:
    """The same at the wall, as `LiquidSurface.wall`."""
    assert cargo.filling is not None
    rows = _basis(cargo, section, np.diag(section.half_lengths))
    yaw = cargo.filling.modes.yaw if cargo.filling.turns else None
    if yaw is None:
        return rows
    only = np.zeros((WALL_POINTS, rows.shape[1]))
    yaw_columns = np.r_[len(rows[0]) - 3 - len(yaw.oscillators) : len(rows[0]) - 3, len(rows[0]) - 1]
    only[:, yaw_columns] = np.column_stack(
        [np.array([mode.wall_gains for mode in yaw.oscillators]).T, -yaw.static_correction]
    )
    return np.concatenate([rows, only])
