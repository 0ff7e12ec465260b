"""What is around the arm: obstacles, places that the tray passes, edges of the regions that it stays in."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from nospill.core.shapes import box_shape
from nospill.drawing.colours import GREEN, GREY, rgb
from nospill.drawing.obstacles import OBSTACLE, obstacle_mesh
from nospill.robots.description.urdf_tree import about_axis
from nospill.scene.places import Region
from nospill.scene.scene import Scene
from nospill.viewer.nodes import add_mesh

if TYPE_CHECKING:
    import viser

_OPACITY, _PLACE_OPACITY = 0.5, 0.25
"""Of obstacles and of places, so that nothing is hidden behind them."""


def add_surroundings(scene: viser.SceneApi, root: str, drawn: Scene) -> None:
    """Add it below a new node; the ground is drawn in any case."""
    for node in (root, f"{root}/obstacles", f"{root}/via", f"{root}/regions"):
        scene.add_frame(node, show_axes=False)
    for item in drawn.obstacles:
        mesh = obstacle_mesh(item)
        if mesh is not None:
            look = {"color": OBSTACLE, "opacity": _OPACITY, "flat_shading": item.shape.kind == "box"}
            add_mesh(scene, f"{root}/obstacles/{item.name}", mesh, side="double", **look)
    for place in drawn.motion.via:
        scene.add_icosphere(
            f"{root}/via/{place.name}",
            radius=place.radius,
            color=rgb(GREEN),
            opacity=_PLACE_OPACITY,
            position=place.position,
            cast_shadow=False,
        )
    for region in drawn.regions:
        edges = region_edges(region).astype(np.float32)
        scene.add_line_segments(
            f"{root}/regions/{region.name}", edges, np.array(rgb(GREY)), thickness=1.0, thickness_units="screen"
        )


def region_edges(region: Region) -> np.ndarray:
    """The twelve edges of a region (12, 2, 3), m."""
    corners = box_shape(region.size).points
    pairs = [(a, b) for a, b in combinations(corners, 2) if np.count_nonzero(a != b) == 1]
    return np.array(pairs) @ about_axis((0.0, 0.0, 1.0), region.yaw).T + region.position
