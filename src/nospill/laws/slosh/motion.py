"""Equation of motion of a sloshing liquid in general rigid motion, one oscillator at a time.

The modal mass slides on a paraboloid of curvature P about the container's axis. With q its horizontal displacement (one
or two coordinates), rho = (D q, H + P |q|^2 / 2) its place in the container frame and a the apparent acceleration at
rho (specific force, Euler, centrifugal, Coriolis and relative terms), the equation is

    J^T a + (kappa - P) b_z q + damping = 0,  J = d rho / d q,

b_z the specific force along the axis at the place of rest (0, 0, H), kappa = omega^2/g the stiffness. The first mode's
paraboloid is its spring, P = kappa; with f = a - rho'' its equation reads for a circular cup

    (I + P^2 q q^T) q'' = -f_xy - P f_z q - P^2 |q'|^2 q - 2 zeta omega (q' + P^2 (q.q') q),

on a level tray the published 4-D equation. The others are flat, P = 0, and linear in q, as potential theory gives them:

    q'' = -f_xy - kappa b_z q - 2 zeta omega q'.

The stiffness comes from the apparent gravity along the axis, so kappa is free of g. Surface tension, where it counts,
adds a spring tau q that no gravity changes.

A yaw mode of a box is flat too; its mass slides along a circle of the radius L about the axis, where the container
turns with alpha_z [`scene.sloshing.yaw_modes`]:

    q'' = -L alpha_z - kappa b_z q - 2 zeta omega q'.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from nospill.core.frames import SX, FrameMotion
from nospill.laws.parameters import ObjectNumbers, OscillatorNumbers
from nospill.laws.structure import YAW_AXES, ObjectStructure


@dataclass(frozen=True, slots=True)
class OscillatorState:
    """Displacement (k, 1) m, velocity m/s, acceleration m/s^2 of a modal mass along its directions, container axes."""

    displacement: SX
    velocity: SX
    acceleration: SX


def horizontal(directions: tuple[int, ...], coordinates: SX) -> SX:
    """D q: the coordinates as a horizontal vector, shape (2, 1); nothing of a yaw mode, whose middle stays."""
    full = SX.zeros(2)
    if directions == YAW_AXES:
        return full
    for index, axis in enumerate(directions):
        full[axis] = coordinates[index]
    return full


def modal_place(oscillator: OscillatorNumbers, directions: tuple[int, ...], state: OscillatorState) -> SX:
    """rho, place of the modal mass in the container frame, shape (3, 1), m."""
    q = state.displacement
    side, rise = horizontal(directions, q), oscillator.curvature / 2 * ca.dot(q, q)
    return ca.vertcat(side + _axis(oscillator), oscillator.height + rise)


def _axis(oscillator: OscillatorNumbers) -> SX:
    """Where the axis stands about which the mass swings, (2, 1), m: in the middle, but for what a carrier feels."""
    place = SX(oscillator.place)
    return place if place.numel() == 2 else SX.zeros(2)


def apparent_acceleration(
    oscillator: OscillatorNumbers, directions: tuple[int, ...], motion: FrameMotion, state: OscillatorState
) -> SX:
    """Acceleration of the modal mass less gravity, container axes, shape (3, 1), m/s^2.

    f + alpha x rho + omega x (omega x rho) + 2 omega x rho' + rho'', f the specific force at the bottom centre; times
    the modal mass it is the force the container exerts on it.
    """
    q, qd, qdd = state.displacement, state.velocity, state.acceleration
    curvature = oscillator.curvature
    place = modal_place(oscillator, directions, state)
    speed = ca.vertcat(horizontal(directions, qd), curvature * ca.dot(q, qd))
    relative = ca.vertcat(horizontal(directions, qdd), curvature * (ca.dot(qd, qd) + ca.dot(q, qdd)))
    return motion.at(place).specific_force + 2 * ca.cross(motion.angular_velocity, speed) + relative


def yaw_acceleration(oscillator: OscillatorNumbers, motion: FrameMotion, state: OscillatorState) -> SX:
    """Acceleration of a yaw mode's mass along its circle, q'' + L alpha_z, scalar, m/s^2.

    Times the mass and L it is the moment about the axis that the container exerts on it.
    """
    return state.acceleration + oscillator.arm * motion.angular_acceleration[2]


def motion_residual(
    oscillator: OscillatorNumbers,
    directions: tuple[int, ...],
    motion: FrameMotion,
    state: OscillatorState,
    *,
    damp_against_spin: bool,
) -> SX:
    """J^T a + (kappa - P) b_z q + damping, shape (k, 1), m/s^2; zero on a motion, linear in the acceleration.

    Args:
        oscillator: its numbers.
        directions: horizontal axes it moves along, or `YAW_AXES`.
        motion: of the container frame, in container axes.
        state: displacement, velocity, acceleration.
        damp_against_spin: measure the damping velocity against axes that do not spin about the cup's axis, as the
            published equation does, instead of against the wall.
    """
    q, qd = state.displacement, state.velocity
    curvature = oscillator.curvature
    apparent = apparent_acceleration(oscillator, directions, motion, state)
    if directions == YAW_AXES:
        along = yaw_acceleration(oscillator, motion, state)
    else:
        along = ca.vertcat(*[apparent[axis] for axis in directions])
    slip_rate = qd
    if damp_against_spin and len(directions) == 2:
        slip_rate = qd + motion.angular_velocity[2] * ca.vertcat(-q[1], q[0])
    damping = 2 * oscillator.damping * oscillator.frequency
    place_of_rest = ca.vertcat(_axis(oscillator), oscillator.height)
    axial = motion.at(place_of_rest).specific_force[2]
    spring = curvature * q * apparent[2] + (oscillator.stiffness - curvature) * axial * q
    tension = SX(oscillator.tension)
    if tension.numel():
        spring += tension * q
    return along + spring + damping * (slip_rate + curvature**2 * ca.dot(q, slip_rate) * q)


def modal_acceleration(
    oscillator: OscillatorNumbers,
    directions: tuple[int, ...],
    motion: FrameMotion,
    displacement: SX,
    velocity: SX,
    *,
    damp_against_spin: bool,
) -> SX:
    """Q'' solved from `motion_residual` = 0, shape (k, 1), m/s^2.

    The residual is (I + P^2 q q^T) q'' + bias, inverted in closed form (Sherman and Morrison).
    """
    still = OscillatorState(displacement, velocity, SX.zeros(displacement.shape[0]))
    bias = motion_residual(oscillator, directions, motion, still, damp_against_spin=damp_against_spin)
    stiff = oscillator.curvature**2
    correction = stiff * ca.dot(displacement, bias) / (1 + stiff * ca.dot(displacement, displacement))
    return -(bias - correction * displacement)


def modal_accelerations(
    structure: ObjectStructure,
    numbers: ObjectNumbers,
    motion: FrameMotion,
    displacement: SX,
    velocity: SX,
    *,
    damp_against_spin: bool,
) -> SX:
    """Accelerations of all modal masses of one container, (k, 1) m/s^2, from its stacked coordinates (k, 1)."""
    accelerations = [
        modal_acceleration(
            oscillator, directions, motion, displacement[mode], velocity[mode], damp_against_spin=damp_against_spin
        )
        for oscillator, directions, mode in zip(
            numbers.oscillators, structure.oscillators, structure.oscillator_slices, strict=True
        )
    ]
    return ca.vertcat(*accelerations)
