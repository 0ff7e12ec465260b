"""Where about its path a tray is that joints in motion carry: place, offset and turn, with their rates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from nospill.core.attitudes import angles_between
from nospill.paths.path import Path
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.yaw_motion import yaw_motion
from nospill.robots.robot import Robot
from nospill.robots.tool import Tool
from nospill.scene.initial_state import InitialState
from nospill.scene.scene import MotionRules

_PLACES, _FINER = 1001, 3
"""Places of a path at which the nearest is looked for, and how often finer about it."""
_LATEST = 0.999
"""Path parameter; nearer to its end no motion goes on."""


def tray_of(state: InitialState, robot: Robot, tool: Tool) -> np.ndarray:
    """x, y, z (m) and yaw (rad) of the tray that the joints carry, with first and second derivative (3, 4)."""
    motion = kinematics(robot).motions(*(part[None] for part in state.joints), tool=tool)
    tilt, rate, change = (np.array([part]) for part in (state.tilt, state.tilt_rate, state.tilt_acceleration))
    yaw = yaw_motion(motion, tilt, rate, change)
    points = (motion.position, motion.velocity, motion.acceleration)
    return np.array([np.append(point[0], angle[0]) for point, angle in zip(points, yaw, strict=True)])


def state_about(
    state: InitialState, is_placed: bool, robot: Robot, tool: Tool, path: Path, rules: MotionRules
) -> tuple[InitialState, list[float]]:
    """The state with where the tray is about a path, and how far it is from there where it may not leave it.

    Args:
        state: with the joints, the tilt, and the place on the path where that is stated.
        is_placed: whether it is; else it is the place nearest to the tray's centre.
        robot: whose joints they are.
        tool: the tray in the flange's frame.
        path: of the tray.
        rules: whether the tray's centre may leave the path, and whether it may turn on it.

    Returns:
        The state; distances in m or rad, m/s or rad/s, m/s^2 or rad/s^2.
    """
    tray = tray_of(state, robot, tool)
    if not is_placed:
        s, rate, change = _nearest(path, tray)
        state = replace(state, s=s, s_rate=rate, s_acceleration=change)
    beside = tray - _on_path(path, state)
    beside[0, 3] = np.remainder(beside[0, 3] + np.pi, 2.0 * np.pi) - np.pi
    offset_free = rules.corridor is not None
    gaps = np.zeros(3) if offset_free else np.linalg.norm(beside[:, :3], axis=1)
    if offset_free:
        x, y, z = ((float(a), float(b), float(c)) for a, b, c in beside[:, :3])
        state = replace(state, offset=(x, y, z))
    if rules.yaw_free:
        turn, rate, change = beside[:, 3].tolist()
        state = replace(state, turn=(turn, rate, change))
    else:
        gaps = np.maximum(gaps, np.abs(beside[:, 3]))
    return state, gaps.tolist()


def gaps_of_attitude(state: InitialState, robot: Robot, tool: Tool) -> list[float]:
    """How far the tray's attitude, its angular velocity and acceleration are from those of its yaw and stated tilt."""
    tray = kinematics(robot).motions(*(part[None] for part in state.joints), tool=tool)
    yaw = tray_of(state, robot, tool)[:, 3]
    turn = float(angles_between(tray.rotation, state.attitude(float(yaw[0]))[None])[0])
    theta_x, theta_y = state.tilts
    omega, alpha = _turning(yaw, theta_y, theta_x)
    own = tray.rotation[0].T
    return [
        turn,
        float(np.linalg.norm(own @ tray.angular_velocity[0] - omega)),
        float(np.linalg.norm(own @ tray.angular_acceleration[0] - alpha)),
    ]


def _on_path(path: Path, state: InitialState) -> np.ndarray:
    """Pose of the path at the state's place, with first and second derivative by time (3, 4)."""
    pose, first, second = (path.derivative([state.s], order)[0] for order in range(3))
    return np.array([pose, first * state.s_rate, second * state.s_rate**2 + first * state.s_acceleration])


def _nearest(path: Path, tray: np.ndarray) -> tuple[float, float, float]:
    """Path parameter of the place nearest to a tray (3, 4), with the rates that take as much of its motion as can be.

    A tray that moves back along the path stands still on it: progress never falls.
    """
    low, high = 0.0, _LATEST
    s = low
    for _ in range(_FINER):
        places = np.linspace(low, high, _PLACES)
        s = float(places[np.argmin(np.linalg.norm(path.at(places)[:, :3] - tray[0, :3], axis=1))])
        step = places[1] - places[0]
        low, high = max(0.0, s - step), min(_LATEST, s + step)
    first, second = (path.derivative([s], order)[0, :3] for order in (1, 2))
    size = float(first @ first)
    if size <= 0.0:  # it only turns here
        return s, 0.0, 0.0
    rate = max(0.0, float(tray[1, :3] @ first) / size)
    change = float((tray[2, :3] - second * rate**2) @ first) / size
    return s, rate, change if rate > 0.0 else max(0.0, change)


def _turning(*angles: Sequence[float] | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angular velocity and acceleration (3,) in tray axes, from yaw, theta_y and theta_x, each with its rates."""
    import casadi as ca

    from nospill.core.frames import SX, tray_rates

    yaw, theta_y, theta_x = ((SX(float(a)), SX(float(b)), SX(float(c))) for a, b, c in angles)
    omega, alpha = (np.array(ca.evalf(part)).ravel() for part in tray_rates(yaw, theta_y, theta_x))
    return omega, alpha
