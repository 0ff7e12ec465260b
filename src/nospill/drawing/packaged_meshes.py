"""Meshes of an arm from a package that is installed, for pictures."""

from __future__ import annotations

from functools import lru_cache
from importlib import metadata
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from nospill.core.files import UnreadableError
from nospill.core.mesh_files import mesh_triangles
from nospill.drawing.geometry import Mesh, creased, merge_meshes, transform_mesh
from nospill.robots.robot import PackagedMeshes, Robot

_GRAIN = 0.005
"""m; side of the cubes of the grid of vertices."""


def packaged_meshes(robot: Robot) -> dict[str, Mesh] | None:
    """Meshes by the name of the link, in its frame, m; None where no installed package has them all."""
    return None if robot.meshes is None else _read(robot.meshes)


@lru_cache(maxsize=4)
def _read(wanted: PackagedMeshes) -> dict[str, Mesh] | None:
    try:
        place = Path(str(metadata.distribution(wanted.package).locate_file(wanted.folder)))
    except metadata.PackageNotFoundError:
        return None
    parts: dict[str, list[Mesh]] = {}
    for item in wanted.links:
        try:
            mesh = creased(coarse(Mesh(*mesh_triangles(place / item.file))))
        except UnreadableError:  # another version of the package; a picture of capsules beats none
            return None
        rotation = Rotation.from_euler("xyz", item.rpy).as_matrix()
        parts.setdefault(item.link, []).append(transform_mesh(mesh, np.array(item.position), rotation))
    return {link: merge_meshes(meshes) for link, meshes in parts.items()}


def coarse(mesh: Mesh) -> Mesh:
    """The same body with at most one vertex in every cube of a grid, the mean of those in it (Rossignac, Borrel 1993).

    What is smaller than a cube is not seen in a picture of an arm, and a file with every screw is heavy.
    """
    cells = np.floor(mesh.vertices / _GRAIN).astype(int)
    _, place, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    place = place.reshape(-1)
    vertices = np.stack([np.bincount(place, mesh.vertices[:, axis]) for axis in range(3)], axis=1) / count[:, None]
    faces = place[mesh.faces]
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return Mesh(vertices, faces[whole])
