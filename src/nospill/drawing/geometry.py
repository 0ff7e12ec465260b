"""Triangle meshes of plain bodies: prisms, open shells, tapered tubes. Numbers in, vertices out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nospill.scene.containers.base import Container

TUBE_SIDES = 32
"""Corners round a tube."""
_BALL_SIDES, _BALL_RINGS = 32, 8
"""Corners round a ball, and rings of them from its equator to a pole."""
_SAGITTA = 1e-3
"""Least detail of a section over its half width: what the 64 corners of a circle are off."""
_SMOOTH = float(np.cos(np.radians(35.0)))
"""Corners whose faces differ by less are shaded as one round surface."""


@dataclass(frozen=True, slots=True)
class Mesh:
    """Triangles: vertices (n, 3) in m, faces (k, 3) indices, counter-clockwise seen from outside."""

    vertices: np.ndarray
    faces: np.ndarray


def merge_meshes(meshes: Sequence[Mesh]) -> Mesh:
    """Several meshes as one."""
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes[:-1]])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]),
    )


def transform_mesh(mesh: Mesh, position: np.ndarray, rotation: np.ndarray) -> Mesh:
    """A mesh in another frame, in which its own has its origin at (3,), m, and axes (3, 3)."""
    return Mesh(mesh.vertices @ rotation.T + position, mesh.faces)


def shrunk(outline: np.ndarray, gap: float) -> np.ndarray:
    """An outline (n, 2) drawn in by `gap` m on every side of its bounding box (a circle by `gap` everywhere)."""
    half = np.max(np.abs(outline), axis=0)
    return outline * np.maximum(1.0 - gap / half, 0.0)


def prism(outline: np.ndarray, bottom: float, top: float) -> Mesh:
    """Closed prism over a convex outline (n, 2), counter-clockwise, m, between two heights in m."""
    low, high = _at_height(outline, bottom), _at_height(outline, top)
    return merge_meshes([_strip(low, high), _cap(high), _cap(low, downwards=True)])


def bands(outlines: Sequence[np.ndarray], heights: Sequence[float] | np.ndarray) -> Mesh:
    """Bands from each outline (n, 2), counter-clockwise, m, at its height in m to the next; open at both ends.

    Their outside is seen where the heights rise. Neighbours share their vertices, so that a curved wall is shaded as
    one.
    """
    rings = [_at_height(outline, float(height)) for outline, height in zip(outlines, heights, strict=True)]
    count = len(rings[0])
    faces = np.concatenate([_faces_between_rings(count) + number * count for number in range(len(rings) - 1)])
    return Mesh(np.concatenate(rings), faces)


def drawn_section(section: np.ndarray, half_width: float) -> np.ndarray:
    """The points of a container's section that a picture needs, by Douglas and Peucker.

    Vessels come with hundreds of points; a straight line may pass a left out one by `_SAGITTA` of the half width.

    Args:
        section: (n, 2), part of the outline and height in m, as `Container.inside`.
        half_width: of the outline, m.

    Returns:
        (k, 2), some of the points, both ends among them.
    """
    points = section * (half_width, 1.0)
    kept = np.zeros(len(points), dtype=bool)
    kept[[0, -1]] = True
    spans = [(0, len(points) - 1)]
    while spans:
        first, last = spans.pop()
        between = points[first + 1 : last] - points[first]
        if not len(between):
            continue
        chord = points[last] - points[first]
        along = np.clip(between @ chord / max(float(chord @ chord), 1e-30), 0.0, 1.0)
        off = np.linalg.norm(between - along[:, None] * chord, axis=1)
        worst = int(np.argmax(off))
        if off[worst] > _SAGITTA * half_width:
            kept[first + 1 + worst] = True
            spans += [(first, first + 1 + worst), (first + 1 + worst, last)]
    return section[kept]


def tube(start: np.ndarray, end: np.ndarray, radii: tuple[float, float], *, sides: int = TUBE_SIDES) -> Mesh:
    """Closed tapered tube between two points (3,), m, with its radius at each, m.

    Raises:
        ValueError: both points are the same.
    """
    along = np.asarray(end, dtype=float) - np.asarray(start, dtype=float)
    length = float(np.linalg.norm(along))
    if length == 0.0:
        raise ValueError("a tube from a point to itself has no direction")
    along = along / length
    helper = np.eye(3)[int(np.argmin(np.abs(along)))]
    across = np.cross(along, helper)
    across /= np.linalg.norm(across)
    other = np.cross(along, across)
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.outer(np.cos(angle), across) + np.outer(np.sin(angle), other)
    low, high = start + radii[0] * ring, end + radii[1] * ring
    return merge_meshes([_strip(low, high), _cap(high), _cap(low, downwards=True)])


def capsule(half: float, radius: float) -> Mesh:
    """A ball about the origin, drawn out along z by `half` m each way; its vertices are shared, so that it is round."""
    angle = 2 * np.pi * np.arange(_BALL_SIDES) / _BALL_SIDES
    circle = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(_BALL_SIDES)])
    rise = np.pi / 2 * (np.arange(1, _BALL_RINGS + 1) - 0.5) / _BALL_RINGS
    rise = np.concatenate([-rise[::-1], rise])
    up = np.array([0.0, 0.0, 1.0])
    heights = radius * np.sin(rise) + np.sign(rise) * half
    rings = [radius * np.cos(at) * circle + height * up for at, height in zip(rise, heights, strict=True)]
    poles = np.array([-1.0, 1.0])[:, None] * (half + radius) * up
    low, high = len(rings) * _BALL_SIDES, len(rings) * _BALL_SIDES + 1
    here = np.arange(_BALL_SIDES)
    after = (here + 1) % _BALL_SIDES
    faces = [np.column_stack([after, here, np.full(_BALL_SIDES, low)])]
    for first in range(0, low - _BALL_SIDES, _BALL_SIDES):
        beyond = first + _BALL_SIDES
        faces.append(np.column_stack([first + here, first + after, beyond + after]))
        faces.append(np.column_stack([first + here, beyond + after, beyond + here]))
    top = low - _BALL_SIDES
    faces.append(np.column_stack([top + here, top + after, np.full(_BALL_SIDES, high)]))
    return Mesh(np.concatenate([*rings, poles]), np.concatenate(faces))


def container_body(container: Container, *, hollow: bool) -> Mesh:
    """A container as it is seen, container frame: a vessel with its wall, or a solid.

    The wall stands inside the outside; real walls are thin, so its thickness is only for the eye.
    """
    outside = drawn_section(container.outside, half_width(container))
    outlines, heights = [size * container.outline for size in outside[:, 0]], list(outside[:, 1])
    end = outlines[-1], heights[-1]
    if hollow:
        inside, levels = drawn_inside(container, wall_thickness(container))
        outlines, heights = [*outlines, *inside[::-1]], [*heights, *levels[::-1]]
        end = inside[0], levels[0]
    bottom = _at_height(outlines[0], heights[0])
    return merge_meshes([bands(outlines, heights), _cap(_at_height(*end)), _cap(bottom, downwards=True)])


def drawn_inside(container: Container, wall: float) -> tuple[list[np.ndarray], list[float]]:
    """Outlines (n, 2) of the inside as it is drawn, from the floor to the rim, and their heights, m.

    `wall`: m, by which they stand inside; the same on every side, and below.
    """
    floor = float(container.inside[0, 1]) + wall
    half = half_width(container)
    wide = [(size, float(z)) for size, z in drawn_section(container.inside, half) if size * half > 1.5 * wall]
    outlines = [shrunk(size * container.outline, wall) for size, _ in wide]
    return outlines, [floor, *(max(z, floor) for _, z in wide[1:-1]), wide[-1][1]]


def wall_thickness(container: Container) -> float:
    """Thickness a container's wall is drawn with, m: a twenty-fifth of its narrower half width."""
    return 0.04 * half_width(container)


def widest_outline(container: Container) -> np.ndarray:
    """Outline seen from above, (n, 2), m: that of the widest section."""
    return float(np.max(container.outside[:, 0])) * container.outline


def outline_at(container: Container, height: float) -> np.ndarray:
    """Outline of the outside at a height in m, (n, 2), m."""
    return float(np.interp(height, container.outside[:, 1], container.outside[:, 0])) * container.outline


def half_width(container: Container) -> float:
    """Of the footprint's outline, where it is narrower, m."""
    return float(np.min(np.max(np.abs(container.outline), axis=0)))


def contact_collar(container: Container, *, height: float = 0.006, overhang: float = 0.003) -> Mesh:
    """A low band round the foot of an object, container frame, m: what carries the colour of its contact."""
    return prism(shrunk(container.outline, -overhang), 0.0, height)


def ribbon(ring: np.ndarray, height: float) -> Mesh:
    """A narrow band along a closed line (n, 3), m, half of its height below and half above; its outside is seen."""
    half = np.array([0.0, 0.0, height / 2])
    return _strip(ring - half, ring + half)


def board(size: np.ndarray, thickness: float) -> Mesh:
    """The tray, tray frame: sides (2,) in m, upper surface at z = 0."""
    corners = np.array(((-1, -1), (1, -1), (1, 1), (-1, 1))) * np.asarray(size) / 2
    return prism(corners, -thickness, 0.0)


def corner_normals(mesh: Mesh) -> np.ndarray:
    """Outward unit normals (k, 3, 3) at the corners of every face: round where faces meet gently, else the face's."""
    corners = mesh.vertices[mesh.faces]
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    vertex = np.zeros_like(mesh.vertices)
    for corner in range(3):
        np.add.at(vertex, mesh.faces[:, corner], face)
    face, vertex = unit_vectors(face), unit_vectors(vertex)
    at_corners = vertex[mesh.faces]
    gentle = np.einsum("kci,ki->kc", at_corners, face) > _SMOOTH
    return np.where(gentle[..., None], at_corners, face[:, None])


def unit_vectors(vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) with length 1."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-30)


def creased(mesh: Mesh) -> Mesh:
    """The same surface with vertices of their own on both sides of its edges, so that light breaks there."""
    keys = np.column_stack([mesh.faces.reshape(-1), np.rint(corner_normals(mesh).reshape(-1, 3) * 1e3)])
    _, first, place = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return Mesh(mesh.vertices[mesh.faces.reshape(-1)[first]], place.reshape(-1, 3))


def _at_height(outline: np.ndarray, z: float) -> np.ndarray:
    return np.column_stack([outline, np.full(len(outline), z)])


def _strip(low: np.ndarray, high: np.ndarray) -> Mesh:
    """Band between two rings (n, 3); its vertices are its own, so that light breaks at its edges."""
    return Mesh(np.concatenate([low, high]), _faces_between_rings(len(low)))


def _faces_between_rings(count: int) -> np.ndarray:
    """Faces (2 count, 3) between a ring of `count` vertices and the next ones, which lie above it."""
    here = np.arange(count)
    after = (here + 1) % count
    return np.concatenate(
        [np.column_stack([here, after, after + count]), np.column_stack([here, after + count, here + count])]
    )


def _cap(ring: np.ndarray, *, downwards: bool = False) -> Mesh:
    """Fan over a ring (n, 3) from its mean."""
    count = len(ring)
    here = np.arange(count)
    after = (here + 1) % count
    fan = np.column_stack([here, after, np.full(count, count)])
    return Mesh(np.vstack([ring, ring.mean(axis=0)]), fan[:, ::-1] if downwards else fan)
