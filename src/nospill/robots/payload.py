"""The load at the flange: the tray's board and bodies that stand on it, for inverse dynamics."""

from __future__ import annotations

import numpy as np

from nospill.robots.dynamics import Load, load_of
from nospill.tray import Tray


def board_load(tray: Tray) -> Load:
    """Return the tray's board as a load: a thin plate, evenly heavy, in the plane of its surface."""
    along, across = (float(side) ** 2 / 12.0 for side in tray.size)
    inertia = tray.mass * np.diag([across, along, along + across])
    return load_of(tray.mass, tray.offset, inertia, rotation=_about_z(tray.yaw_on_flange))


def standing_load(
    tray: Tray,
    mass: float,
    *,
    centre: np.ndarray,
    inertia: np.ndarray,
    position: np.ndarray,
    yaw: float = 0.0,
) -> Load:
    """Return a body that stands on the tray as a load.

    Args:
        tray: the tray.
        mass: kg.
        centre: (3,) its centre of mass from the centre of its bottom, in its own axes, m.
        inertia: (3, 3) about its centre of mass in its own axes, kg m^2.
        position: (2,) centre of its bottom in the tray frame, m.
        yaw: turn of its axes about the tray's normal, rad.
    """
    on_flange, on_tray = _about_z(tray.yaw_on_flange), _about_z(yaw)
    in_tray = np.array([position[0], position[1], 0.0]) + on_tray @ centre
    return load_of(mass, tray.offset + on_flange @ in_tray, inertia, rotation=on_flange @ on_tray)


def _about_z(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
