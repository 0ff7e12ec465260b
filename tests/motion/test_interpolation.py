"""Motions between samples, against polynomials known in closed form and another library's interpolation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from scipy.interpolate import BPoly

from nospill.motion.interpolation import INTERPOLATIONS, QUINTIC_HERMITE, QUINTIC_SPLINE, JointSamples


def rest_to_rest(t: np.ndarray, joints: int = 7) -> JointSamples:
    """Each joint on the quintic 10 u^3 - 15 u^4 + 6 u^5, by its own way."""
    way, u = np.linspace(-2.0, 1.0, joints), (t / t[-1])[:, None]
    shape = Polynomial([0, 0, 0, 10, -15, 6])
    columns = [way * shape.deriv(order)(u) / t[-1] ** order for order in range(3)]
    return JointSamples(t, *columns)


@pytest.mark.parametrize("name", sorted(INTERPOLATIONS))
def test_every_interpolation_keeps_the_contract(name):
    interpolation = INTERPOLATIONS[name]
    assert interpolation.name == name
    assert interpolation.title and "\n" not in interpolation.title
    samples = rest_to_rest(np.arange(51) / 50)
    motion = interpolation.motion(samples)
    np.testing.assert_allclose(motion(samples.t), samples.position, atol=1e-13)
    outside = np.array([-3.0, -1e-9, 1.0 + 1e-9, 7.0])
    np.testing.assert_allclose(motion(outside), samples.position[[0, 0, -1, -1]], atol=1e-13)
    for order in (1, 2, 3):
        assert np.all(motion(outside, order) == 0.0)
    fine = np.linspace(0.0, 1.0, 4001)
    for order in range(2):
        rise = np.diff(motion(fine, order), axis=0) * 4000
        middle = motion((fine[1:] + fine[:-1]) / 2, order + 1)
        np.testing.assert_allclose(rise, middle, atol=2e-3)


@given(
    coefficients=st.lists(st.floats(-5, 5), min_size=6, max_size=6),
    widths=st.lists(st.floats(1e-3, 0.5), min_size=1, max_size=6),
)
@settings(deadline=None)
def test_hermite_is_exact_for_quintics_at_any_spacing(coefficients, widths):
    curve = Polynomial(coefficients)
    t = np.concatenate([[0.0], np.cumsum(widths)])
    motion = QUINTIC_HERMITE.motion(JointSamples(t, *(curve.deriv(order)(t)[:, None] for order in range(3))))
    inside = np.linspace(0.0, t[-1], 101)
    size = 1.0 + np.sum(np.abs(coefficients)) * max(1.0, t[-1]) ** 5
    np.testing.assert_allclose(motion(inside)[:, 0], curve(inside), atol=1e-13 * size)
    np.testing.assert_allclose(motion(inside, 1)[:, 0], curve.deriv()(inside), atol=1e-10 * size)


def test_hermite_is_what_another_library_makes_of_the_same_samples():
    random = np.random.default_rng(5)
    t = np.cumsum(random.uniform(0.005, 0.1, 30)) - 0.005
    columns = [random.normal(size=(30, 3)) * scale for scale in (1.0, 3.0, 20.0)]
    ours, inside = QUINTIC_HERMITE.motion(JointSamples(t, *columns)), np.linspace(t[0], t[-1], 777)
    for joint in range(3):
        theirs = BPoly.from_derivatives(t, np.stack([column[:, joint] for column in columns], axis=1))
        for order in range(3):
            np.testing.assert_allclose(ours(inside, order)[:, joint], theirs(inside, order), rtol=1e-8, atol=1e-7)


def test_hermite_reaches_speed_and_acceleration_of_every_sample_from_both_sides():
    samples = rest_to_rest(np.arange(21) / 20)
    motion, aside = QUINTIC_HERMITE.motion(samples), 1e-12
    for order, column in enumerate((samples.position, samples.speed, samples.acceleration)):
        assert column is not None
        np.testing.assert_allclose(motion(samples.t[1:] - aside, order), column[1:], atol=1e-8)
        np.testing.assert_allclose(motion(samples.t[:-1] + aside, order), column[:-1], atol=1e-8)


@pytest.mark.parametrize("missing", ["speed", "acceleration"])
def test_hermite_wants_all_columns(missing):
    samples = rest_to_rest(np.arange(5) / 4)
    columns = {"position": samples.position, "speed": samples.speed, "acceleration": samples.acceleration}
    with pytest.raises(ValueError, match="speeds and accelerations"):
        QUINTIC_HERMITE.motion(JointSamples(samples.t, **(columns | {missing: None})))  # pyright: ignore[reportArgumentType]


def test_spline_leaves_and_reaches_rest_smoothly():
    samples = rest_to_rest(np.arange(101) / 100)
    motion = QUINTIC_SPLINE.motion(JointSamples(samples.t, samples.position))
    assert np.abs(motion(np.array([0.0, 1.0]), 1)).max() < 1e-3
    fine = np.linspace(0, 1, 1001)
    exact = rest_to_rest(fine)
    assert exact.speed is not None
    np.testing.assert_allclose(motion(fine), exact.position, atol=1e-6)
    np.testing.assert_allclose(motion(fine, 1), exact.speed, atol=1e-3)


def test_a_motion_begins_with_the_speed_it_states_whatever_its_jerk():
    """Samples of a cubic, whose jerk jumps where they begin; far from their end the spline is that cubic."""
    t, curve = np.arange(61) / 125.0, Polynomial([0.2, 1.1, -3.0, 400.0])
    columns = [curve.deriv(order)(t)[:, None] for order in range(3)]
    motion = QUINTIC_SPLINE.motion(JointSamples(t, *columns, in_motion=True))
    early = np.linspace(0.0, 0.16, 50)
    for order in range(3):
        np.testing.assert_allclose(motion(early, order)[:, 0], curve.deriv(order)(early), rtol=1e-9, atol=1e-9)
    # with other first rates the samples are passed nevertheless
    other = [columns[0], columns[1] + 0.3, columns[2] - 2.0]
    bent = QUINTIC_SPLINE.motion(JointSamples(t, *other, in_motion=True))
    np.testing.assert_allclose([bent(t[:1], order)[0, 0] for order in (1, 2)], [1.4, -8.0], rtol=1e-9)
    np.testing.assert_allclose(bent(t), columns[0], atol=1e-12)
