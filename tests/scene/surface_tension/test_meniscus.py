"""Meniscus of a liquid that wets its vessel: limits of small and large vessels, weight of what is lifted."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.containers.vessels import Profile, Tapered
from nospill.scene.liquids import LIQUIDS
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from nospill.scene.surface_tension.meniscus import meniscus, meniscus_in, plane_wall_rise, slope_at_wall

WATER = LIQUIDS["water"]
LENGTH = math.sqrt(WATER.surface_tension / (WATER.density * STANDARD_GRAVITY))


def test_in_a_hair_tube_it_is_a_hemisphere() -> None:
    radius = 1e-4
    found = meniscus(WATER, radius)
    assert found.rise == pytest.approx(2 / 3 * radius, rel=1e-3)
    assert found.drop == pytest.approx(radius / 3, rel=1e-3)


def test_far_from_everything_it_is_that_of_a_plane_wall() -> None:
    found = meniscus(WATER, 1.0)
    assert found.rise == pytest.approx(plane_wall_rise(WATER), rel=0.01) and found.drop == pytest.approx(0.0, abs=2e-5)


@pytest.mark.parametrize(("radius", "angle"), [(0.004, 0.0), (0.008, 0.0), (0.012, 0.0), (0.004, 60.0), (0.008, 30.0)])
def test_against_a_collocation_of_the_whole_surface(radius: float, angle: float) -> None:
    """By arc length s from the axis to the wall, the surface's length and its height there unknown."""
    slope = math.pi / 2 - math.radians(angle)

    def rates(s: np.ndarray, y: np.ndarray, p: np.ndarray) -> np.ndarray:
        r, u, psi = y
        turn = np.where(r > 1e-12, u / LENGTH**2 - np.sin(psi) / np.maximum(r, 1e-12), u / LENGTH**2 / 2)
        return p[0] * np.vstack([np.cos(psi), np.sin(psi), turn])

    def ends(a: np.ndarray, b: np.ndarray, p: np.ndarray) -> np.ndarray:
        return np.array([a[0], a[2], b[0] - radius, b[2] - slope])

    s = np.linspace(0.0, 1.0, 60)
    guess = np.vstack([radius * s, LENGTH * np.exp(5 * (s - 1)) + 1e-4, slope * s**3])
    solved = solve_bvp(rates, ends, s, guess, p=[1.3 * radius], tol=1e-6, max_nodes=20000)
    assert solved.status == 0
    found, mean = meniscus(WATER, radius, math.radians(angle)), 2 * LENGTH**2 * math.sin(slope) / radius
    assert found.rise == pytest.approx(solved.y[1, -1] - mean, rel=1e-3)
    assert found.drop == pytest.approx(mean - solved.y[1, 0], rel=1e-3)


def test_without_surface_tension_it_is_flat() -> None:
    assert meniscus(replace(WATER, surface_tension=0.0), 0.01) == (0.0, 0.0)


def test_a_liquid_that_does_not_wet_is_the_mirror_image() -> None:
    for angle in (0.0, 0.7, 1.4, math.pi / 2):
        wetting, other = meniscus(WATER, 0.008, angle), meniscus(WATER, 0.008, math.pi - angle)
        assert other == pytest.approx((-wetting.rise, -wetting.drop))
        assert plane_wall_rise(WATER, math.pi - angle) == pytest.approx(-plane_wall_rise(WATER, angle))
    assert meniscus(WATER, 0.008, math.pi / 2) == (0.0, 0.0)


def test_a_wall_that_leans_turns_the_angle() -> None:
    """At 90 deg less the lean the surface is flat; one that would overhang stops short of it."""
    cup = Tapered(bottom_radius=0.006, top_radius=0.009, height=0.03)
    lean = math.atan(0.1)
    assert cup.meridian.lean(0.02) == pytest.approx(lean)
    assert meniscus_in(cup, WATER, 0.02, math.pi / 2 - lean) == (0.0, 0.0)
    upright = Cylinder(0.008, 0.03)
    assert meniscus_in(cup, WATER, 0.02, 1.0) == pytest.approx(meniscus_in(upright, WATER, 0.02, 1.0 + lean))
    closing = Profile(profile=((0.0, 0.0), (0.01, 0.0), (0.007, 0.03)))
    assert slope_at_wall(closing.meridian.lean(0.02), 0.0) < math.pi / 2
    assert 0.0 < meniscus_in(closing, WATER, 0.02, 0.0).rise < meniscus(WATER, closing.section(0.02).radius).rise
