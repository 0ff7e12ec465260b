"""How a tray turns about the vertical, from the twist of the flange and how it tilts."""

from __future__ import annotations

import numpy as np

from nospill.core.attitudes import yaw_of
from nospill.robots.kinematics.forward import ToolMotions


def yaw_motion(
    motion: ToolMotions, tilt: np.ndarray, rate: np.ndarray, change: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Yaw of R = Rz(yaw) Ry(theta_y) Rx(theta_x) with its rate and acceleration, (m,) each: rad, rad/s, rad/s^2.

    In base axes omega = (0, 0, yaw') + Rz (0, theta_y', 0) + Rz Ry (theta_x', 0, 0), whose third component is
    yaw' - sin(theta_y) theta_x'; the acceleration is from its derivative.

    Args:
        motion: of the tray at m samples.
        tilt: (m, 2) theta_x and theta_y, rad.
        rate: (m, 2) rad/s.
        change: (m, 2) rad/s^2.
    """
    sine, cosine = np.sin(tilt[:, 1]), np.cos(tilt[:, 1])
    turning = motion.angular_velocity[:, 2] + sine * rate[:, 0]
    turns = motion.angular_acceleration[:, 2] + cosine * rate[:, 1] * rate[:, 0] + sine * change[:, 0]
    return np.unwrap(yaw_of(motion.rotation)), turning, turns
