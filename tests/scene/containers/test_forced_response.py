"""Surge of a cup: the equivalent mechanical model against the linear potential solution in harmonics of the depth.

The oracle knows nothing of slosh modes: for a container swinging as X cos(omega t) it expands the potential in
Z_0 = cosh(K z), K tanh(K h) = omega^2/g, and Z_j = cos(kappa_j z), kappa_j tan(kappa_j h) = -omega^2/g, each with the
function of x (or r) that meets the wall's velocity.
"""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ive, jv, jvp

from nospill.scene.containers.box import Box
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.liquids import LIQUIDS
from nospill.scene.sloshing.modes import STANDARD_GRAVITY

WATER = LIQUIDS["water"]
DEPTH = 0.049
TERMS = 400


def depth_functions(rate: float) -> tuple[float, np.ndarray]:
    sigma = rate**2 / STANDARD_GRAVITY
    propagating = brentq(lambda k: k * np.tanh(k * DEPTH) - sigma, 1e-9, 1e5, xtol=1e-14)
    # In x = kappa h: x sin x + sigma h cos x = 0, one root in each ((j - 1/2) pi, j pi).
    roots = [
        brentq(lambda x: x * np.sin(x) + sigma * DEPTH * np.cos(x), (j - 0.5) * np.pi, j * np.pi, xtol=1e-14)
        for j in range(1, TERMS)
    ]
    return propagating, np.array(roots) / DEPTH  # pyright: ignore[reportReturnType]


def oracle(container: Cylinder | Box, rate: float) -> tuple[float, float, float]:
    """Wall height, force on the container and its moment about the bottom's centre, per metre of surge."""
    k, kappa = depth_functions(rate)
    h, z = DEPTH, np.polynomial.legendre.leggauss(400)
    heights = h / 2 * (z[0] + 1)
    weights = h / 2 * z[1]
    # Coefficients of a unit wall velocity.
    u0 = (np.sinh(k * h) / k) / (h / 2 + np.sinh(2 * k * h) / (4 * k))
    uj = (np.sin(kappa * h) / kappa) / (h / 2 + np.sin(2 * kappa * h) / (4 * kappa))
    if isinstance(container, Cylinder):
        reach = container.radius
        at_wall0 = jv(1, k * reach) / (k * jvp(1, k * reach))
        slope = ive(0, kappa * reach) - ive(1, kappa * reach) / (kappa * reach)
        at_wallj = ive(1, kappa * reach) / (kappa * slope)
        # pi times the integral of r^2 times the radial function, over the bottom.
        bottom0 = np.pi * reach**2 * jv(2, k * reach) / k / (k * jvp(1, k * reach))
        bottomj = np.pi * reach**2 * ive(2, kappa * reach) / kappa / (kappa * slope)
        wall_width = np.pi * reach
    else:
        reach = container.length / 2
        at_wall0, at_wallj = np.tan(k * reach) / k, np.tanh(kappa * reach) / kappa
        bottom0 = container.width * 2 * (np.tan(k * reach) / k**2 - reach / k) / k
        bottomj = container.width * 2 * (reach / kappa - np.tanh(kappa * reach) / kappa**2) / kappa
        wall_width = 2 * container.width
    potential = u0 * at_wall0 * np.cosh(k * heights) + (uj * at_wallj) @ np.cos(np.outer(kappa, heights))
    pressure = WATER.density * rate**2 * potential
    surface = rate**2 / STANDARD_GRAVITY * (u0 * at_wall0 * np.cosh(k * h) + np.sum(uj * at_wallj * np.cos(kappa * h)))
    force = wall_width * weights @ pressure
    on_bottom = WATER.density * rate**2 * (u0 * bottom0 + np.sum(uj * bottomj))
    return float(surface), float(force), float(wall_width * weights @ (heights * pressure) + on_bottom)


@pytest.mark.parametrize("container", [Cylinder(0.035, 0.1), Box(0.07, 0.05, 0.1)], ids=["cylinder", "box"])
@pytest.mark.parametrize("relative", [0.5, 0.9, 1.2, 2.0])
def test_surge_against_the_potential_solution(container, relative):
    modes = container.slosh_modes(WATER, DEPTH, 100)
    moving = [mode for mode in modes.oscillators if "x" in mode.directions]
    rate = relative * moving[0].frequency
    surface, force, moment = oracle(container, rate)
    response = np.array([rate**2 / (mode.frequency**2 - rate**2) for mode in moving])
    gains = np.array([mode.surface_gain for mode in moving])
    masses = np.array([mode.mass for mode in moving])
    levers = np.array([mode.height for mode in moving])
    # Signs of the surface gains, and the static correction for what is not carried.
    assert gains @ response + modes.static_correction[0] * rate**2 / STANDARD_GRAVITY == pytest.approx(
        surface, rel=2e-4
    )
    assert rate**2 * (modes.liquid_mass + masses @ response) == pytest.approx(force, rel=1e-5)
    rigid = rate**2 * modes.liquid_mass * DEPTH / 2
    assert rigid + (masses * (rate**2 * levers + STANDARD_GRAVITY)) @ response == pytest.approx(moment, rel=1e-4)


@pytest.mark.parametrize("container", [Cylinder(0.035, 0.1), Box(0.07, 0.05, 0.1)], ids=["cylinder", "box"])
def test_one_mode_with_the_correction_is_nearly_right(container):
    modes = container.slosh_modes(WATER, DEPTH, 1)
    mode = modes.oscillators[0]
    for relative, corrected_error, plain_error in ((0.3, 0.01, 0.2), (0.6, 0.03, 0.2)):
        rate = relative * mode.frequency
        surface = oracle(container, rate)[0]
        plain = mode.surface_gain * rate**2 / (mode.frequency**2 - rate**2)
        corrected = plain + modes.static_correction[0] * rate**2 / STANDARD_GRAVITY
        assert abs(corrected / surface - 1) < corrected_error < abs(plain / surface - 1) < plain_error
