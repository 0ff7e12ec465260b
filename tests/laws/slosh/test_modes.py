"""The modal record: what it derives from its own fields."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.scene.containers import CONTAINERS, Box, Cylinder
from nospill.scene.liquids import LIQUIDS
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from tests.builders import VESSELS

WATER = LIQUIDS["water"]


def test_stiffness_is_free_of_gravity():
    for container in (Cylinder(0.035, 0.1), Box(0.07, 0.05, 0.1)):
        for mode in container.slosh_modes(WATER, 0.049, 3).oscillators:
            assert mode.stiffness == pytest.approx(mode.wave_number * np.tanh(mode.wave_number * 0.049), rel=1e-13)
            assert mode.stiffness * STANDARD_GRAVITY == pytest.approx(mode.frequency**2, rel=1e-14)


@pytest.mark.slow
@settings(max_examples=12, deadline=None)
@given(st.sampled_from(sorted(CONTAINERS)), st.floats(0.1, 3.0), st.integers(1, 8), st.floats(0.01, 0.5))
def test_static_tilt_gives_the_flat_surface(shape, fill, count, angle):
    """Lateral over axial gravity tan(angle): modes carried and correction make the reach times it."""
    container = {"cylinder": Cylinder(0.04, 1.0), "box": Box(0.08, 0.06, 1.0), **VESSELS}[shape]
    bottom = container.inside[0, 1]
    level = bottom + fill / 3.1 * (container.height - bottom)
    modes = container.slosh_modes(WATER, level, count)
    reach = container.section(level).half_lengths
    lateral, axial = STANDARD_GRAVITY * np.sin(angle), STANDARD_GRAVITY * np.cos(angle)
    for index, axis in enumerate(("x", "y")):
        # Equilibrium of the linear law at rest: a_x + P a_z q = 0.
        height = sum(
            mode.surface_gain * -lateral / (mode.stiffness * axial)
            for mode in modes.oscillators
            if axis in mode.directions
        )
        height -= modes.static_correction[index] * lateral / axial
        assert height == pytest.approx(-reach[index] * np.tan(angle), rel=1e-12)


def test_static_correction_of_one_mode_of_a_cup():
    modes = Cylinder(0.035, 0.1).slosh_modes(WATER, 0.049, 1)
    np.testing.assert_allclose(modes.static_correction, 0.035 * (1 - 0.836835), rtol=3e-6)


def test_the_record_is_frozen():
    modes = Cylinder(0.035, 0.1).slosh_modes(WATER, 0.049, 1)
    with pytest.raises(dataclasses.FrozenInstanceError):
        modes.fixed_mass = 0.0  # type: ignore[misc]
