"""The highest surface round the wall, and the instants after the end at which it is looked at."""

from __future__ import annotations

import numpy as np

from nospill.potential_flow import rows_at
from nospill.potential_flow.surface_modes import SurfaceModes
from nospill.scene.cargo import Cargo, Filling
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.sloshing.modes import wall_gains

AFTER_END = 4.0
"""s after the end in which the surface is looked at; what is left fades, if slowly, and in that time
its waves of four and more frequencies have met in nearly every phase."""
_STEP = 5e-3
"""s between the instants then; a mode of 6 Hz reaches 0.4 % more than its highest sample."""
INSTANTS = _STEP * np.arange(round(AFTER_END / _STEP) + 1)
"""s since the end, (m,)."""
_AT_ONCE = 256
"""Instants."""


def of_second_order(cargo: Cargo, modes: SurfaceModes) -> np.ndarray:
    """Places on the wall at which heights of second order are looked at: of a box the corners.

    No yaw mode is higher elsewhere; what two waves drive may be, by what the flow in full shows.
    """
    if isinstance(cargo.container, Cylinder):
        return np.arange(len(modes.wall))
    half = np.max(np.abs(modes.wall), axis=0)
    return np.flatnonzero(np.all(np.abs(modes.wall) > (1 - 1e-9) * half, axis=1))


def highest_on_wall(
    modes: SurfaceModes, linear: np.ndarray, added: np.ndarray, where: np.ndarray | slice = slice(None)
) -> np.ndarray:
    """Greatest heights (m,) round the wall of both, those along x and y (m, 2) and those of the modes (m, J).

    `where` are places of the wall, all of them by default.
    """
    half = np.max(np.abs(modes.wall), axis=0)
    moved = np.flatnonzero(np.any(added, axis=0))  # of a cup's modes of second order six of ten
    shapes = np.hstack([modes.wall[where] / half, modes.wall_shape[where][:, moved]])
    heights = np.vstack([linear.T, added.T[moved]])
    highest = np.empty(heights.shape[1])
    for first in range(0, len(highest), _AT_ONCE):  # what stays in the cache is several times as fast
        part = slice(first, first + _AT_ONCE)
        highest[part] = np.max(shapes @ heights[:, part], axis=0)
    return highest


def linear_heights(filling: Filling, body: np.ndarray, displacement: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Heights along x and y (m, 2), and what yaw modes add at most (m,), as `laws.slosh.height` has them."""
    gains = wall_gains(filling.oscillators)
    force = rows_at(body, np.array([0.0, 0.0, filling.liquid_height]))[6:]
    linear = displacement @ gains[:2].T - filling.modes.static_correction * (force[:2] / force[2]).T
    if not np.any(gains[2:]) and not (filling.turns and filling.modes.yaw is not None):
        return linear, np.zeros(len(linear))
    yaw = displacement @ gains[2:].T
    if filling.turns and filling.modes.yaw is not None:
        yaw = yaw - np.outer(body[5] / force[2], filling.modes.yaw.static_correction)
    return linear, np.max(np.abs(yaw), axis=1)
