"""Inertial loads on rigid bodies seen from a frame that accelerates and turns.

A body of mass m with its centre at c, velocity v of that centre and angular velocity w, all relative to the tray and in
tray axes, tray axes turning with Omega, Omega' and the tray's origin accelerating:

    acceleration of c in space = a_0 + Omega' x c + Omega x (Omega x c) + 2 Omega x v + v'

so a simulator that takes the tray for fixed needs the force

    F = -m [Omega' x c + Omega x (Omega x c) + 2 Omega x v]

on top of the uniform field -(a_0 + g), the negative of the specific force at the origin.

For the turning: the angular momentum about the centre is I (Omega + w), I being the inertia in tray axes, which turns
with the body, I' = [w] I - I [w]. Its rate in space, seen in axes that turn with Omega, is the torque:

    tau = d/dt [I (Omega + w)] + Omega x I (Omega + w)
        = I w' + w x I w  +  { w x I Omega - I (w x Omega) + I Omega' + Omega x I (Omega + w) }.

The first two terms are what the simulator does itself; the negative of the braces is the torque it has to be given.
"""

from __future__ import annotations

import numpy as np

_GENERATORS = np.zeros((3, 9))
for _row, _column, _axis in ((2, 1, 0), (0, 2, 1), (1, 0, 2)):
    _GENERATORS[_axis, 3 * _row + _column], _GENERATORS[_axis, 3 * _column + _row] = 1.0, -1.0


def skew(vector: np.ndarray) -> np.ndarray:
    """Matrix [a] with [a] b = a x b, (..., 3) -> (..., 3, 3)."""
    own = np.asarray(vector, dtype=float)
    return (own @ _GENERATORS).reshape(*own.shape, 3)


def carrying(spin: np.ndarray, spin_rate: np.ndarray) -> np.ndarray:
    """[Omega'] + [Omega]^2: matrix that takes a place fixed in the frame to its Euler and centripetal acceleration.

    Args:
        spin: (..., 3) Omega in the frame's axes, rad/s.
        spin_rate: (..., 3) Omega', rad/s^2.

    Returns:
        (..., 3, 3), 1/s^2.
    """
    turning = skew(spin)
    return skew(spin_rate) + turning @ turning


def inertial_forces(
    mass: np.ndarray, centre: np.ndarray, velocity: np.ndarray, *, turning: np.ndarray, carried: np.ndarray
) -> np.ndarray:
    """Euler, centrifugal and Coriolis force on each body, (n, 3) N, tray axes.

    Args:
        mass: (n,) kg.
        centre: (n, 3) centre of mass, m.
        velocity: (n, 3) of that centre relative to the tray, m/s.
        turning: (3, 3) `skew` of Omega.
        carried: (3, 3) `carrying`.
    """
    return -mass[:, None] * (centre @ carried.T + 2.0 * velocity @ turning.T)


def inertial_torques(
    inertia: np.ndarray, relative: np.ndarray, *, spin: np.ndarray, spin_rate: np.ndarray, turning: np.ndarray
) -> np.ndarray:
    """Torque about each body's centre, (n, 3) N m, tray axes.

    Args:
        inertia: (n, 3, 3) about the centre of mass in tray axes, kg m^2.
        relative: (n, 3) angular velocity relative to the tray, rad/s.
        spin: (3,) Omega, rad/s.
        spin_rate: (3,) Omega', rad/s^2.
        turning: (3, 3) `skew` of Omega.
    """
    crossing = skew(relative)
    momentum = inertia @ spin
    total = momentum + (inertia @ relative[:, :, None])[:, :, 0]
    against = (crossing @ momentum[:, :, None])[:, :, 0] + total @ turning.T + inertia @ spin_rate
    return (inertia @ (crossing @ spin)[:, :, None])[:, :, 0] - against
