"""Half spheroids against Rayleigh and Ritz's method with harmonic polynomials: no mesh, no element, no shared code."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss

from nospill.scene.meridian import Meridian, arc
from nospill.scene.sloshing.revolved_modes import solve_modes

DEGREE, NODES = 18, 40


def harmonics(r: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q, dq/dr and dq/dz of the solid harmonics x q with one nodal diameter, of every degree up to `DEGREE`."""
    found = []
    for degree in range(DEGREE):
        factor, rows = 1.0, np.zeros((3, *r.shape))
        for half in range(degree // 2 + 1):
            power = degree - 2 * half
            rows[0] += factor * r ** (2 * half) * z**power
            rows[1] += factor * 2 * half * r ** max(2 * half - 1, 0) * z**power
            rows[2] += factor * power * r ** (2 * half) * z ** max(power - 1, 0)
            factor *= -power * (power - 1) / ((2 * half + 2) * (2 * half + 4))
        found.append(rows)
    value, by_r, by_z = np.array(found).swapaxes(0, 1)
    return value, by_r, by_z


def ritz(depth: float) -> tuple[float, float]:
    """Curvature and modal mass over the liquid's of a half spheroid of radius 1, filled to its equator."""
    from scipy.linalg import eigh

    nodes, weights = leggauss(NODES)
    nodes, weights = (nodes + 1) / 2, weights / 2
    angle, size = np.meshgrid(math.pi / 2 * nodes, nodes)
    r, z = size * np.cos(angle), -depth * size * np.sin(angle)
    inside = np.outer(weights, weights) * math.pi / 2 * size * depth * r * math.pi
    value, by_r, by_z = harmonics(r, z)
    energy = sum(np.einsum("iab,jab,ab->ij", q, q, inside) for q in (value + r * by_r, value, r * by_z))
    shape, above = harmonics(nodes, np.zeros(NODES))[0], math.pi * nodes**3 * weights
    inverse, vectors = eigh(np.einsum("iq,jq,q->ij", shape, shape, above), energy)
    surge = above @ shape.T @ vectors[:, -1]
    return 1 / inverse[-1], surge**2 / inverse[-1] ** 2 / (2 / 3 * math.pi * depth)


@pytest.mark.parametrize("depth", [0.5, 1.0, 2.0])
def test_frequency_and_mass_of_half_spheroids(depth: float) -> None:
    meridian = Meridian((arc((0.0, 0.05 * depth), (0.05, 0.05 * depth), (-math.pi / 2, 0.0)),))
    found = solve_modes(meridian, 0.05 * depth, 40)
    curvature, share = ritz(depth)
    assert 0.05 * found.curvature[0] == pytest.approx(curvature, rel=3e-6)
    assert found.volume[0] / (2 / 3 * math.pi * 0.05**3 * depth) == pytest.approx(share, rel=3e-6)
