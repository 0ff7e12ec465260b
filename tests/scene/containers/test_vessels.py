"""Geometry, mass properties and refusals of the bodies of revolution."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.errors import ScenarioError
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.containers.footprints import DiscFootprint
from nospill.scene.containers.vessel import Vessel
from nospill.scene.containers.vessels import Bowl, Profile, RoundFlask, Tapered, TestTube, WineGlass
from tests.builders import VESSELS

lengths = st.floats(0.005, 0.3)


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(sorted(VESSELS)), st.floats(0.01, 1.0))
def test_level_inverts_volume(shape: str, fill: float) -> None:
    vessel = VESSELS[shape]
    bottom = vessel.meridian.bottom
    level = bottom + fill * (vessel.height - bottom)
    assert vessel.level(vessel.volume(level)) == pytest.approx(level, rel=1e-9)
    assert vessel.frozen(1.0, level).mass == 1.0
    assert bottom < vessel.frozen(1.0, level).centre[2] < level


@settings(max_examples=30, deadline=None)
@given(lengths, lengths, lengths, st.floats(0.1, 1.0))
def test_frustum(bottom: float, top: float, height: float, fill: float) -> None:
    cup = Tapered(bottom_radius=bottom, top_radius=top, height=height)
    radius = bottom + fill * (top - bottom)
    assert cup.section(fill * height).radius == pytest.approx(radius, rel=1e-12)
    expected = math.pi * fill * height * (bottom**2 + bottom * radius + radius**2) / 3
    assert cup.volume(fill * height) == pytest.approx(expected, rel=1e-12)


def test_closed_forms_of_spheres() -> None:
    tube = TestTube(radius=0.01, height=0.1, base_radius=0.02)
    assert tube.volume(0.01) == pytest.approx(2 / 3 * math.pi * 1e-6, rel=1e-7)
    half = tube.frozen(1.0, 0.01)
    assert half.centre[2] == pytest.approx(0.01 * 5 / 8, rel=1e-7)
    assert half.inertia[2, 2] == pytest.approx(2 / 5 * 1e-4, rel=1e-7)
    assert half.inertia[0, 0] == pytest.approx((2 / 5 - 9 / 64) * 1e-4, rel=1e-7)
    bowl = Bowl(radius=0.07, bottom_radius=0.03, height=0.06)
    # A spherical segment between two parallel planes.
    assert bowl.volume(0.06) == pytest.approx(math.pi * 0.06 * (3 * 0.07**2 + 3 * 0.03**2 + 0.06**2) / 6, rel=1e-6)
    ball = RoundFlask(radius=0.05, bottom_radius=0.02, neck_radius=0.015, height=0.15)
    assert ball.section(math.sqrt(0.05**2 - 0.02**2)).radius == pytest.approx(0.05, rel=1e-7)


@settings(max_examples=20, deadline=None)
@given(lengths, lengths, st.floats(0.01, 5.0))
def test_upright_profile_is_a_cylinder(radius: float, height: float, mass: float) -> None:
    vessel, cup = Profile(profile=((0.0, 0.0), (radius, 0.0), (radius, height))), Cylinder(radius, height)
    for found, exact in (
        (vessel.solid_properties(mass), cup.solid_properties(mass)),
        (vessel.shell_properties(mass), cup.shell_properties(mass)),
        (vessel.frozen(mass, 0.6 * height), cup.frozen(mass, 0.6 * height)),
    ):
        assert found.mass == exact.mass
        np.testing.assert_allclose(found.centre, exact.centre, rtol=1e-12)
        np.testing.assert_allclose(found.inertia, exact.inertia, rtol=1e-10, atol=1e-15)
    assert vessel.footprint == cup.footprint
    np.testing.assert_allclose(vessel.outline, cup.outline)
    assert vessel.height == cup.height


def test_smooth_profiles_pass_through_their_points_and_keep_corners() -> None:
    points = ((0.0, 0.0), (0.02, 0.0), (0.02, 0.0), (0.035, 0.02), (0.04, 0.05), (0.038, 0.09))
    vessel = Profile(profile=points, profile_spline=True)
    for r, z in points[3:]:
        assert vessel.section(z).radius == pytest.approx(r, rel=1e-12)
    assert vessel.footprint.radius == pytest.approx(0.02)
    assert vessel.section(0.035).radius > np.interp(0.035, (0.02, 0.05), (0.035, 0.04))
    kinked = Profile(profile=tuple(dict.fromkeys(points)))
    assert kinked.section(0.035).radius == pytest.approx(0.0375)


@pytest.mark.parametrize("shape", sorted(VESSELS))
def test_sections_for_drawing(shape: str) -> None:
    vessel = VESSELS[shape]
    for sections, low in ((vessel.inside, vessel.meridian.bottom), (vessel.outside, 0.0)):
        assert not sections.flags.writeable
        assert np.all(np.diff(sections[:, 1]) >= 0.0) and np.all(sections[:, 0] >= 0.0)
        assert sections[0, 1] == pytest.approx(low) and sections[-1, 1] == pytest.approx(vessel.height)
    assert vessel.outside[0, 0] == 1.0
    rim = vessel.section(vessel.height).radius
    assert vessel.inside[-1, 0] * vessel.footprint.radius == pytest.approx(rim)
    assert vessel.outside[-1, 0] * vessel.footprint.radius == pytest.approx(rim + vessel.wall)


def test_a_ring_grips_like_a_ring() -> None:
    """Mean and mean square distance from the middle by sampling."""
    ring = Tapered(bottom_radius=0.03, top_radius=0.04, height=0.1, base_inner_radius=0.02).footprint
    radius = np.sqrt(np.linspace(0.02**2, 0.03**2, 200_001))
    assert ring.twist_radius == pytest.approx(np.mean(radius), rel=1e-6)
    assert ring.grip_radius == pytest.approx(math.sqrt(np.mean(radius**2) / 2), rel=1e-6)
    disc, thin = DiscFootprint(0.03), DiscFootprint(0.03, 0.03 - 1e-9)
    assert (disc.twist_radius, disc.grip_radius) == pytest.approx((0.02, 0.015))
    assert thin.twist_radius == pytest.approx(0.03, rel=1e-6)


def profile(*points: tuple[float, float], **keys: float) -> Vessel:
    return Profile(profile=points, base_radius=0.03, **keys)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: profile((0.001, 0), (0.03, 0), (0.03, 0.1)), "starts at r = 1 mm, z = 0 mm: .* on the axis"),
        (lambda: profile((0, 0), (0.03, 0), (0.03, -0.1)), "goes below zero at r = 30 mm, z = -100 mm"),
        (lambda: profile((0, 0), (0.03, 0.05), (0.04, 0.02), (0.04, 0.1)), "goes down after r = 30 mm, z = 50 mm"),
        (lambda: profile((0, 0), (0.03, 0), (0.04, 0.09), (0.02, 0.06), (0.05, 0.06), (0.05, 0.1)), "crosses itself"),
        (lambda: profile((0, 0), (0.03, 0), (0.03, 0.05), (0, 0.06), (0.02, 0.09)), "comes back to the axis at r = 0"),
        (lambda: profile((0, 0), (0.03, 0), (0.03, 0.05), (0, 0.06)), "the vessel is closed; end at an open rim"),
        (lambda: profile((0, 0), (0.03, 0)), "has no height"),
        (lambda: profile((0, 0), (0.03, 0), (0.03, 0), (0.03, 0.05)), "profile entry 3 repeats the one before"),
        (lambda: profile((0, 0), (0, 0)), "profile entry 2 repeats"),
        (lambda: Profile(profile=((0, 0), (0.03, 0.1))), "base_radius is missing"),
        (lambda: profile((0, 0), (0.03, 0), (0.03, 0.1), wall=-0.001), "wall = -0.001 m"),
        (lambda: profile((0, 0), (0.03, 0), (0.03, 0.1), base_inner_radius=0.03), "base_inner_radius 30 mm is not ins"),
        (lambda: Tapered(bottom_radius=0.0, top_radius=0.04, height=0.1), "bottom_radius = 0 m"),
        (lambda: Bowl(radius=0.03, bottom_radius=0.03, height=0.1), "bottom_radius 30 mm must be below radius 30 mm"),
        (
            lambda: WineGlass(radius=0.03, rim_radius=0.04, bowl_height=0.1, height=0.2, base_radius=0.03),
            "rim_radius 40 mm must be at most radius 30 mm",
        ),
        (
            lambda: RoundFlask(radius=0.05, bottom_radius=0.02, neck_radius=0.015, height=0.09),
            "the ball's top 93.52 mm must be below height 90 mm",
        ),
        (lambda: TestTube(radius=0.01, height=0.1), "base_radius is missing"),
    ],
)
def test_refusals(make, message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        make()


@pytest.mark.parametrize("shape", sorted(VESSELS))
def test_equal_vessels_are_one_key(shape: str) -> None:
    assert hash(VESSELS[shape].meridian) == hash(VESSELS[shape].meridian)
    assert VESSELS[shape].meridian == VESSELS[shape].meridian
