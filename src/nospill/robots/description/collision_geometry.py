"""Capsules of an arm from the collision geometry of its URDF: boxes, cylinders, spheres, capsules and meshes.

Every element of a link gets the capsule about it with the smallest volume of those tried. Meshes are read from STL and
OBJ files; of others, and of files that are not there, the link is left to the estimate along the chain.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from nospill.core.files import UnreadableError
from nospill.core.mesh_files import hull_corners, mesh_points
from nospill.core.shapes import box_shape, cylinder_shape, polyhedron
from nospill.robots.description.urdf_tree import rotation_of
from nospill.robots.robot import LinkCapsule

_WIDENINGS = (1.0, 1.03, 1.08, 1.15, 1.25)
"""Radii that are tried, in parts of the least one about an axis: a wider capsule may be a shorter one."""
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class CollisionCapsules:
    """What a URDF says of the space its links fill.

    Attributes:
        capsules: in the frames of their links.
        unread: links with an element that could not be read, each with the reason.
    """

    capsules: tuple[LinkCapsule, ...]
    unread: dict[str, str]


class _GeometryError(Exception):
    """An element that gives no points; says why."""


def collision_capsules(text: str, folder: Path) -> CollisionCapsules:
    """Read the collision elements of URDF text that `urdf_tree.read_tree` accepts.

    Args:
        text: of the file.
        folder: in which relative mesh files are looked up, and above which packages are.
    """
    found: list[LinkCapsule] = []
    unread: dict[str, str] = {}
    for link in ElementTree.fromstring(text.strip()).findall("link"):
        name = link.get("name", "")
        try:
            own = [_capsule(name, element, folder) for element in link.findall("collision")]
        except _GeometryError as error:
            unread[name] = str(error)
        else:
            found += own
    return CollisionCapsules(tuple(found), unread)


def enclosing_capsule(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """A small capsule about points (k, 3), m: both ends (3,) of its segment, m, and its radius, m.

    About each of six axes (the points' principal ones and those of their frame) the smallest circle about what is seen
    along it gives the line; the segment is as short as the radius allows. The smallest volume is taken.
    """
    principal = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]
    best: tuple[float, np.ndarray, np.ndarray, float] | None = None
    for axis in (*principal, *np.eye(3)):
        along = points @ axis
        across = points - along[:, None] * axis
        centre, radius = _circle(across)
        off = np.linalg.norm(across - centre, axis=1)
        for widening in _WIDENINGS:
            room = np.sqrt(np.maximum((widening * radius) ** 2 - off**2, 0.0))
            low, high = float(np.min(along + room)), float(np.max(along - room))
            if low > high:
                low = high = (low + high) / 2.0
            start, end = centre + low * axis, centre + high * axis
            own = float(np.max(_segment_distance(points, start, end))) * (1.0 + _ROUNDING) + _ROUNDING
            volume = own**2 * (high - low + 4.0 / 3.0 * own)
            if best is None or volume < best[0]:
                best = (volume, start, end, own)
    assert best is not None  # six axes were tried
    return best[1], best[2], best[3]


def _circle(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Centre and radius of nearly the smallest ball about points (Badoiu and Clarkson 2003): 1 % in a hundred steps."""
    centre = points.mean(axis=0)
    for step in range(1, 200):
        gaps = points - centre
        farthest = int(np.argmax(np.einsum("ij,ij->i", gaps, gaps)))
        centre = centre + gaps[farthest] / (step + 1)
    return centre, float(np.max(np.linalg.norm(points - centre, axis=1)))


def _segment_distance(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    way = end - start
    share = np.clip((points - start) @ way / max(float(way @ way), 1e-18), 0.0, 1.0)
    return np.linalg.norm(points - start - share[:, None] * way, axis=1)


def _capsule(link: str, element: ElementTree.Element, folder: Path) -> LinkCapsule:
    origin = element.find("origin")
    place = _numbers(None if origin is None else origin.get("xyz"), 3, (0.0, 0.0, 0.0))
    turn = rotation_of(tuple(_numbers(None if origin is None else origin.get("rpy"), 3, (0.0, 0.0, 0.0))))
    geometry = element.find("geometry")
    shape = None if geometry is None or not len(geometry) else geometry[0]
    if shape is None:
        raise _GeometryError("a collision element without geometry")
    if shape.tag == "sphere":
        start = end = np.zeros(3)
        radius = _numbers(shape.get("radius"), 1)[0]
    elif shape.tag == "capsule":
        radius, half = _numbers(shape.get("radius"), 1)[0], _numbers(shape.get("length"), 1)[0] / 2.0
        start, end = np.array([0.0, 0.0, -half]), np.array([0.0, 0.0, half])
    else:
        start, end, radius = enclosing_capsule(_points(shape, folder))
    if not radius > 0.0:
        raise _GeometryError(f"a <{shape.tag}> of no size")
    ends = [tuple((place + turn @ point).tolist()) for point in (start, end)]
    return LinkCapsule(link, ends[0], ends[1], float(radius))


def _points(shape: ElementTree.Element, folder: Path) -> np.ndarray:
    if shape.tag == "box":
        return box_shape(_numbers(shape.get("size"), 3).tolist()).points
    if shape.tag == "cylinder":
        radius, length = (_numbers(shape.get(key), 1)[0] for key in ("radius", "length"))
        return polyhedron(cylinder_shape(radius, length))
    if shape.tag == "mesh":
        scale = _numbers(shape.get("scale"), 3, (1.0, 1.0, 1.0))
        name = shape.get("filename", "")
        try:
            return hull_corners(mesh_points(_mesh_file(name, folder))) * scale
        except UnreadableError as error:
            raise _GeometryError(f"mesh file {name[:80]!r}, which {error}") from None
    raise _GeometryError(f"a <{shape.tag[:20]}>, which is not known")


def _mesh_file(name: str, folder: Path) -> Path:
    package = re.match(r"(?:package|model)://(.*)", name)
    if package:
        places = [above / package[1] for above in (folder.absolute(), *folder.absolute().parents)]
    else:
        places = [folder / name.removeprefix("file://")]
    for place in places:
        try:
            if place.is_file():
                return place
        except (OSError, ValueError):  # ValueError: a NUL character in the path
            break
    return places[0]


def _numbers(text: str | None, count: int, standard: tuple[float, ...] | None = None) -> np.ndarray:
    try:
        values = np.array([float(word) for word in (text or "").split()]) if text is not None else np.array(standard)
    except ValueError:
        values = np.empty(0)
    if values.shape != (count,) or not np.all(np.abs(values) < 1e6):
        raise _GeometryError(f"{str(text)[:40]!r} where {count} numbers must stand")
    return values.astype(float)
