"""A container that turns about the middle of its rest surface: energy, and what the fields are at its walls.

The fields' gradients, the moving frame's pressure and both surface conditions are in it: whatever energy the liquid
gains comes through the walls.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nospill.potential_flow.basin import Basin, basin_of
from nospill.potential_flow.nonlinear import full_flow, room_of
from nospill.potential_flow.orders import lean_of, linear_terms
from nospill.potential_flow.turning import Tilting, tilting
from tests.waters import cup

RADIUS, DEPTH = 0.035, 0.06
_NODE, _WEIGHT = np.polynomial.legendre.leggauss(16)


@pytest.fixture(scope="module")
def basin() -> Basin:
    return basin_of(cup(RADIUS, DEPTH))


def _on_wall(basin: Basin) -> Basin:
    """The same modes, asked for at the wall."""
    modes = basin.modes
    tangent = np.stack([-modes.wall[:, 1], modes.wall[:, 0]]) / RADIUS
    return replace(
        basin,
        modes=replace(modes, points=modes.wall, shape=modes.wall_shape, slope=tangent[:, :, None] * modes.wall_slope),
    )


def _moving(basin: Basin, parts: Tilting, potential: np.ndarray, omega: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Velocity (3, P) past the container at heights z (P,), of a turn and of the modes."""
    modes = basin.modes
    k = modes.wave_number
    up, down = np.exp(np.multiply.outer(z, k)), np.exp(-np.multiply.outer(z + 2 * DEPTH, k))
    bottom = 1 + np.exp(-2 * k * DEPTH)
    flow = [
        *((modes.slope * ((up + down) / bottom)) @ potential),
        (modes.shape * (k * (up - down) / bottom)) @ potential,
    ]
    x, y = modes.points.T
    return np.stack(flow) + parts.at(lean_of(omega), z).velocity + omega[2] * np.stack([y, -x, 0 * x])


def _value(basin: Basin, potential: np.ndarray, z: np.ndarray) -> np.ndarray:
    k = basin.modes.wave_number
    up, down = np.exp(np.multiply.outer(z, k)), np.exp(-np.multiply.outer(z + 2 * DEPTH, k))
    return (basin.modes.shape * ((up + down) / (1 + np.exp(-2 * k * DEPTH)))) @ potential


def _carried(points: np.ndarray, omega: np.ndarray, z: np.ndarray) -> np.ndarray:
    x, y = points.T
    return np.stack([omega[1] * z - omega[2] * y, omega[2] * x - omega[0] * z, omega[0] * y - omega[1] * x])


def _energy(basin: Basin, state: np.ndarray, omega: np.ndarray, force: np.ndarray) -> float:
    modes, parts = basin.modes, tilting(basin)
    height = modes.shape @ state[0]
    total = 0.0
    for node, weight in zip(_NODE, _WEIGHT, strict=True):
        z = -DEPTH + (height + DEPTH) * (node + 1) / 2
        velocity = _moving(basin, parts, state[1], omega, z) + _carried(modes.points, omega, z)
        place = force[:2] @ modes.points.T + force[2] * z
        total += weight / 2 * np.sum(modes.weight * (height + DEPTH) * (np.sum(velocity**2, axis=0) / 2 + place))
    return float(total)


def test_the_turning_potential_does_not_pass_the_walls(basin: Basin) -> None:
    wall = _on_wall(basin)
    parts = Tilting(wall, tilting(basin).index, tilting(basin).share)
    outward = wall.modes.points.T / RADIUS
    for z in (-0.05, 0.0, 0.01):
        through = parts.at(np.array([1.0, -2.0]), z).velocity[:2]
        assert np.abs(np.sum(through * outward, axis=0)).max() < 1e-12


def test_energy_comes_through_the_walls_alone(basin: Basin) -> None:
    random = np.random.default_rng(5)
    size = np.exp(-0.6 * basin.modes.wave_number * RADIUS)
    state = random.normal(size=(2, len(size))) * size * np.array([[4e-3], [3e-3]])
    omega, alpha = np.array([1.5, -2.0, 2.5]), np.array([8.0, 12.0, -10.0])
    force = np.array([1.0, -1.5, 9.5])
    terms = replace(linear_terms(basin), friction=np.zeros(len(size)))
    rate = full_flow(terms, state, np.concatenate([omega, alpha, force]))
    turned = -np.cross(omega, force)  # gravity stands in the world
    step = 1e-5
    ends = [
        _energy(basin, state + sign * step * rate, omega + sign * step * alpha, force + sign * step * turned)
        for sign in (-1, 1)
    ]
    gained = (ends[1] - ends[0]) / (2 * step)

    def pressure(of: Basin, parts: Tilting, z: np.ndarray) -> np.ndarray:
        flow = _moving(of, parts, state[1], omega, z)
        carried = _carried(of.modes.points, omega, z)
        place = force[:2] @ of.modes.points.T + force[2] * z + parts.at(lean_of(alpha), z).potential
        change = _value(of, rate[1], z)
        return -(change + place + np.sum(flow**2, axis=0) / 2 - np.sum(carried**2, axis=0) / 2)

    modes, inside = basin.modes, tilting(basin)
    level = modes.weight @ pressure(basin, inside, modes.shape @ state[0]) / modes.weight.sum()
    wall = _on_wall(basin)
    parts = Tilting(wall, inside.index, inside.share)
    height, outward = wall.modes.shape @ state[0], wall.modes.points.T / RADIUS
    work = 0.0
    for node, weight in zip(_NODE, _WEIGHT, strict=True):
        z = -DEPTH + (height + DEPTH) * (node + 1) / 2
        through = np.sum(_carried(wall.modes.points, omega, z)[:2] * outward, axis=0)
        area = weight / 2 * (height + DEPTH) * modes.wall_weight
        work -= float(np.sum(area * (pressure(wall, parts, z) - level) * through))
    z = np.full(len(modes.points), -DEPTH)
    sinks = -(_moving(basin, inside, state[1], omega, z) + _carried(modes.points, omega, z))[2]
    work -= float(np.sum(modes.weight * (pressure(basin, inside, z) - level) * sinks))
    assert gained == pytest.approx(work, rel=3e-3)


def test_room_that_is_used_again_leaves_no_trace() -> None:
    """Of several liquids at once, leaning, one state after the other."""
    basin, random = basin_of(cup()), np.random.default_rng(3)
    terms, room = linear_terms(basin), room_of(basin, 2)
    row = random.normal(size=(9, 2)) + np.array([0.0] * 8 + [9.8])[:, None]
    for _ in range(2):
        state = random.normal(size=(2, 2, len(basin.damping))) * np.array([[2e-4], [1e-5]])
        together = full_flow(terms, state, row, room)
        alone = [full_flow(terms, own, part) for own, part in zip(state, row.T, strict=True)]
        np.testing.assert_allclose(together, alone, rtol=1e-9, atol=1e-12)
