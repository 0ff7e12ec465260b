"""Quaternions and matrices against SciPy's."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from nospill.core.attitudes import angles_between, matrices, tray_quaternions

angle = st.floats(-7.0, 7.0)


@given(angle, angle, angle)
def test_tray_quaternions_are_intrinsic_turns_about_z_y_x(yaw, theta_y, theta_x):
    ours = tray_quaternions(*(np.array([value]) for value in (yaw, theta_y, theta_x)))
    theirs = Rotation.from_euler("ZYX", [yaw, theta_y, theta_x]).as_quat()
    assert abs(abs(float(ours[0] @ theirs)) - 1.0) < 1e-14


def test_a_tray_that_turns_on_and_on_has_a_steady_quaternion():
    yaw = np.linspace(-7.0, 7.0, 1001)
    quaternions = tray_quaternions(yaw, np.full_like(yaw, 0.3), np.full_like(yaw, -0.2))
    assert np.all(np.sum(quaternions[1:] * quaternions[:-1], axis=1) > 0.99)


@given(st.lists(st.floats(-5.0, 5.0), min_size=4, max_size=4).filter(lambda q: np.linalg.norm(q) > 1e-3))
def test_matrices_of_quaternions_of_any_length(quaternion):
    ours = matrices(np.array([quaternion]))[0]
    np.testing.assert_allclose(ours, Rotation.from_quat(quaternion).as_matrix(), atol=1e-14)


def test_no_quaternion_gives_no_numbers():
    assert np.all(np.isnan(matrices(np.zeros((1, 4)))))


@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-5, 1.0, 3.0, np.pi])
def test_angle_between_two_attitudes(size):
    random = np.random.default_rng(1)
    first = Rotation.from_quat(random.normal(size=(20, 4)))
    axis = random.normal(size=(20, 3))
    turn = Rotation.from_rotvec(size * axis / np.linalg.norm(axis, axis=1, keepdims=True))
    found = angles_between(first.as_matrix(), (first * turn).as_matrix())
    # half a turn is where the sine is flat
    np.testing.assert_allclose(found, size, rtol=1e-9, atol=1e-15 if size < 3.1 else 1e-7)
