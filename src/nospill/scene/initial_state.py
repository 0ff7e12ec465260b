"""How arm and tray move when a motion begins that goes on from another one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.core.attitudes import matrices, tray_quaternions


@dataclass(frozen=True, slots=True)
class InitialState:
    """State of the tray on its path, and of the joints that carry it there, at one instant.

    The swing of the liquids at that instant is the objects' own, `Filling.initial_swing`.

    Attributes:
        s: path parameter, from 0 to below 1.
        s_rate: 1/s, zero or more.
        s_acceleration: 1/s^2.
        tilt: theta_x and theta_y, rad.
        tilt_rate: rad/s.
        tilt_acceleration: rad/s^2.
        joint_position: (n,) rad.
        joint_speed: (n,) rad/s.
        joint_acceleration: (n,) rad/s^2.
    """

    s: float
    s_rate: float
    s_acceleration: float
    tilt: tuple[float, float]
    tilt_rate: tuple[float, float]
    tilt_acceleration: tuple[float, float]
    joint_position: tuple[float, ...]
    joint_speed: tuple[float, ...]
    joint_acceleration: tuple[float, ...]

    @property
    def joints(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Positions, speeds and accelerations (n,)."""
        return np.array(self.joint_position), np.array(self.joint_speed), np.array(self.joint_acceleration)

    @property
    def chains(self) -> np.ndarray:
        """Value, rate and acceleration (3, 3) of s, theta_x and theta_y."""
        along = [self.s, self.s_rate, self.s_acceleration]
        return np.array([along, *np.column_stack([self.tilt, self.tilt_rate, self.tilt_acceleration]).tolist()])

    def attitude(self, yaw: float) -> np.ndarray:
        """Rotation (3, 3) of the tray at a yaw in rad, tray to base."""
        theta_x, theta_y = self.tilt
        return matrices(tray_quaternions(np.array([yaw]), np.array([theta_y]), np.array([theta_x])))[0]
