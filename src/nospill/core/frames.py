"""Rotations and moving frames, as CasADi expressions.

Conventions: a rotation R_ab maps components in b into components in a. The tray's attitude is
R = Rz(yaw) Ry(theta_y) Rx(theta_x) (turn about the fixed z last). Rates and accelerations are given in the moving
frame's own axes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca

SX = ca.SX

VERTICAL = SX(ca.DM([0, 0, 1]))
"""e_z, in base axes and in those of a level tray."""


def vector(*components: SX | float) -> SX:
    """Column of the given scalars, shape (n, 1)."""
    return ca.vertcat(*[SX(component) for component in components])


def rotation_z(angle: SX | float) -> SX:
    """Rz(angle), shape (3, 3), angle in rad."""
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1))


def rotation_y(angle: SX | float) -> SX:
    """Ry(angle), shape (3, 3), angle in rad."""
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(ca.horzcat(c, 0, s), ca.horzcat(0, 1, 0), ca.horzcat(-s, 0, c))


def rotation_x(angle: SX | float) -> SX:
    """Rx(angle), shape (3, 3), angle in rad."""
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(ca.horzcat(1, 0, 0), ca.horzcat(0, c, -s), ca.horzcat(0, s, c))


def tray_rotation(yaw: SX, theta_y: SX, theta_x: SX) -> SX:
    """R = Rz(yaw) Ry(theta_y) Rx(theta_x), tray to base, shape (3, 3) [D3, Eq. 11]."""
    return rotation_z(yaw) @ rotation_y(theta_y) @ rotation_x(theta_x)


def tray_rates(yaw: tuple[SX, SX, SX], theta_y: tuple[SX, SX, SX], theta_x: tuple[SX, SX, SX]) -> tuple[SX, SX]:
    """Angular velocity and acceleration of the tray in tray axes, each shape (3, 1).

    Each argument is (angle, rate, acceleration) in rad, rad/s, rad/s^2. The velocity follows from R' = R [omega]x for
    R = Rz Ry Rx; the acceleration is its time derivative.
    """
    angles = vector(yaw[0], theta_y[0], theta_x[0])
    rates = vector(yaw[1], theta_y[1], theta_x[1])
    accelerations = vector(yaw[2], theta_y[2], theta_x[2])
    angle = SX.sym("angle", 3)
    rate = SX.sym("rate", 3)
    omega = vector(
        rate[2] - rate[0] * ca.sin(angle[1]),
        rate[1] * ca.cos(angle[2]) + rate[0] * ca.cos(angle[1]) * ca.sin(angle[2]),
        -rate[1] * ca.sin(angle[2]) + rate[0] * ca.cos(angle[1]) * ca.cos(angle[2]),
    )
    acceleration = SX.sym("acceleration", 3)
    alpha = ca.jtimes(omega, angle, rate) + ca.jtimes(omega, rate, acceleration)
    # Substituting after differentiating lets structural zeros (a level tray) vanish from the expressions.
    omega, alpha = ca.substitute([omega, alpha], [angle, rate, acceleration], [angles, rates, accelerations])
    return omega, alpha


@dataclass(frozen=True, slots=True)
class FrameMotion:
    """Motion of a rigid frame at one instant, in its own axes; every field an SX of shape (3, 1).

    Attributes:
        angular_velocity: omega, rad/s.
        angular_acceleration: alpha, rad/s^2.
        specific_force: R^T (acceleration of the origin + g e_z), m/s^2: what an accelerometer at the origin reads.
        up: R^T e_z, the vertical; None where it is not known.
    """

    angular_velocity: SX
    angular_acceleration: SX
    specific_force: SX
    up: SX | None = None

    def at(self, offset: SX | ca.DM) -> FrameMotion:
        """The frame carried to a point of the same rigid body, `offset` (3,) m in the frame's axes."""
        omega, alpha = self.angular_velocity, self.angular_acceleration
        carried = self.specific_force + ca.cross(alpha, offset) + ca.cross(omega, ca.cross(omega, offset))
        return FrameMotion(omega, alpha, carried, self.up)

    def heavier(self, added: SX | float) -> FrameMotion:
        """The same motion in a gravity that is greater by `added`, m/s^2."""
        assert self.up is not None
        return replace(self, specific_force=self.specific_force + added * self.up)

    def turned(self, yaw: SX | float) -> FrameMotion:
        """The same motion in axes fixed to the body but turned by `yaw` rad about its z."""
        back = rotation_z(yaw).T
        up = None if self.up is None else back @ self.up
        force = back @ self.specific_force
        return FrameMotion(back @ self.angular_velocity, back @ self.angular_acceleration, force, up)


def body_motion(body: SX, up: SX | None = None) -> FrameMotion:
    """Nine rows (9, 1) as a frame motion: angular velocity, angular acceleration, specific force.

    The vertical is `up`, or three more rows.
    """
    return FrameMotion(body[:3], body[3:6], body[6:9], body[9:12] if body.numel() > 9 else up)


def frame_at_rest(gravity: SX) -> FrameMotion:
    """Motion of a level frame at rest: gravity, m/s^2, is all there is of the specific force."""
    return FrameMotion(SX.zeros(3), SX.zeros(3), ca.vertcat(0, 0, gravity), VERTICAL)
