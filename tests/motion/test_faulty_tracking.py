"""Joints that are late, swing or are elastic: against closed forms and an integrator of others."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from nospill.motion.interpolation import QUINTIC_SPLINE, JointMotion, JointSamples
from nospill.motion.tracking import Swinging, elastic, late_by
from nospill.scene.controller import Controller


@pytest.fixture(scope="module")
def asked() -> JointMotion:
    """Two joints from rest to rest within a second."""
    t = np.linspace(0.0, 1.0, 401)
    rise = t**4 * (35.0 - 84.0 * t + 70.0 * t**2 - 20.0 * t**3)
    return QUINTIC_SPLINE.motion(JointSamples(t, np.column_stack([rise, -0.4 * rise])))


def test_a_late_joint_is_where_it_should_have_been(asked: JointMotion) -> None:
    t, delay = np.linspace(0.1, 0.9, 60), np.array([0.0, 0.013])
    motion = late_by(asked, 0.0, 1.0)(Controller(delay, np.zeros(2)))
    for order in range(3):
        expected = np.column_stack([asked(t - own, order)[:, joint] for joint, own in enumerate(delay)])
        assert np.allclose(motion(t, order), expected, atol=1e-7 * 10.0 ** (2 * order))


def test_a_swinging_joint_has_the_derivatives_of_its_sinusoid(asked: JointMotion) -> None:
    motion = Swinging(asked, np.array([1e-3, 2e-3]), 5.0, np.array([0.3, -1.0]))
    t, step = np.linspace(0.1, 0.9, 40), 1e-5
    for order in range(2):
        slope = (motion(t + step, order) - motion(t - step, order)) / (2.0 * step)
        assert np.allclose(motion(t, order + 1), slope, atol=1e-5)
    assert np.max(np.abs(motion(t) - asked(t)), axis=0) == pytest.approx([1e-3, 2e-3], rel=2e-2)


@pytest.mark.parametrize(("frequency", "damping"), [(8.0, 0.05), (30.0, 0.2)])
def test_an_elastic_joint_solves_its_equation_of_motion(asked: JointMotion, frequency: float, damping: float) -> None:
    """x'' = w^2 (q - x) + 2 zeta w (q' - x'), integrated by a library, the motor's motion the input."""
    rate = 2.0 * np.pi * frequency

    def change(t: float, state: np.ndarray) -> np.ndarray:
        at = np.array([t])
        x, speed = np.split(state, 2)
        pull = rate**2 * (asked(at)[0] - x) + 2.0 * damping * rate * (asked(at, 1)[0] - speed)
        return np.concatenate([speed, pull])

    start = np.concatenate([asked(np.zeros(1))[0], np.zeros(2)])
    t = np.linspace(0.0, 1.3, 90)
    found = solve_ivp(change, (0.0, 1.3), start, t_eval=t, rtol=1e-9, atol=1e-11, max_step=2e-3).y
    motion = elastic(asked, np.full(2, frequency), damping, 0.0, 1.3)
    assert np.allclose(motion(t), found[:2].T, atol=2e-6)
    assert np.allclose(motion(t, 1), found[2:].T, atol=2e-4)
    pulls = np.array([change(at, state)[2:] for at, state in zip(t, found.T, strict=True)])
    assert np.allclose(motion(t, 2), pulls, atol=3e-2)


def test_a_stiff_joint_follows_its_motor(asked: JointMotion) -> None:
    """The offset tends to -q''/w^2."""
    t, rate = np.linspace(0.1, 0.9, 50), 2.0 * np.pi * 200.0
    offset = elastic(asked, np.full(2, 200.0), 0.7, 0.0, 1.0)(t) - asked(t)
    assert np.allclose(offset, -asked(t, 2) / rate**2, atol=0.05 * np.max(np.abs(asked(t, 2))) / rate**2)
