"""Surge and pitch of a cup: heights, force and base moment of the laws against the linear potential solution.

The oracle knows nothing of slosh modes: for a container that swings harmonically it expands the potential in Z_0 =
cosh(K z), K tanh(K h) = sigma = omega^2/g, and Z_j = cos(kappa_j z), kappa_j tan(kappa_j h) = -sigma, each with the
function of x (or r) that meets the wall's velocity. A pitch about the centre of the surface has the particular
potential x (b - z), b = h - 1/sigma, which meets bottom and surface and leaves the wall 2 z - 2 h + 1/sigma. The
pressure is integrated over wall and bottom.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Literal

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ive, jv, jvp, roots_legendre

from nospill.core.frames import FrameMotion, vector
from nospill.core.trees import constants
from nospill.laws.contact import contact_wrench
from nospill.laws.parameters import ObjectNumbers
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.laws.slosh.height import surface_vector
from nospill.laws.slosh.motion import OscillatorState, modal_acceleration
from nospill.laws.structure import ObjectStructure
from nospill.scenario import read_scenario
from nospill.scene.cargo import Cargo, Filling
from nospill.scene.containers import Box, Cylinder
from nospill.scene.containers.base import MassProperties
from nospill.scene.liquids import LIQUIDS
from nospill.scene.sloshing.modes import STANDARD_GRAVITY

WATER = LIQUIDS["water"]
DEPTH = 0.049
TERMS = 400
CONTAINERS = [Cylinder(0.035, 0.1), Box(0.07, 0.05, 0.1)]
Kind = Literal["surge", "pitch"]


@dataclass(frozen=True)
class Response:
    """Height at the wall towards +x (m), force on the tray along x (N), moment about the bottom's centre (N m)."""

    height: float
    force: float
    moment: float


class Section:
    """What the cross-section does to the expansion: functions of x of slope 1 at the wall, and their integrals."""

    def __init__(self, container: Cylinder | Box) -> None:
        self.disc = isinstance(container, Cylinder)
        self.reach = container.radius if isinstance(container, Cylinder) else container.length / 2
        self.width = 0.0 if isinstance(container, Cylinder) else container.width
        self.wall = np.pi * self.reach if self.disc else 2 * self.width
        """Integral of (cos theta) n_x over the wall per unit height."""
        self.second_moment = np.pi * self.reach**4 / 4 if self.disc else 2 * self.width * self.reach**3 / 3

    def propagating(self, k: float) -> tuple[float, float]:
        """Value at the wall and integral of x f over the bottom."""
        if self.disc:
            slope = k * jvp(1, k * self.reach)
            return jv(1, k * self.reach) / slope, np.pi * self.reach**2 * jv(2, k * self.reach) / k / slope
        tangent = np.tan(k * self.reach)
        return tangent / k, 2 * self.width * (tangent / k**2 - self.reach / k) / k

    def evanescent(self, k: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The same for the functions that decay away from the wall."""
        x = k * self.reach
        if self.disc:
            slope = k * (ive(0, x) - ive(1, x) / x)
            return ive(1, x) / slope, np.pi * self.reach**2 * ive(2, x) / k / slope
        return np.tanh(x) / k, 2 * self.width * (self.reach / k - np.tanh(x) / k**2) / k


def root(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a function crosses zero between two bounds."""
    return brentq(function, low, high, xtol=1e-14)  # type: ignore[return-value]


@cache
def gauss_legendre(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points in (-1, 1) and weights of the quadrature: eigenvalues of a tridiagonal matrix, the same for every case."""
    return roots_legendre(count)


@cache
def potential_solution(container: Cylinder | Box, rate: float, kind: Kind) -> Response:
    """Amplitudes per metre of surge or per radian of pitch about the surface's centre."""
    section, h, sigma = Section(container), DEPTH, rate**2 / STANDARD_GRAVITY
    k = root(lambda k: k * np.tanh(k * h) - sigma, 1e-9, 1e5)
    kappa = np.array([
        root(lambda x: x * np.sin(x) + sigma * h * np.cos(x), (j - 0.5) * np.pi, j * np.pi) / h
        for j in range(1, TERMS)
    ])  # fmt: skip
    # Expansion of the wall's velocity offset + slope z in the depth functions.
    slope, offset = (2.0, 1 / sigma - 2 * h) if kind == "pitch" else (0.0, 1.0)
    raised = (offset + slope * h) * np.sinh(k * h) / k - slope * (np.cosh(k * h) - 1) / k**2
    flat = (offset + slope * h) * np.sin(kappa * h) / kappa + slope * (np.cos(kappa * h) - 1) / kappa**2
    first = raised / (h / 2 + np.sinh(2 * k * h) / (4 * k))
    others = flat / (h / 2 + np.sin(2 * kappa * h) / (4 * kappa))
    (wall, bottom), (walls, bottoms) = section.propagating(k), section.evanescent(kappa)

    z, weights = gauss_legendre(1500)
    z, weights = h / 2 * (z + 1), h / 2 * weights
    at_wall = first * wall * np.cosh(k * z) + (others * walls) @ np.cos(np.outer(kappa, z))
    at_rim = first * wall * np.cosh(k * h) + float(np.sum(others * walls * np.cos(kappa * h)))
    on_bottom = first * bottom + float(np.sum(others * bottoms))
    pressure, pressure_moment = rate**2 * at_wall, rate**2 * on_bottom
    height = sigma * at_rim
    if kind == "pitch":
        b = h - 1 / sigma
        # Particular potential, and the weight that leans with the container.
        pressure = pressure + (rate**2 * (b - z) + STANDARD_GRAVITY) * section.reach
        pressure_moment += (rate**2 * b + STANDARD_GRAVITY) * section.second_moment
        height += sigma * section.reach * (b - h) + section.reach
    force = section.wall * weights @ pressure
    moment = section.wall * weights @ (z * pressure) + pressure_moment
    return Response(height, WATER.density * force, WATER.density * moment)


def massless(container: Cylinder | Box, count: int) -> tuple[ObjectNumbers, ObjectStructure]:
    """A container without mass of its own, with `count` modes in each direction."""
    none = MassProperties(0.0, np.zeros(3), np.zeros((3, 3)))
    modes = container.slosh_modes(WATER, DEPTH, count, damping=0.0)
    total = MassProperties(modes.liquid_mass, np.array((0, 0, DEPTH / 2)), np.zeros((3, 3)))
    filling = Filling(WATER, DEPTH, 0.02, modes)
    cargo = Cargo("cup", "", container, np.zeros(2), 0.0, total, none, 0.4, 0.0, 0.0, filling)
    scene = replace(read_scenario("mixed-tray"), cargo=(cargo,))
    return constants(numbers_of(scene).objects[0]), structure_of(scene).objects[0]


def laws(container: Cylinder | Box, rate: float, kind: Kind, count: int, *, corrected: bool) -> Response:
    """Steady undamped response of the laws, at the instant of the largest displacement, per amplitude."""
    height, force, moment = steady(container, kind, count, corrected)(rate).full().ravel()
    # The tray's force holds the container against that of the liquid.
    return Response(height, -force, -moment)


@cache
def steady(container: Cylinder | Box, kind: Kind, count: int, corrected: bool) -> ca.Function:
    """Rate -> height, force and moment of the laws, per amplitude."""
    numbers, structure = massless(container, count)
    size, rate = 1e-6, ca.SX.sym("rate")
    if kind == "surge":
        motion = FrameMotion(ca.SX.zeros(3), ca.SX.zeros(3), vector(-(rate**2) * size, 0, STANDARD_GRAVITY))
    else:
        gravity = STANDARD_GRAVITY * vector(-np.sin(size), 0, np.cos(size))
        pivot = FrameMotion(ca.SX.zeros(3), vector(0, -(rate**2) * size, 0), gravity)
        motion = pivot.at(ca.DM([0, 0, -DEPTH]))
    states = []
    for oscillator, directions in zip(numbers.oscillators, structure.oscillators, strict=True):
        still = ca.SX.zeros(len(directions))
        push = modal_acceleration(oscillator, directions, motion, still, still, damp_against_spin=False)
        displacement = push / (oscillator.frequency**2 - rate**2)
        states.append(OscillatorState(displacement, still, -(rate**2) * displacement))
    wrench = contact_wrench("full", numbers, structure, motion, tuple(states))
    eta = surface_vector(numbers, structure, motion, tuple(states), corrected=corrected)
    return ca.Function("steady", [rate], [ca.vertcat(eta[0], wrench.force[0], wrench.moment[1]) / size])


def first_frequency(container: Cylinder | Box) -> float:
    return min(mode.frequency for mode in container.slosh_modes(WATER, DEPTH, 1).oscillators if "x" in mode.directions)


@pytest.mark.slow
@pytest.mark.parametrize("container", CONTAINERS, ids=["cylinder", "box"])
@pytest.mark.parametrize("kind", ["surge", "pitch"])
@pytest.mark.parametrize("relative", [0.3, 0.5, 0.9, 1.2, 2.0])
def test_many_modes_are_the_potential_solution(container, kind, relative):
    rate = relative * first_frequency(container)
    exact = potential_solution(container, rate, kind)
    ours = laws(container, rate, kind, 80, corrected=True)
    reach = 0.035
    assert ours.height == pytest.approx(exact.height, rel=1e-3, abs=1e-3 * reach * (rate**2 / STANDARD_GRAVITY))
    mass = float(WATER.density * container.volume(DEPTH))
    scale = mass * (rate**2 if kind == "surge" else STANDARD_GRAVITY)
    assert ours.force == pytest.approx(exact.force, rel=1e-4, abs=1e-4 * scale)
    assert ours.moment == pytest.approx(exact.moment, rel=1e-4, abs=1e-4 * scale * DEPTH)


@pytest.mark.parametrize(("relative", "height"), [(0.3, 0.032861), (0.8, -0.002341), (1.3, 0.080636), (2.5, 0.048358)])
def test_wall_height_in_pitch_against_collocation(relative, height):
    """Wall height per angle about the surface's centre, from a Chebyshev collocation of the potential in (r, z)."""
    cup = CONTAINERS[0]
    rate = relative * first_frequency(cup)
    assert potential_solution(cup, rate, "pitch").height == pytest.approx(height, abs=1e-5)
    assert laws(cup, rate, "pitch", 80, corrected=True).height == pytest.approx(height, abs=1e-5)


@pytest.mark.parametrize(("kind", "tolerance"), [("surge", 5e-3), ("pitch", 0.025)])
@pytest.mark.parametrize("relative", [0.3, 0.5, 0.8, 0.9])
def test_one_mode_gives_wrench_and_corrected_height_below_resonance(kind, tolerance, relative):
    cup = CONTAINERS[0]
    rate = relative * first_frequency(cup)
    exact, ours = potential_solution(cup, rate, kind), laws(cup, rate, kind, 1, corrected=True)
    assert ours.force == pytest.approx(exact.force, rel=tolerance)
    assert ours.moment == pytest.approx(exact.moment, rel=tolerance)
    # The correction takes away at least two thirds of what the modes not carried leave out.
    plain = laws(cup, rate, kind, 1, corrected=False)
    assert abs(ours.height - exact.height) < abs(plain.height - exact.height) / 3
