"""Modes below a curved surface: closed forms at a right angle, an oracle in Bessel functions, a sphere, the rest."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_bvp
from scipy.linalg import eigh
from scipy.special import jnp_zeros, jv, jvp

from nospill.errors import ModelError
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.containers.vessels import Profile, Tapered, TestTube
from nospill.scene.liquids import LIQUIDS
from nospill.scene.meridian import Meridian
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from nospill.scene.surface_tension.curved_modes import CurvedModes, curved_modes, solve_curved
from nospill.scene.surface_tension.meniscus import capillary_length, rest_surface
from nospill.scene.surface_tension.tension import ContactLine, liquid_modes

WATER = LIQUIDS["water"]
LENGTH = capillary_length(WATER)
RADIUS, LEVEL = 0.008, 0.016
VIAL = Meridian((((0.0, 0.0), (RADIUS, 0.0)), ((RADIUS, 0.0), (RADIUS, 4 * RADIUS))))
VESSELS = (
    TestTube(radius=RADIUS, height=0.03, base_radius=RADIUS),
    Tapered(bottom_radius=0.007, top_radius=0.009, height=0.03),
)


def squares(modes: CurvedModes) -> np.ndarray:
    return STANDARD_GRAVITY * (modes.curvature + modes.tension)


@pytest.mark.parametrize("radius", [0.004, 0.008, 0.012])
def test_at_a_right_angle_they_are_those_of_the_flat_surface(radius: float) -> None:
    cup = Cylinder(radius, 4 * radius)
    lines: tuple[tuple[ContactLine, float], ...] = (("free", 1e-5), ("pinned", 1e-3))
    for line, close in lines:
        flat = liquid_modes(cup, WATER, 2 * radius, 1, contact_line=line)
        found = liquid_modes(cup, WATER, 2 * radius, 1, contact_line=line, contact_angle=math.pi / 2)
        own, other = found.oscillators[0], flat.oscillators[0]
        assert own.frequency == pytest.approx(other.frequency, rel=close)
        assert own.stiffness == pytest.approx(other.stiffness, rel=1e-5)
        assert (own.mass, own.height, own.surface_gain, own.damping) == pytest.approx(
            (other.mass, other.height, other.surface_gain, other.damping), rel=1e-5
        )
        assert found.quasi_static_gain == pytest.approx(flat.quasi_static_gain, rel=1e-5)
        assert found.fixed_height == pytest.approx(flat.fixed_height, rel=1e-5)
        assert found.fixed_inertia == pytest.approx(flat.fixed_inertia, rel=1e-4)


@pytest.mark.parametrize("angle", [60.0, 120.0])
def test_against_bessel_functions_below_the_curved_surface(angle: float) -> None:
    """Rayleigh and Ritz: potentials J_1(k r) cosh k z and surfaces J_1(k r), integrals along the surface alone."""
    surface = rest_surface(LENGTH, RADIUS, math.pi / 2 - math.radians(angle))
    nodes, weights = np.polynomial.legendre.leggauss(400)
    r, dr = RADIUS * (nodes + 1) / 2, RADIUS * weights / 2
    f = np.interp(r, surface.radius, surface.height)
    slope = np.gradient(surface.height, surface.radius, edge_order=2)
    df = np.interp(r, surface.radius, slope)
    width = np.sqrt(1 + df**2)
    k = jnp_zeros(1, 14)[:, None] / RADIUS
    shape, along = jv(1, k * r), k * jvp(1, k * r)
    # cosh k(z + h)/cosh k h and its slope, on the surface
    high = np.cosh(k * (LEVEL + f)) / np.cosh(k * LEVEL)
    steep = k * np.sinh(k * (LEVEL + f)) / np.cosh(k * LEVEL)
    flow = (shape * high * r * dr) @ (shape * steep - df * along * high).T
    moved = (shape * high * r * dr) @ shape.T
    kinetic = moved.T @ np.linalg.solve((flow + flow.T) / 2, moved)
    spring = (shape * r * dr) @ shape.T
    tension = (along / width**3 * r * dr) @ along.T + (shape / r**2 / width * r * dr) @ shape.T
    ratio = WATER.surface_tension / WATER.density
    exact = 1.0 / eigh(kinetic, STANDARD_GRAVITY * spring + ratio * tension, eigvals_only=True)[::-1][:2]
    assert squares(curved_modes(VIAL, LEVEL, 2, LENGTH, math.radians(angle)))[:2] == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("angle", [30.0, 60.0, 120.0])
def test_the_rest_surface_that_leans_is_that_of_young_and_laplace(angle: float) -> None:
    """(r n'/W^3)' = n/(r W) + r (n + x)/c^2 for a lean of one, square to the wall, by collocation."""
    surface = rest_surface(LENGTH, RADIUS, math.pi / 2 - math.radians(angle))
    slope = np.gradient(surface.height, surface.radius, edge_order=2)

    def rates(r: np.ndarray, y: np.ndarray) -> np.ndarray:
        width = np.sqrt(1 + np.interp(r, surface.radius, slope) ** 2)
        return np.vstack([y[1] * width**3 / r, y[0] / (r * width) + r * (y[0] + r) / LENGTH**2])

    r = np.linspace(1e-6, RADIUS, 200)
    start = np.vstack([-0.6 * r, 0 * r])
    solved = solve_bvp(rates, lambda a, b: np.array([a[0], b[1]]), r, start, tol=1e-6, max_nodes=20000)
    assert solved.status == 0
    found = curved_modes(VIAL, LEVEL, 1, LENGTH, math.radians(angle))
    assert found.quasi_static_gain == pytest.approx(-solved.y[0, -1], rel=2e-3)


@pytest.mark.parametrize("part", [0.6, 1.0, 1.5])
def test_a_plane_surface_turns_freely_in_a_sphere(part: float) -> None:
    """It keeps its angle and its area, so that surface tension does not hold it, however strong."""
    radius, turn = 0.02, np.linspace(-math.pi / 2, 1.2, 80)
    points = [(max(radius * math.cos(a), 0.0), radius * (1 + math.sin(a))) for a in turn.tolist()]
    ball = Profile(profile=tuple(points), profile_spline=True, base_radius=0.005).meridian
    level = part * radius
    flat = math.pi / 2 - ball.lean(level)
    for length in (LENGTH, 2 * LENGTH):
        found = curved_modes(ball, level, 1, length, flat)
        assert found.quasi_static_gain == pytest.approx(ball.radius(level), rel=1e-3)


@pytest.mark.parametrize("vessel", VESSELS, ids=["test-tube", "tapered"])
def test_other_vessels_are_near_the_vial_and_converge(vessel: TestTube | Tapered) -> None:
    for angle, close in ((0.0, 2e-3), (60.0, 1e-5), (120.0, 1e-5)):
        coarse, fine = (solve_curved(vessel.meridian, 0.015, n, LENGTH, math.radians(angle)) for n in (40, 80))
        assert squares(coarse)[0] == pytest.approx(squares(fine)[0], rel=close)
        assert coarse.pinned[0] == pytest.approx(fine.pinned[0], rel=20 * close)
        assert coarse.volume[0] == pytest.approx(fine.volume[0], rel=close)
        near = curved_modes(VIAL, LEVEL, 1, LENGTH, math.radians(angle))
        assert squares(coarse)[0] == pytest.approx(squares(near)[0], rel=0.05)
        assert squares(coarse)[0] < STANDARD_GRAVITY * coarse.pinned[0]


def test_the_liquid_as_a_whole_stays_what_it_is() -> None:
    cup = Cylinder(RADIUS, 0.03)
    flat = liquid_modes(cup, WATER, LEVEL, 3, contact_line="free")
    found = liquid_modes(cup, WATER, LEVEL, 3, contact_line="free", contact_angle=1.0)
    for modes in (flat, found):
        parts = [(modes.fixed_mass, modes.fixed_height), *((m.mass, m.height) for m in modes.oscillators)]
        assert sum(mass for mass, _ in parts) == pytest.approx(modes.liquid_mass)
        assert sum(mass * height for mass, height in parts) == pytest.approx(modes.liquid_mass * LEVEL / 2)
    inertias = [
        modes.fixed_inertia
        + modes.fixed_mass * modes.fixed_height**2
        + sum(m.mass * m.height**2 for m in modes.oscillators)
        for modes in (flat, found)
    ]
    assert inertias[1] == pytest.approx(inertias[0])


def test_too_shallow_for_its_meniscus() -> None:
    with pytest.raises(ModelError, match=r"meniscus is 2.7 mm high and the liquid 4 mm deep"):
        curved_modes(VIAL, 0.004, 1, LENGTH, 0.0)


def test_low_in_a_round_bottom_the_mesh_stays_the_right_way_round() -> None:
    """The meniscus reaches a third of the depth; a mesh that is turned inside out is refused by itself."""
    tube = TestTube(radius=0.0075, height=0.03, base_radius=0.0075).meridian
    for level in (0.0075, 0.009, 0.0113):
        for angle in (0.0, 60.0, 180.0):
            coarse, fine = (solve_curved(tube, level, n, LENGTH, math.radians(angle)) for n in (40, 80))
            assert squares(coarse)[0] == pytest.approx(squares(fine)[0], rel=5e-3)
