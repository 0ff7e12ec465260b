"""Modal quantities of the box: test values, sums, an independent inertia and the sign of the surface."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import dblquad, quad

from nospill.scene.containers.box import Box, _mode, boundary_layer_damping, enclosed_liquid_inertia
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.liquids import LIQUIDS

WATER = LIQUIDS["water"]
BOX = Box(0.07, 0.05, 0.12)


def test_the_box_of_70_by_49_mm():
    modes = BOX.slosh_modes(WATER, 0.049, 1)
    along_x, along_y = modes.oscillators
    assert along_x.directions == ("x",) and along_y.directions == ("y",)
    assert along_x.frequency / (2 * np.pi) == pytest.approx(3.298107, abs=5e-7)
    assert along_x.mass / modes.liquid_mass == pytest.approx(0.3596325, abs=5e-8)
    assert along_x.height == pytest.approx(13.334e-3, abs=5e-7)
    assert along_x.surface_gain == pytest.approx(1.242301, abs=5e-7)
    # One mode carries 8/pi^2 of the static height.
    np.testing.assert_allclose(modes.static_correction, np.array((0.035, 0.025)) * (1 - 8 / np.pi**2), rtol=1e-12)


def test_turning_the_box_swaps_its_axes():
    modes, turned = BOX.slosh_modes(WATER, 0.049, 2), Box(0.05, 0.07, 0.12).slosh_modes(WATER, 0.049, 2)
    for number in (0, 2):
        for first, second in ((0, 1), (1, 0)):
            mode, other = modes.oscillators[number + first], turned.oscillators[number + second]
            assert (mode.frequency, mode.mass, mode.height) == (other.frequency, other.mass, other.height)
            assert mode.damping == pytest.approx(other.damping, rel=1e-12)
    np.testing.assert_allclose(modes.fixed_inertia, turned.fixed_inertia[::-1], rtol=1e-12)


sides = st.floats(0.02, 0.4)


@given(sides, sides, st.floats(0.05, 4.0), st.integers(1, 6))
def test_mass_moment_inertia_and_height_sums(length, width, fill, count):
    h = fill * length
    modes = Box(length, width, 2 * h).slosh_modes(WATER, h, count)
    assert [mode.directions for mode in modes.oscillators] == [("x",), ("y",)] * count
    masses = np.array([modes.fixed_mass, *(mode.mass for mode in modes.oscillators)])
    heights = np.array([modes.fixed_height, *(mode.height for mode in modes.oscillators)]) - h / 2
    scale = modes.liquid_mass * max(h, length, width) ** 2 * (1 + 1e-3 * modes.liquid_mass / abs(modes.fixed_mass))
    assert masses.sum() == pytest.approx(modes.liquid_mass, rel=1e-12)
    assert masses @ heights == pytest.approx(0.0, abs=1e-10 * modes.liquid_mass * h)
    for axis, side in ((0, width), (1, length)):  # pitch about x moves liquid along y
        inertia = modes.liquid_mass * enclosed_liquid_inertia(side, h)
        assert modes.fixed_inertia[axis] + masses @ heights**2 == pytest.approx(inertia, abs=1e-9 * scale)
    for name in ("x", "y"):
        assert sum(mode.mass for mode in modes.oscillators if name in mode.directions) < modes.liquid_mass
    assert np.all(modes.static_correction > 0)


def test_many_modes_give_the_flat_surface():
    modes = BOX.slosh_modes(WATER, 0.049, 500)
    np.testing.assert_allclose(modes.static_correction, 0.0, atol=2e-5)


def test_a_box_whose_modes_take_all_of_its_mass():
    # A square box of such a depth that the fixed mass vanishes: everything stays finite and adds up.
    from scipy.optimize import brentq

    def fixed(depth: float) -> float:
        return 1 - 16 * np.tanh(np.pi * depth) / (np.pi**3 * depth)

    depth = brentq(fixed, 0.1, 2.0, xtol=1e-16)
    modes = Box(1.0, 1.0, 3.0).slosh_modes(WATER, depth, 1)  # pyright: ignore[reportArgumentType]
    moment = modes.fixed_mass * modes.fixed_height + sum(mode.mass * mode.height for mode in modes.oscillators)
    assert moment == pytest.approx(modes.liquid_mass * depth / 2, rel=1e-8)  # pyright: ignore[reportOperatorIssue]


@pytest.mark.parametrize(("fill", "ratio"), [(1.0, 0.1565), (0.5, 0.4512), (2.0, 0.4512)])
def test_enclosed_inertia_against_the_potential_series(fill, ratio):
    """Series in harmonics of the height of the Stokes-Joukowski potential in a rectangle of sides a x h."""
    a, h = 1.0, fill
    q = np.arange(1, 20_001, 2) * np.pi / h
    coefficient, th = -4 / (h * q**2), np.tanh(q * a / 2)
    integral = 2 * ((a / 2) / q - th / q**2)
    total = -a * h**3 / 12 + 2 * h * np.sum(coefficient**2 * th / q) + h * a**3 / 12
    total += 4 * np.sum(coefficient * integral / q)
    assert enclosed_liquid_inertia(a, h) == pytest.approx(total / (a * h), abs=1e-9)
    assert enclosed_liquid_inertia(a, h) / ((a**2 + h**2) / 12) == pytest.approx(ratio, abs=6e-5)


def test_enclosed_inertia_of_a_slab_is_that_of_the_frozen_liquid():
    # Between two near walls the liquid can only move with them.
    for a, h in ((1.0, 1e-3), (1e-3, 1.0)):
        assert enclosed_liquid_inertia(a, h) == pytest.approx((a**2 + h**2) / 12, rel=1e-4)


@pytest.mark.parametrize(("number", "depth", "across"), [(1, 0.7, 0.6), (1, 0.2, 3.0), (2, 0.4, 1.0)])
def test_layer_ratio_by_quadrature(number, depth, across):
    """phi = cos(k x) cosh(k z) in a box of side 1: |grad phi|^2 on walls and bottom over that in the volume."""
    k = (2 * number - 1) * np.pi

    def speed_squared(x, z):
        return (k * np.sin(k * x) * np.cosh(k * z)) ** 2 + (k * np.cos(k * x) * np.sinh(k * z)) ** 2

    area = dblquad(speed_squared, 0, depth, 0, 1)[0]
    end_walls = 2 * across * quad(lambda z: speed_squared(0.0, z), 0, depth)[0]
    bottom = across * quad(lambda x: speed_squared(x, 0.0), 0, 1)[0]
    expected = (2 * area + end_walls + bottom) / (across * area)
    mode = _mode(number, along=1.0, across=across, liquid_height=depth, direction="x")
    assert mode.layer_ratio == pytest.approx(expected, rel=1e-9)


def test_damping_default_and_override():
    modes = BOX.slosh_modes(WATER, 0.049, 2)
    assert modes.oscillators[0].damping == pytest.approx(boundary_layer_damping(WATER, BOX, 0.049), rel=1e-12)
    assert modes.oscillators[0].damping > Cylinder(0.035, 0.1).slosh_modes(WATER, 0.049, 1).oscillators[0].damping
    # A narrower box has more wall for its liquid.
    assert boundary_layer_damping(WATER, Box(0.07, 0.02, 0.1), 0.049) > boundary_layer_damping(WATER, BOX, 0.049)
    # The ratio that is given is the slowest mode's, whichever side is the longer.
    for box, slowest in ((BOX, 0), (Box(0.05, 0.07, 0.12), 1)):
        assert box.slosh_modes(WATER, 0.049, 2, 0.01).oscillators[slowest].damping == pytest.approx(0.01, rel=1e-14)
