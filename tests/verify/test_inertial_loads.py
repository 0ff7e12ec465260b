"""Inertial loads against the rate of angular momentum in space, and against bodies that drift freely there."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from nospill.verify.bodies import Body
from nospill.verify.engine import STEP, Stepper, build
from nospill.verify.inertial import carrying, inertial_forces, inertial_torques, skew
from nospill.verify.tray_motion import TrayMotion

vectors = st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=3).map(np.array)
INERTIA = np.array([[3.0, 0.4, -0.2], [0.4, 2.0, 0.3], [-0.2, 0.3, 4.0]])


def turn(rate: np.ndarray, change: np.ndarray, t: float) -> np.ndarray:
    """Attitude at a short time t of a frame whose angular velocity is rate + change t; right to third order in t."""
    mean = rate * t + change * t**2 / 2
    return Rotation.from_rotvec(mean).as_matrix()


@settings(max_examples=60, deadline=None)
@given(vectors, vectors, vectors, vectors)
def test_torque_is_what_the_angular_momentum_in_space_lacks(
    spin: np.ndarray, spin_rate: np.ndarray, relative: np.ndarray, relative_rate: np.ndarray
) -> None:
    def momentum(t: float) -> np.ndarray:
        tray, body = turn(spin, spin_rate, t), turn(relative, relative_rate, t)
        inertia = body @ INERTIA @ body.T
        return tray @ inertia @ (spin + spin_rate * t + relative + relative_rate * t)

    h = 1e-5
    needed = (momentum(h) - momentum(-h)) / (2 * h)
    own = INERTIA @ relative_rate + np.cross(relative, INERTIA @ relative)
    given_torque = inertial_torques(INERTIA[None], relative[None], spin=spin, spin_rate=spin_rate, turning=skew(spin))[
        0
    ]
    assert given_torque == pytest.approx(own - needed, rel=1e-5, abs=1e-4)


@settings(max_examples=60, deadline=None)
@given(vectors, vectors, vectors, vectors)
def test_force_is_what_the_acceleration_in_space_lacks(
    spin: np.ndarray, spin_rate: np.ndarray, centre: np.ndarray, velocity: np.ndarray
) -> None:
    def place(t: float) -> np.ndarray:
        return turn(spin, spin_rate, t) @ (centre + velocity * t)

    h = 1e-4
    needed = (place(h) - 2 * place(0.0) + place(-h)) / h**2
    force = inertial_forces(
        np.array([2.0]), centre[None], velocity[None], turning=skew(spin), carried=carrying(spin, spin_rate)
    )[0]
    assert force == pytest.approx(-2.0 * needed, rel=1e-4, abs=1e-3)


def block(inertia: np.ndarray) -> Body:
    return Body(
        name="block",
        position=np.zeros(2),
        yaw=0.0,
        mass=0.7,
        centre=np.array([0.01, -0.02, 0.05]),
        inertia=inertia,
        contacts=0.05 * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]),
        height=0.1,
        liquid_height=0.0,
        friction=0.5,
        modes=(),
        swing=np.zeros((2, 0)),
    )


def test_body_let_go_in_a_wild_frame_drifts_straight_on_in_space() -> None:
    # A frame that turns about an oblique axis by phi(t) while its origin runs along a curve; no gravity.
    count = 401
    t = STEP * np.arange(count)
    axis = np.array([1.0, 2.0, 2.0]) / 3.0
    phi, rate, change = 0.6 * np.sin(5 * t), 3.0 * np.cos(5 * t), -15.0 * np.sin(5 * t)
    attitude = Rotation.from_rotvec(phi[:, None] * axis)
    origin = np.column_stack([0.2 * np.sin(4 * t), 0.1 * t**2, 0.3 * np.cos(3 * t)])
    acceleration = np.column_stack([-3.2 * np.sin(4 * t), np.full(count, 0.2), -2.7 * np.cos(3 * t)])
    speed = np.array([0.8, 0.0, 0.0])  # of the origin at t = 0
    motion = TrayMotion(
        t,
        angular_velocity=rate[:, None] * axis,
        angular_acceleration=change[:, None] * axis,
        specific_force=attitude.inv().apply(acceleration),
        position=origin,
        rotation=attitude.as_matrix(),
    )
    inertia = 1e-3 * np.diag([2.0, 3.0, 4.0])
    bodies = (block(inertia),)
    stepper = Stepper(build(bodies), bodies, motion)
    drift, spin = np.array([0.1, -0.3, 0.2]), np.array([1.0, -2.0, 3.0])  # in space
    centre = np.array([0.1, 0.1, 0.6]) + origin[0]  # high above the tray, which it must not touch
    stepper.data.qpos[:3] = centre - origin[0] - bodies[0].centre
    relative = spin - rate[0] * axis
    # The engine wants the speed of the body's own origin in world axes and the spin in body axes, here the same.
    at_centre = drift - speed - np.cross(rate[0] * axis, centre - origin[0])
    stepper.data.qvel[:3] = at_centre + np.cross(relative, -bodies[0].centre)
    stepper.data.qvel[3:] = relative
    found = stepper.run()

    def euler(_: float, state: np.ndarray) -> np.ndarray:
        quaternion, omega = state[:4], state[4:]
        turned = 0.5 * (Rotation.from_quat(quaternion).as_matrix() @ omega)
        x, y, z = 2 * turned
        w = np.array([[0, -z, y, x], [z, 0, -x, y], [-y, x, 0, z], [-x, -y, -z, 0]]) / 2
        return np.concatenate([w @ quaternion, np.linalg.solve(inertia, -np.cross(omega, inertia @ omega))])

    exact = solve_ivp(euler, (0.0, t[-1]), np.concatenate([[0, 0, 0, 1], spin]), rtol=1e-10, atol=1e-12).y[:, -1]
    last = Rotation.from_quat(found.quaternion[-1, 0][[1, 2, 3, 0]])
    in_space = attitude[-1] * last
    assert (in_space.inv() * Rotation.from_quat(exact[:4])).magnitude() < 0.01  # 1 ms steps of first order, 1.5 rad
    place = origin[-1] + attitude[-1].apply(found.position[-1, 0] + last.apply(bodies[0].centre))
    assert place == pytest.approx(centre + drift * t[-1], abs=2e-3)
