"""How arm and tray move when a motion begins that goes on from another one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.core.attitudes import matrices, tray_quaternions

_STILL = ((0.0, 0.0, 0.0),) * 3


@dataclass(frozen=True, slots=True)
class InitialState:
    """State of the tray about its path, and of the joints that carry it there, at one instant.

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
        offset: from the path at s to the tray's centre, base axes, with its first and second derivative: (3,) each, m,
            m/s and m/s^2; zero where the tray keeps to its path.
        turn: yaw of the tray against that of the path at s, with its derivatives, rad, rad/s and rad/s^2.
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
    offset: tuple[tuple[float, float, float], ...] = _STILL
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def joints(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Positions, speeds and accelerations (n,)."""
        return np.array(self.joint_position), np.array(self.joint_speed), np.array(self.joint_acceleration)

    @property
    def along(self) -> np.ndarray:
        """Value, rate and acceleration (1, 3) of s."""
        return np.array([[self.s, self.s_rate, self.s_acceleration]])

    @property
    def tilts(self) -> np.ndarray:
        """Value, rate and acceleration (2, 3) of theta_x and theta_y."""
        return np.column_stack([self.tilt, self.tilt_rate, self.tilt_acceleration])

    def chains(self, *, tilt: bool, offset: bool, yaw: bool) -> np.ndarray:
        """Value, rate and acceleration (c, 3) of s and of what is free beside it: tilt (2), offset (3), yaw (1)."""
        parts = ((self.tilts, tilt), (np.array(self.offset).T, offset), (np.array([self.turn]), yaw))
        return np.vstack([self.along, *(part for part, is_free in parts if is_free)])

    def attitude(self, yaw: float) -> np.ndarray:
        """Rotation (3, 3) of the tray at a yaw in rad, tray to base."""
        theta_x, theta_y = self.tilt
        return matrices(tray_quaternions(np.array([yaw]), np.array([theta_y]), np.array([theta_x])))[0]
