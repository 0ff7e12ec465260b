"""Modal quantities of the cylinder against published values, closed forms of other origin, and limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import dblquad, quad
from scipy.special import ive, j1, jnp_zeros, jvp

from nospill.scene.containers.cylinder import Cylinder, bessel_roots, enclosed_liquid_inertia, published_damping
from nospill.scene.liquids import LIQUIDS
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from nospill.scene.sloshing.prism import EMPIRICAL_DAMPING, LARGEST_DAMPING, PrismMode

WATER = LIQUIDS["water"]
CUP = Cylinder(0.035, 0.0991)

# h/R, omega_1^2 R/g, m_1/m_F, H_1/h, m_0/m_F, H_0/h, I_0/(m_F R^2), C_1
TABLE = [
    (0.25, 0.79230812, 0.78234731, 0.01728980, 0.21765269, 2.23509011, 0.18373289, 0.66303108),
    (0.50, 1.33702587, 0.66010847, 0.06511150, 0.33989153, 1.34460350, 0.10975981, 1.11886990),
    (0.75, 1.62235894, 0.53398761, 0.13350369, 0.46601239, 0.91995555, 0.07147600, 1.35764657),
    (1.00, 1.75079757, 0.43219669, 0.21118434, 0.56780331, 0.71983875, 0.05302223, 1.46512849),
    (1.40, 1.82006327, 0.32092529, 0.33364342, 0.67907471, 0.57861879, 0.04876091, 1.52309245),
    (2.00, 1.83885361, 0.22696697, 0.48353410, 0.77303303, 0.50483448, 0.09514789, 1.53881685),
    (3.00, 1.84112511, 0.15149822, 0.64079326, 0.84850178, 0.47486166, 0.32427713, 1.54071773),
]


@pytest.mark.parametrize("row", TABLE, ids=lambda row: f"h/R={row[0]}")
@pytest.mark.parametrize("radius", [0.035, 1.0])
def test_table_of_one_mode(row, radius):
    fill, *expected = row
    modes = Cylinder(radius, 5 * radius).slosh_modes(WATER, fill * radius, 1)
    mode, depth = modes.oscillators[0], fill * radius
    found = (
        mode.frequency**2 * radius / STANDARD_GRAVITY,
        mode.mass / modes.liquid_mass,
        mode.height / depth,
        modes.fixed_mass / modes.liquid_mass,
        modes.fixed_height / depth,
        modes.fixed_inertia[0] / (modes.liquid_mass * radius**2),
        mode.surface_gain,
    )
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=6e-9)
    assert modes.fixed_inertia[0] == modes.fixed_inertia[1]


def test_the_published_cup():
    modes = CUP.slosh_modes(WATER, 0.049, 3)
    first = modes.oscillators[0]
    assert modes.liquid_mass == pytest.approx(0.18824, abs=1e-5)
    assert first.frequency == pytest.approx(22.58237, abs=5e-6)
    assert first.frequency / (2 * np.pi) == pytest.approx(3.594096, abs=5e-7)
    np.testing.assert_allclose(
        [mode.mass / modes.liquid_mass for mode in modes.oscillators], (0.3209253, 0.0097706, 0.0023286), atol=5e-8
    )
    np.testing.assert_allclose(
        [mode.surface_gain for mode in modes.oscillators], (1.523092, 0.388812, 0.237553), atol=6e-7
    )
    np.testing.assert_allclose(
        [mode.height - 0.0245 for mode in modes.oscillators[:2]], (-8.15e-3, 11.39e-3), atol=6e-6
    )
    # With three modes: fixed mass, its height above the liquid's centre, its inertia.
    assert modes.fixed_mass / modes.liquid_mass == pytest.approx(0.666976, abs=5e-7)
    assert modes.fixed_height - 0.0245 == pytest.approx(3.698e-3, abs=6e-7)
    assert modes.fixed_inertia[0] / modes.liquid_mass == pytest.approx(58.80e-6, abs=6e-9)
    many = CUP.slosh_modes(WATER, 0.049, 400)
    assert many.fixed_mass / many.liquid_mass == pytest.approx(0.664808, abs=5e-7)
    assert many.fixed_inertia[0] / many.liquid_mass == pytest.approx(58.22e-6, abs=6e-9)
    # x at 15 mm
    assert 0.015 / first.surface_gain == pytest.approx(9.848e-3, abs=5e-7)


def test_damping_of_the_published_cup():
    modes = CUP.slosh_modes(WATER, 0.049, 3)
    # The published 0.006724 is the same formula with nu = 1e-3/998.2.
    assert modes.oscillators[0].damping == pytest.approx(0.006724, rel=1.2e-3)
    assert published_damping(WATER, 0.035, 0.049) == modes.oscillators[0].damping
    fixed = CUP.slosh_modes(WATER, 0.049, 3, 0.0097)
    assert fixed.oscillators[0].damping == pytest.approx(0.0097, rel=1e-14)
    for given_, default in zip(fixed.oscillators, modes.oscillators, strict=True):
        assert given_.damping / 0.0097 == pytest.approx(default.damping / modes.oscillators[0].damping, rel=1e-12)
    assert CUP.slosh_modes(WATER, 0.049, 400).oscillators[-1].damping == LARGEST_DAMPING
    assert all(mode.damping == 0.0 for mode in CUP.slosh_modes(WATER, 0.049, 3, 0.0).oscillators)


def test_laminar_damping_of_the_published_cup():
    mode = CUP._mode(float(bessel_roots(1)[0]), 1.4)
    assert mode.laminar_damping(WATER, 0.049) == pytest.approx(0.00412, abs=6e-6)
    assert mode.laminar_damping(WATER, 0.049) - mode.layer_damping(WATER, 0.049) == pytest.approx(0.00025, abs=6e-6)
    deep = published_damping(WATER, 0.035, 0.35) / Cylinder(0.035, 1.0)._mode(
        float(bessel_roots(1)[0]), 10.0
    ).layer_damping(WATER, 0.35)
    assert deep == pytest.approx(EMPIRICAL_DAMPING, rel=1e-6)


@pytest.mark.parametrize(("number", "fill"), [(1, 1.4), (1, 0.3), (2, 0.5)])
def test_layer_ratio_by_quadrature(number, fill):
    """phi = J_1(k r) cosh(k z) cos(theta), R = 1: |grad phi|^2 on wall and bottom over that in the volume."""
    k = float(bessel_roots(number)[-1])

    def speed_squared(r, z):
        radial = (k * jvp(1, k * r) * np.cosh(k * z)) ** 2
        around = (j1(k * r) / r * np.cosh(k * z)) ** 2 if r else (k / 2 * np.cosh(k * z)) ** 2
        return radial + around + (k * j1(k * r) * np.sinh(k * z)) ** 2

    wall = quad(lambda z: speed_squared(1.0, z), 0, fill)[0]
    bottom = quad(lambda r: r * speed_squared(r, 0.0), 0, 1)[0]
    volume = dblquad(lambda r, z: r * speed_squared(r, z), 0, fill, 0, 1)[0]
    assert Cylinder(1.0, 9.0)._mode(k, fill).layer_ratio == pytest.approx((wall + bottom) / volume, rel=1e-7)


def test_roots_agree_with_scipy():
    np.testing.assert_allclose(bessel_roots(300), jnp_zeros(1, 300), rtol=3e-14)
    np.testing.assert_array_equal(bessel_roots(3), bessel_roots(12)[:3])


def test_sum_of_static_shares_is_one():
    assert np.sum(2 / (bessel_roots(20_000) ** 2 - 1)) == pytest.approx(1.0, abs=2e-5)


@pytest.mark.parametrize(("fill", "ratio"), [(1.4, 0.1800), (1.0, 0.3495), (0.5, 0.7443), (2.0, 0.1637)])
def test_enclosed_inertia_against_the_series_in_modified_bessel_functions(fill, ratio):
    """The other expansion of the Stokes-Joukowski potential: harmonics of the height instead of Bessel modes."""
    h, radius = fill, 1.0
    k = np.arange(1, 40_001, 2) * np.pi / h
    a = -4 / (h * k**2)
    slope = ive(0, k * radius) - ive(1, k * radius) / (k * radius)  # I_1' e^-x
    q = ive(1, k * radius) / (k * slope)
    j_over_m = (
        -(h**2) / 12
        + radius**2 / 4
        + np.sum(a**2 * q) / radius
        + 4 / h * np.sum(a * ive(2, k * radius) / (k**2 * slope))
    )
    assert enclosed_liquid_inertia(radius, h) == pytest.approx(j_over_m, abs=1e-9)
    assert enclosed_liquid_inertia(radius, h) / (radius**2 / 4 + h**2 / 12) == pytest.approx(ratio, abs=6e-5)


fills = st.floats(0.05, 6.0)
radii = st.floats(0.01, 0.3)


@given(radii, fills, st.integers(1, 12))
def test_mass_moment_inertia_and_height_sums(radius, fill, count):
    h = fill * radius
    modes = Cylinder(radius, 2 * h).slosh_modes(WATER, h, count)
    masses = np.array([modes.fixed_mass, *(mode.mass for mode in modes.oscillators)])
    heights = np.array([modes.fixed_height, *(mode.height for mode in modes.oscillators)]) - h / 2
    assert np.all(masses > 0)
    assert masses.sum() == pytest.approx(modes.liquid_mass, rel=1e-12)
    assert masses @ heights == pytest.approx(0.0, abs=1e-12 * modes.liquid_mass * h)
    inertia = modes.liquid_mass * enclosed_liquid_inertia(radius, h)
    assert modes.fixed_inertia[0] + masses @ heights**2 == pytest.approx(inertia, rel=1e-9)
    assert 0 < inertia < modes.liquid_mass * (radius**2 / 4 + h**2 / 12)
    for mode, root in zip(modes.oscillators, bessel_roots(count), strict=True):
        assert mode.directions == ("x", "y")
        assert mode.stiffness == pytest.approx(mode.wave_number * np.tanh(mode.wave_number * h), rel=1e-12)
        # The published expressions of the height: by the modal mass and by the frequency.
        by_mass = root**2 * h * mode.mass / (radius * modes.liquid_mass)
        by_frequency = 2 * radius * mode.frequency**2 / (STANDARD_GRAVITY * (root**2 - 1))
        assert mode.surface_gain == pytest.approx(by_mass, rel=1e-12)
        assert mode.surface_gain == pytest.approx(by_frequency, rel=1e-12)
        assert 0 < mode.height < h
    carried = sum(2 / (root**2 - 1) for root in bessel_roots(count)) * radius
    np.testing.assert_allclose(modes.static_correction, radius - carried, rtol=1e-9)
    assert np.all(modes.static_correction > 0)


def test_limits_of_shallow_and_deep_liquid():
    shallow = Cylinder(1.0, 1.0).slosh_modes(WATER, 1e-4, 1, 0.01)
    assert shallow.oscillators[0].mass / shallow.liquid_mass == pytest.approx(0.836835, abs=1e-6)
    assert shallow.oscillators[0].frequency == pytest.approx(1.841184 * np.sqrt(STANDARD_GRAVITY * 1e-4), rel=1e-6)
    deep = Cylinder(0.01, 30.0).slosh_modes(WATER, 20.0, 2)
    assert deep.oscillators[0].frequency == pytest.approx(np.sqrt(STANDARD_GRAVITY * 184.1183781), rel=1e-8)
    assert 20.0 - deep.oscillators[0].height == pytest.approx(0.02 / 1.841183781, rel=1e-8)
    assert np.isfinite(deep.oscillators[1].damping)


def test_prism_heights_need_only_the_wave_number():
    mode = PrismMode(wave_number=50.0, mass_fraction=0.3, surface_gain=1.0, layer_ratio=1.0, directions=("x",))
    # Weight moment included, the mass lies g/omega^2 below the hinge of the equivalent pendulum.
    hinge = 0.049 - (np.tanh(50 * 0.0245) - 1 / np.sinh(50 * 0.049)) / 50
    assert mode.mass_height(0.049) == pytest.approx(hinge - STANDARD_GRAVITY / mode.frequency(0.049) ** 2, rel=1e-12)
