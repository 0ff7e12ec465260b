"""Where the tray is and how it moves, from the path parameter and the tilt angles."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from nospill.core.frames import SX, FrameMotion, tray_rates, tray_rotation
from nospill.laws.sample import tray_motion
from nospill.laws.structure import Freedom
from nospill.transcription.layout import IntegratorChain
from nospill.transcription.lifted_variables import LiftedVariables
from nospill.transcription.path_expression import PathPiece


@dataclass(frozen=True, slots=True)
class TrayState:
    """Pose and motion of the tray frame.

    Attributes:
        position: (3, 1) of its origin, base axes, m.
        velocity: (3, 1) of its origin, base axes, m/s.
        rotation: (3, 3), tray to base.
        motion: angular velocity, angular acceleration and specific force in tray axes.
    """

    position: SX
    velocity: SX
    rotation: SX
    motion: FrameMotion

    def lifted(self, variables: LiftedVariables) -> TrayState:
        """The same with every entry lifted."""
        motion = self.motion
        return TrayState(
            variables.lift(self.position),
            variables.lift(self.velocity),
            variables.lift(self.rotation),
            FrameMotion(
                variables.lift(motion.angular_velocity),
                variables.lift(motion.angular_acceleration),
                variables.lift(motion.specific_force),
            ),
        )

    def acceleration(self, gravity: SX) -> tuple[SX, SX]:
        """Acceleration (3, 1) of the origin, m/s^2, and angular acceleration (3, 1), rad/s^2, in base axes."""
        weight = ca.vertcat(0, 0, gravity)
        return self.rotation @ self.motion.specific_force - weight, self.rotation @ self.motion.angular_acceleration


def tray_state(piece: PathPiece, chains: tuple[IntegratorChain, ...], *, freedom: Freedom, gravity: SX) -> TrayState:
    """The tray frame's pose and motion from s and what is free, in the order of `Layout`; the path's `piece` at s."""
    if freedom.by_joints:
        return _carried(piece.of_tray, chains[0], gravity)
    s, speed, acceleration = chains[0]
    value, first, second = piece.at(s)
    rate, change = first * speed, second * speed**2 + first * acceleration
    further, none = iter(chains[1:]), (SX(0), SX(0), SX(0))
    theta_x, theta_y = (next(further), next(further)) if freedom.tilt else (none, none)
    beside = [next(further) for _ in range(3)] if freedom.offset else [none] * 3
    turn = next(further) if freedom.yaw else none
    value, rate, change = (
        along + ca.vertcat(*[chain[order] for chain in (*beside, turn)])
        for order, along in enumerate((value, rate, change))
    )
    rotation = tray_rotation(value[3], theta_y[0], theta_x[0])
    omega, alpha = tray_rates((value[3], rate[3], change[3]), theta_y, theta_x)
    motion = tray_motion(rotation, change[:3], omega, alpha, gravity)
    return TrayState(value[:3], rate[:3], rotation, motion)


def _carried(piece: PathPiece, chain: IntegratorChain, gravity: SX) -> TrayState:
    """The tray that the joints carry, from polynomials of its position r and rotation R.

    With w = vee(R^T R') the angular velocity by s in tray axes, omega = w s' and alpha = w s'' + w' s'^2.
    """
    s, speed, acceleration = chain
    value, first, second = piece.at(s)
    change = second[:3] * speed**2 + first[:3] * acceleration
    rotation, slope, bend = (ca.reshape(part[3:], 3, 3).T for part in (value, first, second))
    turning, rate = [], []
    for i, j in ((2, 1), (0, 2), (1, 0)):
        turning.append(ca.dot(rotation[:, i], slope[:, j]))
        rate.append(ca.dot(rotation[:, i], bend[:, j]) + ca.dot(slope[:, i], slope[:, j]))
    w, w_slope = ca.vertcat(*turning), ca.vertcat(*rate)
    omega, alpha = w * speed, w * acceleration + w_slope * speed**2
    motion = tray_motion(rotation, change, omega, alpha, gravity)
    return TrayState(value[:3], first[:3] * speed, rotation, motion)
