"""Corners and triangles of meshes in STL files (binary or text) and OBJ files, and corners of their hulls."""

from __future__ import annotations

import os
import re
import struct
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

import numpy as np

from nospill.core.files import MissingFileError, UnreadableError

_T = TypeVar("_T", np.ndarray, tuple[np.ndarray, np.ndarray])

LARGEST_MESH = 10_000_000
"""Bytes."""
MESH_FORMATS = (".stl", ".obj")

_FACET = struct.Struct("<12fH")
_RECORD = np.dtype([("normal", "<3f4"), ("corners", "<9f4"), ("end", "<u2")])


def mesh_points(file: str | os.PathLike[str]) -> np.ndarray:
    """Corners (k, 3) of the triangles in a file, in its own unit.

    Raises:
        UnreadableError: it is missing, too large, of another format, or holds no numbers; the reason alone.
    """
    return _read(file, _obj_points, _stl_points)


def mesh_triangles(file: str | os.PathLike[str]) -> tuple[np.ndarray, np.ndarray]:
    """Corners (k, 3), in the file's own unit, each once, and triangles (n, 3) of their indices.

    Raises:
        UnreadableError: as for `mesh_points`, or a face names a corner that is not there; the reason alone.
    """
    corners, faces = _read(file, _obj_triangles, lambda data: (points := _stl_points(data), _in_threes(len(points))))
    own, place = np.unique(corners, axis=0, return_inverse=True)
    return own, place.reshape(-1)[faces]


def hull_corners(points: np.ndarray) -> np.ndarray:
    """The corners (n, 3) of the hull of points (k, 3).

    Raises:
        UnreadableError: they lie in a plane.
    """
    # imported here: slow to import, and needed for meshes only
    from scipy.spatial import ConvexHull, QhullError

    try:
        return points[ConvexHull(points).vertices]
    except QhullError:
        raise UnreadableError("holds no solid: its corners lie in a plane") from None


def _read(file: str | os.PathLike[str], obj: Callable[[str], _T], stl: Callable[[bytes], _T]) -> _T:
    """What is read from a file by the reader of its kind; both readers return corners, or corners and triangles."""
    path = Path(file)
    kind = path.suffix.lower()
    if kind not in MESH_FORMATS:
        raise UnreadableError("is no mesh that can be read; give an STL or OBJ file")
    try:
        if not path.is_file():
            raise MissingFileError("is not there")
        size = path.stat().st_size
        if size > LARGEST_MESH:
            raise UnreadableError(f"is larger than {LARGEST_MESH / 1e6:g} MB ({size / 1e6:.1f} MB); simplify it")
        data = path.read_bytes()
        mesh = obj(data.decode()) if kind == ".obj" else stl(data)
    except OSError as error:
        raise UnreadableError(f"cannot be read: {error.strerror or error}") from None
    except ValueError as error:  # a NUL character in the path, bytes that are no text, words that are no numbers
        raise UnreadableError(f"cannot be read: {error}") from None
    points = mesh[0] if isinstance(mesh, tuple) else np.asarray(mesh)
    if len(points) < 4 or not np.all(np.isfinite(points)):
        raise UnreadableError("holds no solid")
    return mesh


def _stl_points(data: bytes) -> np.ndarray:
    count = int.from_bytes(data[80:84], "little")
    if len(data) >= 84 and len(data) == 84 + count * _FACET.size:
        return np.frombuffer(data, _RECORD, offset=84)["corners"].reshape(-1, 3).astype(float)
    return _rows(re.findall(r"^\s*vertex\s+(.+)$", data.decode("ascii"), re.MULTILINE))


def _obj_points(text: str) -> np.ndarray:
    return _rows(re.findall(r"^\s*v\s+(.+)$", text, re.MULTILINE))


def _obj_triangles(text: str) -> tuple[np.ndarray, np.ndarray]:
    points, fans = _obj_points(text), []
    for line in re.findall(r"^\s*f\s+(.+)$", text, re.MULTILINE):
        corners = [int(word.partition("/")[0]) for word in line.split()]
        fans += [(corners[0], *pair) for pair in pairwise(corners[1:])]
    faces = np.array(fans, dtype=int).reshape(-1, 3)
    # the first corner is number 1; a negative number counts back from the last one
    faces = np.where(faces > 0, faces - 1, faces + len(points))
    if not len(faces) or faces.min() < 0 or faces.max() >= len(points):
        raise ValueError("its faces name corners that are not there")
    return points, faces


def _in_threes(count: int) -> np.ndarray:
    return np.arange(count).reshape(-1, 3)


def _rows(lines: list[str]) -> np.ndarray:
    return np.array([[float(word) for word in line.split()[:3]] for line in lines]).reshape(-1, 3)
