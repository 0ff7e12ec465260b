"""Rotations and moving frames against scipy, finite differences and the second derivative of a carried point."""

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nospill.core.frames import FrameMotion, rotation_x, rotation_y, rotation_z, tray_rates, tray_rotation, vector
from nospill.laws.sample import tray_motion

GRAVITY = 9.80665
TIME = ca.SX.sym("t")
POLYNOMIALS = ca.SX.sym("c", 6, 5)
"""Coefficients of position x, y, z, then yaw, theta_y, theta_x, as polynomials of time."""


def motion_expressions() -> tuple[ca.SX, ca.SX, FrameMotion]:
    """Position, attitude and body motion of a tray whose position and angles are polynomials of time."""
    curves = POLYNOMIALS @ ca.vertcat(*[TIME**power for power in range(5)])
    rates = ca.jacobian(curves, TIME)
    changes = ca.jacobian(rates, TIME)
    chains = [(curves[row], rates[row], changes[row]) for row in range(3, 6)]
    omega, alpha = tray_rates(*chains)
    rotation = tray_rotation(*[chain[0] for chain in chains])
    return curves[:3], rotation, tray_motion(rotation, changes[:3], omega, alpha, GRAVITY)


def random_polynomials(count: int) -> list[np.ndarray]:
    random = np.random.default_rng(5)
    return [random.normal(size=(6, 5)) * (1.0, 2.0, 3.0, 2.0, 1.0) for _ in range(count)]


def test_attitude_turns_about_z_then_y_then_x():
    angles = np.random.default_rng(1).uniform(-3, 3, (50, 3))
    for yaw, theta_y, theta_x in angles:
        ours = ca.evalf(tray_rotation(ca.SX(yaw), ca.SX(theta_y), ca.SX(theta_x))).full()
        expected = Rotation.from_euler("ZYX", (yaw, theta_y, theta_x)).as_matrix()
        np.testing.assert_allclose(ours, expected, atol=1e-15)


@pytest.mark.parametrize(("rotation", "axis"), [(rotation_x, 0), (rotation_y, 1), (rotation_z, 2)], ids=["x", "y", "z"])
def test_elementary_rotations_are_right_handed(rotation, axis):
    turned = ca.evalf(rotation(0.3)).full()
    np.testing.assert_allclose(turned, Rotation.from_rotvec(0.3 * np.eye(3)[axis]).as_matrix(), atol=1e-15)


def test_body_rates_against_finite_differences_of_the_attitude():
    _, rotation, motion = motion_expressions()
    function = ca.Function("f", [TIME, POLYNOMIALS], [rotation, motion.angular_velocity, motion.angular_acceleration])
    step = 1e-5
    for polynomials in random_polynomials(100):
        before, now, after = (
            [out.full() for out in function(0.4 + shift, polynomials)] for shift in (-step, 0.0, step)
        )
        spin = now[0].T @ (after[0] - before[0]) / (2 * step)
        np.testing.assert_allclose(spin, -spin.T, atol=1e-6)
        size = 1 + np.abs(now[1]).max() ** 3
        np.testing.assert_allclose([spin[2, 1], spin[0, 2], spin[1, 0]], now[1].ravel(), atol=1e-7 * size)
        np.testing.assert_allclose((after[1] - before[1]) / (2 * step), now[2], atol=1e-7 * size)


def test_body_rates_against_exact_derivatives_of_the_attitude():
    """No finite differences: R^T R' and its derivative by automatic differentiation of R alone."""
    _, rotation, motion = motion_expressions()
    slope = ca.reshape(ca.jacobian(ca.vec(rotation), TIME), 3, 3)
    spin = rotation.T @ slope
    omega = ca.vertcat(spin[2, 1], spin[0, 2], spin[1, 0])
    errors = ca.vertcat(omega - motion.angular_velocity, ca.jacobian(omega, TIME) - motion.angular_acceleration)
    function = ca.Function("f", [TIME, POLYNOMIALS], [errors])
    for polynomials in random_polynomials(200):
        assert np.abs(function(0.4, polynomials).full()).max() < 1e-10


def test_level_tray_has_no_trace_of_the_tilt_in_its_rates():
    yaw = ca.SX.sym("yaw", 3)
    level = (ca.SX(0), ca.SX(0), ca.SX(0))
    function = ca.Function("f", [yaw], [ca.vertcat(*tray_rates((yaw[0], yaw[1], yaw[2]), level, level))])
    np.testing.assert_array_equal(function([0.7, 2.0, 3.0]).full().ravel(), (0, 0, 2.0, 0, 0, 3.0))
    assert function.n_instructions() < 12  # inputs and outputs; no sine is left


def test_frame_carried_and_turned_against_the_motion_of_the_point_itself():
    """R_b^T (p'' + g e_z) of a point and axes fixed to the body, from their own pose differentiated twice."""
    position, rotation, motion = motion_expressions()
    offset, turn = ca.SX.sym("offset", 3), ca.SX.sym("turn")
    point = position + rotation @ offset
    axes = rotation @ rotation_z(turn)
    acceleration = ca.jacobian(ca.jacobian(point, TIME), TIME)
    spin = axes.T @ ca.reshape(ca.jacobian(ca.vec(axes), TIME), 3, 3)
    omega = ca.vertcat(spin[2, 1], spin[0, 2], spin[1, 0])
    expected = ca.vertcat(axes.T @ (acceleration + vector(0, 0, GRAVITY)), omega, ca.jacobian(omega, TIME))
    for carried in (motion.at(offset).turned(turn), motion.turned(turn).at(rotation_z(turn).T @ offset)):
        ours = ca.vertcat(carried.specific_force, carried.angular_velocity, carried.angular_acceleration)
        error = ca.Function("f", [TIME, POLYNOMIALS, offset, turn], [ours - expected])
        random = np.random.default_rng(2)
        for polynomials in random_polynomials(100):
            assert np.abs(error(0.4, polynomials, random.normal(size=3), random.normal()).full()).max() < 1e-9


def test_rest_feels_gravity_only():
    tilt = 0.4
    rotation = ca.DM(ca.evalf(rotation_y(tilt)))
    motion = tray_motion(ca.SX(rotation), ca.SX.zeros(3), ca.SX.zeros(3), ca.SX.zeros(3), GRAVITY)
    felt = ca.evalf(motion.at(ca.DM([1, 2, 3])).specific_force).full().ravel()
    np.testing.assert_allclose(felt, (-GRAVITY * np.sin(tilt), 0, GRAVITY * np.cos(tilt)), atol=1e-14)
