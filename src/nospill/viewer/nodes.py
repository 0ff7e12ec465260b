"""Nodes of a viser scene from the meshes of films."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nospill.drawing.geometry import Mesh

if TYPE_CHECKING:
    import viser


def add_mesh(scene: viser.SceneApi, name: str, mesh: Mesh, **look: object) -> viser.MeshHandle:
    """Add a mesh, m, below its parent; `look` as in `add_mesh_simple`."""
    return scene.add_mesh_simple(name, mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32), **look)  # type: ignore[arg-type]
