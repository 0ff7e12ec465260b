"""The highest surface round the wall, and the instants after the end at which it is looked at."""

from __future__ import annotations

import numpy as np

from nospill.potential_flow.surface_modes import SurfaceModes
from nospill.scene.cargo import Cargo
from nospill.scene.containers.cylinder import Cylinder

AFTER_END = 4.0
"""s after the end in which the surface is looked at; what is left fades, if slowly, and in that time
its waves of four and more frequencies have met in nearly every phase."""
_STEP = 5e-3
"""s between the instants then; a mode of 6 Hz reaches 0.4 % more than its highest sample."""
INSTANTS = _STEP * np.arange(round(AFTER_END / _STEP) + 1)
"""s since the end, (m,)."""
_AT_ONCE = 256
"""Instants."""


def highest_on_wall(cargo: Cargo, modes: SurfaceModes, linear: np.ndarray, added: np.ndarray) -> np.ndarray:
    """Greatest heights (m,) round the wall of both, those along x and y (m, 2) and those of the modes (m, J)."""
    half = np.max(np.abs(modes.wall), axis=0)
    where: slice | np.ndarray = slice(None)
    if not isinstance(cargo.container, Cylinder):  # of a box the corners: no yaw mode is higher elsewhere
        where = np.flatnonzero(np.all(np.abs(modes.wall) > (1 - 1e-9) * half, axis=1))
    shapes = np.hstack([modes.wall[where] / half, modes.wall_shape[where]])
    heights = np.hstack([linear, added]).T
    highest = np.empty(heights.shape[1])
    for first in range(0, len(highest), _AT_ONCE):  # what stays in the cache is several times as fast
        part = slice(first, first + _AT_ONCE)
        highest[part] = np.max(shapes @ heights[:, part], axis=0)
    return highest
