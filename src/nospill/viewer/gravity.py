"""The arrow of apparent gravity on a tray: where it stands, what it looks like, which way it points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from nospill.drawing.geometry import Mesh, merge_meshes, tube, widest_outline
from nospill.scene.cargo import Cargo
from nospill.scene.tray import Tray

_SHAFT, _HEAD = 0.0022, 0.007
"""m; radius of the shaft, largest radius of the head."""
_SHORTEST, _LONGEST = 0.08, 0.14
"""m; length of the arrow, else as tall as the tallest object."""
_PLACES = 17
"""Places along each side that are compared."""


def free_spot(tray: Tray, cargo: Sequence[Cargo]) -> np.ndarray:
    """The place (2,), m, on a tray that is farthest from all objects and from the edges."""
    half = np.asarray(tray.size) / 2
    sides = [np.linspace(-end, end, _PLACES) for end in half]
    places = np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2)
    distance = np.min(half - np.abs(places), axis=1)
    for item in cargo:
        reach = float(np.max(np.linalg.norm(widest_outline(item.container), axis=1)))
        distance = np.minimum(distance, np.linalg.norm(places - item.position, axis=1) - reach)
    return places[int(np.argmax(distance))]


def arrow(cargo: Sequence[Cargo]) -> Mesh:
    """An arrow whose tip is at the origin and whose shaft goes along z, m."""
    tall = max((item.container.height for item in cargo), default=_SHORTEST)
    length = float(np.clip(tall, _SHORTEST, _LONGEST))
    up, neck = np.array([0.0, 0.0, 1.0]), 2.6 * _HEAD
    return merge_meshes(
        [
            tube(np.zeros(3), neck * up, (0.0002, _HEAD), sides=20),
            tube(neck * up, length * up, (_SHAFT, _SHAFT), sides=12),
        ]
    )


def against(specific_force: np.ndarray) -> np.ndarray:
    """Attitudes (m, 4), (w, x, y, z), that turn z to specific forces (m, 3), the shortest way."""
    up = specific_force / np.linalg.norm(specific_force, axis=1, keepdims=True)
    # From z to u about z x u: (1 + u_z, z x u) is twice the half angle's quaternion; a tray is never upside down.
    turned = np.column_stack([1.0 + up[:, 2], -up[:, 1], up[:, 0], np.zeros(len(up))])
    x, y, z, w = Rotation.from_quat(turned[:, [1, 2, 3, 0]]).as_quat().T
    return np.column_stack([w, x, y, z])
