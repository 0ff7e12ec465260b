"""Surface tension against closed forms: a free contact line exactly, a pinned one by its own series."""

from __future__ import annotations

import math

import numpy as np
import pytest

from nospill.scene.containers.box import Box
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.containers.vessels import Profile, Tapered
from nospill.scene.liquids import LIQUIDS, Liquid
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from nospill.scene.surface_tension.meniscus import plane_wall_rise
from nospill.scene.surface_tension.tension import liquid_modes

WATER = LIQUIDS["water"]
RATIO = WATER.surface_tension / WATER.density


@pytest.mark.parametrize(("radius", "factor"), [(5.0, 1.42), (7.5, 1.20), (10.0, 1.12), (20.0, 1.03), (35.0, 1.01)])
def test_a_free_line_raises_the_first_frequency_as_lamb_says(radius: float, factor: float) -> None:
    radius *= 1e-3
    cup = Cylinder(radius, 3 * radius)
    free = liquid_modes(cup, WATER, 2 * radius, 3, contact_line="free").oscillators
    plain = liquid_modes(cup, WATER, 2 * radius, 3).oscillators
    assert free[0].frequency / plain[0].frequency == pytest.approx(factor, abs=0.006)
    for mode, without in zip(free, plain, strict=True):
        k = mode.wave_number
        exact = (STANDARD_GRAVITY * k + RATIO * k**3) * math.tanh(2 * k * radius)
        assert mode.frequency**2 == pytest.approx(exact, rel=1e-12)
        assert mode.stiffness == pytest.approx(without.stiffness, rel=1e-12)
        assert (mode.mass, mode.height, mode.surface_gain) == (without.mass, without.height, without.surface_gain)


@pytest.mark.parametrize("radius", [0.004, 0.008, 0.012])
def test_a_vial_as_a_profile_is_the_cylinder(radius: float) -> None:
    profile = ((0.0, 0.0), (radius, 0.0), (radius, 4 * radius))
    for line in ("free", "pinned"):
        exact = liquid_modes(Cylinder(radius, 4 * radius), WATER, 2 * radius, 2, contact_line=line)
        found = liquid_modes(Profile(profile=profile), WATER, 2 * radius, 2, contact_line=line)
        for own, other in zip(found.oscillators, exact.oscillators, strict=True):
            assert own.frequency == pytest.approx(other.frequency, rel=2e-3)
        assert found.quasi_static_gain == pytest.approx(exact.quasi_static_gain, rel=1e-6)


@pytest.mark.parametrize("container", [Cylinder(0.008, 0.03), Box(0.02, 0.012, 0.03)], ids=["cylinder", "box"])
def test_the_rest_surface_is_the_sum_of_its_modes(container: Cylinder | Box) -> None:
    """What a leaning gravity makes of the surface, in closed form and mode by mode."""
    modes = liquid_modes(container, WATER, 0.015, 300, contact_line="free")
    plain = liquid_modes(container, WATER, 0.015, 300)
    assert np.all(np.abs(modes.static_correction) < 2e-3 * modes.quasi_static_gain)
    assert np.all(modes.quasi_static_gain < 0.85 * plain.quasi_static_gain)
    still = liquid_modes(Cylinder(0.5, 1.0), WATER, 0.5, 1, contact_line="free").quasi_static_gain
    assert still == pytest.approx(0.5 - math.sqrt(RATIO / STANDARD_GRAVITY), rel=1e-4)


@pytest.mark.parametrize("radius", [0.004, 0.008, 0.012, 0.035])
def test_a_pinned_line_lies_between_two_free_ones(radius: float) -> None:
    cup = Cylinder(radius, 4 * radius)
    free = liquid_modes(cup, WATER, 2 * radius, 4, contact_line="free").oscillators
    pinned = liquid_modes(cup, WATER, 2 * radius, 3, contact_line="pinned").oscillators
    for mode, low, high in zip(pinned, free[:-1], free[1:], strict=True):
        assert low.frequency < mode.frequency < high.frequency
        assert mode.stiffness == pytest.approx(low.stiffness, rel=1e-9)


def test_a_pinned_line_is_that_of_its_own_shapes() -> None:
    """Rayleigh and Ritz with shapes that vanish at the wall bound the frequency of deep liquid from above, closely.

    Shapes J_1(j x)/j with the zeros j of J_1: kinetic and potential energies by the free line's modes.
    """
    from scipy.special import jn_zeros, jnp_zeros, jv

    radius = 0.008
    xi, roots = jnp_zeros(1, 400), jn_zeros(1, 30)
    # J_1(j x) in J_1(xi x), both over the unit disc: integral of x J_1(j x) J_1(xi x), and the norm of the latter.
    norm = 0.5 * (1 - 1 / xi**2) * jv(1, xi) ** 2
    share = -roots[:, None] * jv(0, roots)[:, None] * jv(1, xi) / (roots[:, None] ** 2 - xi**2) * -1.0 / norm
    kinetic = np.einsum("in,jn,n->ij", share, share, norm / xi) * radius
    own = 0.5 * jv(0, roots) ** 2
    potential = np.diag(own * (STANDARD_GRAVITY + RATIO * (roots / radius) ** 2))
    ritz = math.sqrt(np.min(np.linalg.eigvals(np.linalg.solve(kinetic, potential)).real))
    found = liquid_modes(Cylinder(radius, 0.1), WATER, 0.08, 1, contact_line="pinned").oscillators[0].frequency
    assert found == pytest.approx(ritz, rel=0.01)


def test_without_tension_there_is_none() -> None:
    oil = Liquid("oil", 900.0, 1e-6, 0.0)
    cup = Tapered(bottom_radius=0.03, top_radius=0.04, height=0.1)
    for line in ("free", "pinned"):
        found, plain = liquid_modes(cup, oil, 0.06, 1, contact_line=line), liquid_modes(cup, oil, 0.06, 1)
        assert found.oscillators == plain.oscillators and plain.oscillators[0].tension == 0.0
    assert plane_wall_rise(WATER) == pytest.approx(3.86e-3, abs=1e-5)
