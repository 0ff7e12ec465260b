"""Modes of a body of revolution against exact and classical values, closed forms of the cylinder, and identities."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.errors import ScenarioError
from nospill.scene.containers.cylinder import Cylinder, published_damping
from nospill.scene.containers.vessel import Vessel
from nospill.scene.containers.vessels import Profile, Tapered, WineGlass
from nospill.scene.liquids import LIQUIDS
from nospill.scene.meridian import Meridian, arc
from nospill.scene.sloshing.meridian_mesh import mesh_liquid
from nospill.scene.sloshing.modes import STANDARD_GRAVITY, SloshModes
from nospill.scene.sloshing.revolved_modes import solve_modes
from tests.builders import VESSELS

WATER = LIQUIDS["water"]
ROUND = Profile(profile=((0.0, 0.0), (0.035, 0.0), (0.035, 0.0991)))
CUP = Cylinder(0.035, 0.0991)
HEMISPHERE = Meridian((arc((0.0, 0.05), (0.05, 0.05), (-math.pi / 2, 0.0)),))

vessels = st.sampled_from(sorted(VESSELS))
fills = st.floats(0.15, 0.9)


def level_at(vessel: Vessel, fill: float) -> float:
    return vessel.meridian.bottom + fill * (vessel.height - vessel.meridian.bottom)


def geometry(modes: SloshModes) -> np.ndarray:
    """Curvature, mass, height and wall height per displacement of every mode, (n, 4)."""
    return np.array([(mode.curvature, mode.mass, mode.height, mode.surface_gain) for mode in modes.oscillators])


@pytest.mark.parametrize("level", [0.01, 0.0175, 0.035, 0.049, 0.09])
def test_upright_wall_gives_the_cylinder(level: float) -> None:
    found, exact = ROUND.slosh_modes(WATER, level, 3), CUP.slosh_modes(WATER, level, 3)
    np.testing.assert_allclose(geometry(found)[0], geometry(exact)[0], rtol=3e-5, atol=1e-8)
    np.testing.assert_allclose(geometry(found), geometry(exact), rtol=8e-4)
    np.testing.assert_allclose(geometry(found)[:, :2], geometry(exact)[:, :2], rtol=2e-4)
    assert found.liquid_mass == pytest.approx(exact.liquid_mass, rel=1e-13)
    assert found.fixed_mass == pytest.approx(exact.fixed_mass, rel=1e-4)
    assert found.fixed_height == pytest.approx(exact.fixed_height, rel=1e-4)
    np.testing.assert_allclose(found.fixed_inertia, exact.fixed_inertia, rtol=1e-3)
    np.testing.assert_allclose(found.quasi_static_gain, exact.quasi_static_gain, rtol=1e-13)


def test_twenty_modes_of_the_cylinder() -> None:
    found, exact = geometry(ROUND.slosh_modes(WATER, 0.049, 20)), geometry(CUP.slosh_modes(WATER, 0.049, 20))
    np.testing.assert_allclose(found[:8], exact[:8], rtol=1.5e-3)
    np.testing.assert_allclose(found, exact, rtol=1e-2)


def test_cone_of_forty_five_degrees_is_exact() -> None:
    """phi = x z: omega^2 = g/h, m_1 = 3/4 of the liquid, 0.6 h above the apex, the wall rises with the mass."""
    cone = Profile(profile=((0.0, 0.0), (0.08, 0.08)), base_radius=0.03)
    modes = cone.slosh_modes(WATER, 0.05, 3)
    first = modes.oscillators[0]
    assert first.curvature == pytest.approx(20.0, rel=1e-9)
    assert first.mass / modes.liquid_mass == pytest.approx(0.75, rel=1e-9)
    assert first.height == pytest.approx(0.03, rel=1e-9)
    assert first.surface_gain == pytest.approx(1.0, rel=1e-9)
    assert all(abs(mode.mass) < 1e-12 * modes.liquid_mass and mode.height == 0.05 for mode in modes.oscillators[1:])


def test_hemisphere() -> None:
    """kappa R = 1.5602 for a full hemisphere, as published."""
    found = solve_modes(HEMISPHERE, 0.05, 40)
    assert 0.05 * found.curvature[0] == pytest.approx(1.5602, rel=5e-5)


@pytest.mark.parametrize(
    ("meridian", "level"),
    [(HEMISPHERE, 0.05), (VESSELS["tapered"].meridian, 0.08), (ROUND.meridian, 0.049)],
    ids=["hemisphere", "tapered", "cylinder"],
)
def test_errors_fall_with_the_fourth_power_of_the_elements_size(meridian: Meridian, level: float) -> None:
    found = [solve_modes(meridian, level, 12 * by, 0.5 * by) for by in (1, 2, 4)]
    for key in ("curvature", "volume", "height"):
        value = np.array([getattr(item, key)[0] for item in found])
        coarse, fine = np.abs(np.diff(value)) / value[-1]
        assert fine < 2e-6
        assert math.log2(coarse / fine) > 3.4, key


@pytest.mark.slow
@settings(max_examples=14, deadline=None)
@given(vessels, fills, st.integers(1, 4))
def test_sums_of_mass_moment_and_inertia(shape: str, fill: float, count: int) -> None:
    vessel = VESSELS[shape]
    level = level_at(vessel, fill)
    modes = vessel.slosh_modes(WATER, level, count)
    solid = vessel.frozen(modes.liquid_mass, level)
    masses = np.array([modes.fixed_mass, *(mode.mass for mode in modes.oscillators)])
    heights = np.array([modes.fixed_height, *(mode.height for mode in modes.oscillators)])
    assert modes.liquid_mass == pytest.approx(WATER.density * vessel.volume(level), rel=1e-12)
    assert np.all(masses > 0.0)
    assert masses.sum() == pytest.approx(modes.liquid_mass, rel=1e-12)
    assert masses @ heights == pytest.approx(modes.liquid_mass * solid.centre[2], rel=1e-12)
    # An ideal liquid is turned with less than the inertia of the frozen one [Kelvin].
    turned = modes.fixed_inertia[0] + masses @ (heights - solid.centre[2]) ** 2
    assert 0.0 < turned < solid.inertia[0, 0] * (1 + 1e-6)
    assert all(mode.directions == ("x", "y") for mode in modes.oscillators)
    frequencies = [mode.frequency for mode in modes.oscillators]
    assert frequencies == sorted(frequencies)


@pytest.mark.parametrize("shape", sorted(VESSELS))
def test_all_modes_of_the_elements_make_the_level_plane(shape: str) -> None:
    """sum C_n/P_n is the radius, sum m_n/P_n the second moment of the surface's area; exact for elements."""
    vessel = VESSELS[shape]
    level = level_at(vessel, 0.5)
    mesh = mesh_liquid(vessel.meridian, level, 40)
    own = np.unique(mesh.surface)
    found = solve_modes(vessel.meridian, level, 40, modes=len(own))
    radius = vessel.section(level).radius
    assert np.sum(found.surface_gain / found.curvature) == pytest.approx(radius, rel=1e-9)
    assert np.sum(found.volume / found.curvature) == pytest.approx(math.pi * radius**4 / 4, rel=1e-12)


@pytest.mark.parametrize("shape", sorted(VESSELS))
def test_mesh_is_the_liquid(shape: str) -> None:
    vessel = VESSELS[shape]
    level = level_at(vessel, 0.6)
    for elements in (10, 40, 80):
        mesh = mesh_liquid(vessel.meridian, level, elements)
        first, second, third = (mesh.nodes[mesh.triangles[:, corner]] for corner in range(3))
        area = np.cross(np.c_[second - first, 0 * first[:, 0]], np.c_[third - first, 0 * first[:, 0]])[:, 2]
        assert np.all(area > 0.0)
        np.testing.assert_array_equal(mesh.nodes[mesh.surface][..., 1], level)
        assert mesh.nodes[mesh.wall[0, 0], 0] == 0.0
        assert mesh.nodes[mesh.wall[-1, 1]] == pytest.approx((vessel.section(level).radius, level))
        on_wall = mesh.nodes[np.unique(mesh.wall)]
        flat = np.isclose(on_wall[:, 1], vessel.meridian.bottom) | np.isclose(on_wall[:, 1], 0.02)
        np.testing.assert_allclose(
            on_wall[~flat, 0], [vessel.meridian.radius(z) for z in on_wall[~flat, 1]], rtol=1e-6, atol=1e-9
        )


@settings(max_examples=20, deadline=None)
@given(st.floats(0.5, 2.5), st.tuples(*[st.floats(-1.0, 1.0)] * 2), st.floats(0.3, 0.8))
def test_force_and_moment_of_small_motions_as_in_a_cylinder(fill, amplitudes, share) -> None:
    """Harmonic surge and pitch about the bottom below resonance: what the masses do to the container."""
    level = 0.035 * fill
    cup, vessel = Cylinder(0.035, 0.2), Profile(profile=((0.0, 0.0), (0.035, 0.0), (0.035, 0.2)))
    modes = [item.slosh_modes(WATER, level, 3) for item in (cup, vessel)]
    rate = share * modes[0].oscillators[0].frequency
    surge, pitch = 0.01 * amplitudes[0], 0.05 * amplitudes[1]
    exact, found = (harmonic_load(item, rate, surge, pitch) for item in modes)
    scale = np.array((1.0, level)) * modes[0].liquid_mass * (rate**2 * (0.01 + 0.05 * level) + 0.05 * STANDARD_GRAVITY)
    assert np.all(np.abs(found - exact) <= 1e-3 * scale)


def harmonic_load(modes: SloshModes, rate: float, surge: float, pitch: float) -> np.ndarray:
    """Force along x and moment about y at the bottom, amplitudes, of surge and pitch that go as cos(rate t)."""
    g = STANDARD_GRAVITY
    lateral = -(rate**2) * surge - g * pitch
    force, moment = modes.fixed_mass * (lateral - rate**2 * modes.fixed_height * pitch), 0.0
    moment += modes.fixed_height * force - modes.fixed_inertia[0] * rate**2 * pitch
    for mode in modes.oscillators:
        at_mass = lateral - rate**2 * mode.height * pitch
        q = -at_mass / (mode.frequency**2 - rate**2)
        pull = mode.mass * (at_mass - rate**2 * q)
        force += pull
        moment += mode.height * pull - mode.mass * g * q
    return np.array((force, moment))


@pytest.mark.parametrize("fill", [0.5, 0.75, 1.0, 1.4, 2.0, 2.8])
def test_damping_of_the_boundary_layers_is_that_of_the_published_formula(fill: float) -> None:
    vessel = Profile(profile=((0.0, 0.0), (0.035, 0.0), (0.035, 0.2)))
    found = vessel.slosh_modes(WATER, fill * 0.035, 1).oscillators[0].damping
    assert found == pytest.approx(published_damping(WATER, 0.035, fill * 0.035), rel=0.1)


def test_layers_are_those_of_the_cylinders_closed_form() -> None:
    root = 1.8411837813406595
    found = solve_modes(ROUND.meridian, 0.049, 40)
    assert found.layer_ratio[0] == pytest.approx(CUP._mode(root, 1.4).layer_ratio, rel=1e-3)
    assert found.wave_number[0] == pytest.approx(root / 0.035, rel=1e-5)


def test_damping_can_be_stated_and_honey_is_refused() -> None:
    vessel = VESSELS["tapered"]
    stated = vessel.slosh_modes(WATER, 0.08, 3, damping=0.02)
    usual = vessel.slosh_modes(WATER, 0.08, 3)
    assert stated.oscillators[0].damping == pytest.approx(0.02)
    for one, other in zip(stated.oscillators, usual.oscillators, strict=True):
        assert one.damping / 0.02 == pytest.approx(other.damping / usual.oscillators[0].damping)
    with pytest.raises(ScenarioError, match="above 0 and at most the rim"):
        vessel.slosh_modes(WATER, 0.12, 1)
    with pytest.raises(ScenarioError, match="liquid_height 90 mm is not above the inside's bottom"):
        VESSELS["wine-glass"].slosh_modes(WATER, 0.09, 1)


def test_a_stem_lifts_everything_and_changes_nothing_else() -> None:
    low, high = (
        WineGlass(radius=0.04, rim_radius=0.03, bowl_height=0.09, height=height, base_radius=0.035)
        for height in (0.09, 0.19)
    )
    below, above = low.slosh_modes(WATER, 0.05, 2), high.slosh_modes(WATER, 0.15, 2)
    np.testing.assert_allclose(geometry(above), geometry(below) + np.array((0, 0, 0.1, 0)), rtol=1e-8)
    assert above.fixed_height == pytest.approx(below.fixed_height + 0.1, rel=1e-8)
    np.testing.assert_allclose(above.fixed_inertia, below.fixed_inertia, rtol=1e-5, atol=1e-12)


def test_scale_of_length() -> None:
    small, large = (
        Tapered(bottom_radius=0.03 * by, top_radius=0.045 * by, height=0.11 * by).slosh_modes(WATER, 0.08 * by, 3)
        for by in (1.0, 10.0)
    )
    np.testing.assert_allclose(geometry(large), geometry(small) * (0.1, 1e3, 10.0, 1.0), rtol=1e-7)


@pytest.mark.parametrize(
    ("shape", "fill", "ratio"),
    [
        ("tapered", 0.6, 1.0),
        ("bowl", 0.6, 1.0),
        ("test-tube", 0.6, 1.0),
        ("wine-glass", 0.8, 1.020),
        ("conical-flask", 0.6, 1.036),
        ("round-flask", 0.6, 1.312),
    ],
)
def test_the_first_mode_is_highest_inside_where_the_wall_closes(shape: str, fill: float, ratio: float) -> None:
    """At the wall of vessels that do not, as proven for those."""
    found = solve_modes(VESSELS[shape].meridian, level_at(VESSELS[shape], fill), 40)
    assert found.crest_gain[0] / found.surface_gain[0] == pytest.approx(ratio, abs=2e-3 if ratio > 1.0 else 1e-12)


def test_solved_once_for_a_vessel_and_a_level() -> None:
    vessel = Tapered(bottom_radius=0.0301, top_radius=0.045, height=0.11)
    vessel.slosh_modes(WATER, 0.08, 1)
    before = solve_modes.cache_info()
    same = Tapered(bottom_radius=0.0301, top_radius=0.045, height=0.11)
    for liquid, damping in ((WATER, 0.01), (LIQUIDS["milk"], None)):
        same.slosh_modes(liquid, 0.08, 2, damping)
    after = solve_modes.cache_info()
    assert (after.misses, after.hits) == (before.misses, before.hits + 2)
