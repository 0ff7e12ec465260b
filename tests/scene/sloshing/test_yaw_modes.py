"""Yaw modes of a box: closed forms, quadrature, energy, mirrored turns and where the wall is looked at."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.core.frames import SX, body_motion
from nospill.core.trees import constants
from nospill.laws.scene_parameters import object_numbers, object_structure
from nospill.laws.slosh.motion import modal_accelerations
from nospill.scene.containers.box import Box
from nospill.scene.liquids import LIQUIDS
from nospill.scene.sloshing.modes import STANDARD_GRAVITY, YawModes
from nospill.scene.sloshing.yaw_modes import YawMode, mode_shapes, wall_points, zhukovsky_potential
from nospill.scene.surface_tension.tension import liquid_modes
from nospill.scene.turning import turning
from nospill.simulation.cup_file import cup_from_table

WATER = LIQUIDS["water"]
sides = st.floats(0.03, 0.3)


def yaw_of(length: float, width: float, level: float, count: int = 20) -> YawModes:
    found = Box(length, width, 0.5).slosh_modes(WATER, level, count).yaw
    assert found is not None
    return found


@given(sides, sides)
@settings(deadline=None)
def test_the_potential_turns_with_the_walls(a: float, b: float) -> None:
    """It is harmonic, its slope across a wall is the wall's velocity, and its corner that of the closed form."""
    edge, part, step = 0.999999, np.linspace(-0.9, 0.9, 7), 1e-6 * min(a, b)

    def slope(points: np.ndarray, axis: int) -> np.ndarray:
        shift = step * np.eye(2)[axis]
        return (zhukovsky_potential((a, b), points + shift) - zhukovsky_potential((a, b), points - shift)) / (2 * step)

    right = np.column_stack([np.full(7, edge * a / 2 - 2 * step), part * b / 2])
    upper = np.column_stack([part * a / 2, np.full(7, edge * b / 2 - 2 * step)])
    np.testing.assert_allclose(slope(right, 0), -right[:, 1], atol=2e-3 * b)
    np.testing.assert_allclose(slope(upper, 1), upper[:, 0], atol=2e-3 * a)
    corner = -a * b / 4 + 8 * a**2 / math.pi**3 * sum(
        math.tanh(m * math.pi * b / (2 * a)) / m**3 for m in range(1, 999, 2)
    )
    found = float(zhukovsky_potential((a, b), np.array([[a / 2, b / 2]]))[0])
    assert found == pytest.approx(corner, abs=1e-6 * max(a, b) ** 2)


@given(sides, sides)
@settings(deadline=None, max_examples=20)
def test_shares_are_those_of_the_projection(a: float, b: float) -> None:
    """c is the integral of Z S over that of S^2, by Gauss's rule."""
    x, weight = np.polynomial.legendre.leggauss(40)
    points = np.column_stack([np.repeat(x, 40) * a / 2, np.tile(x, 40) * b / 2])
    area = np.outer(weight, weight).ravel()
    z = zhukovsky_potential((a, b), points)
    for waves in ((1, 1), (3, 1), (1, 3), (5, 3)):
        mode = YawMode((a, b), waves, 0.05)
        shape = mode.shape(points)
        assert mode.share == pytest.approx(area @ (z * shape) / (area @ shape**2), abs=1e-6 * max(a, b) ** 2)


def test_a_square_has_no_first_mode_and_level_corners() -> None:
    found = yaw_of(0.2, 0.2, 0.05)
    assert found.oscillators[0].arm == 0.0
    np.testing.assert_allclose(
        [mode.arm for mode in found.oscillators[1::2]], [-m.arm for m in found.oscillators[2::2]]
    )
    assert found.gains[0] == pytest.approx(0.0, abs=1e-8)
    assert np.max(np.abs(found.gains)) > 0.03 * 0.2**2  # the walls do not stay level


@given(sides, sides, st.floats(0.01, 0.2))
@settings(deadline=None)
def test_turned_boxes_are_mirrored(a: float, b: float, level: float) -> None:
    """The other side along x: the same modes with the other sign, the same inertia."""
    one, other = yaw_of(a, b, level, 3), yaw_of(b, a, level, 3)
    assert one.inertia == pytest.approx(other.inertia, rel=1e-9)
    assert one.fixed_inertia == pytest.approx(other.fixed_inertia, rel=1e-6, abs=1e-12)
    order = [0, 2, 1, 4, 3]
    for mode, index in zip(one.oscillators, order, strict=True):
        mirrored = other.oscillators[index]
        assert mode.frequency == pytest.approx(mirrored.frequency, rel=1e-12)
        assert mode.arm == pytest.approx(-mirrored.arm, rel=1e-12)
        assert mode.damping == pytest.approx(mirrored.damping, rel=1e-9)
    assert all(own.mass * own.arm**2 < one.inertia for own in one.oscillators)


def test_all_modes_together_leave_no_correction() -> None:
    """What is left of the height is that of modes of three half waves or more along both sides."""
    for shape in ((0.24, 0.2), (0.2, 0.2), (0.1, 0.3)):
        found = yaw_of(*shape, 0.05)
        assert np.max(np.abs(found.static_correction)) < 0.1 * np.max(np.abs(found.gains))


def test_damping_is_the_quadrature_over_walls_and_bottom() -> None:
    a, b, h, waves = 0.09, 0.06, 0.035, (3, 1)
    mode = YawMode((a, b), waves, h)
    p, q = waves[0] * np.pi / a, waves[1] * np.pi / b
    k = np.hypot(p, q)
    node, weight = np.polynomial.legendre.leggauss(60)
    x, y, z = node * a / 2, node * b / 2, (node + 1) * h / 2

    def squared(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        deep, shallow = np.cosh(k * z) ** 2, np.sinh(k * z) ** 2
        level = (p * np.cos(p * x) * np.sin(q * y)) ** 2 + (q * np.sin(p * x) * np.cos(q * y)) ** 2
        return level * deep + (k * np.sin(p * x) * np.sin(q * y)) ** 2 * shallow

    def over(value: np.ndarray) -> float:
        return float(weight @ value @ weight)

    wall_x = 2 * over(squared(np.full((60, 60), a / 2), y[:, None], z[None])) * b / 2 * h / 2
    wall_y = 2 * over(squared(x[:, None], np.full((60, 60), b / 2), z[None])) * a / 2 * h / 2
    bottom = over(squared(x[:, None], y[None], np.zeros((60, 60)))) * a / 2 * b / 2
    cube = squared(x[:, None, None], y[None, :, None], z[None, None])
    volume = np.einsum("i,j,k,ijk", weight, weight, weight, cube) * a * b * h / 8
    omega = math.sqrt(STANDARD_GRAVITY * k * math.tanh(k * h))
    viscosity = WATER.kinematic_viscosity
    expected = (
        math.sqrt(viscosity / (2 * omega)) * (wall_x + wall_y + bottom) / volume / 2 + 2 * viscosity * k**2 / omega
    )
    assert mode.laminar_damping(WATER) == pytest.approx(expected, rel=1e-9)


def test_surface_tension_stiffens_every_mode_and_flattens_the_surface() -> None:
    box = Box(0.03, 0.02, 0.1)
    plain, tense = (liquid_modes(box, WATER, 0.02, 3, contact_line=line).yaw for line in ("", "free"))
    assert plain is not None and tense is not None
    length = math.sqrt(WATER.surface_tension / (WATER.density * STANDARD_GRAVITY))
    for one, other in zip(plain.oscillators, tense.oscillators, strict=True):
        assert other.frequency**2 == pytest.approx(one.frequency**2 * (1 + (length * one.wave_number) ** 2), rel=1e-9)
        assert other.stiffness == pytest.approx(one.stiffness, rel=1e-12)
    assert 0.3 < np.max(np.abs(tense.gains)) / np.max(np.abs(plain.gains)) < 0.8
    share = YawMode((0.03, 0.02), (1, 1), 0.02).share
    assert plain.oscillators[0].arm * plain.oscillators[0].compliance == pytest.approx(share, rel=1e-12)


def turning_law(length: float, width: float, damping: float):
    table = {"shape": "box", "length": length, "width": width, "height": 0.2, "liquid": "water", "damping": damping}
    cargo = turning(cup_from_table(table | {"liquid_height": 0.05, "empty_mass": 0.1}, slosh_modes=2))
    structure = object_structure(cargo)
    numbers = constants(object_numbers(cargo, fidelity="full", gravity=STANDARD_GRAVITY))
    body, state = SX.sym("b", 9), SX.sym("x", 2 * structure.coordinates)
    q, qd = ca.vertsplit(state, structure.coordinates)
    rate = modal_accelerations(structure, numbers, body_motion(body), q, qd, damp_against_spin=False)
    return cargo, ca.Function("rate", [body, state], [rate])


@given(sides, sides, st.floats(-0.005, 0.005), st.floats(-0.1, 0.1))
@settings(deadline=None, max_examples=20)
def test_energy_of_a_yaw_mode_changes_by_damping_alone(a: float, b: float, q: float, qd: float) -> None:
    """d/dt (m q'^2/2 + m omega^2 q^2/2) = -2 zeta omega m q'^2 with the box at rest; none of it goes elsewhere."""
    cargo, law = turning_law(a, b, 0.02)
    still = np.array([0, 0, 0, 0, 0, 0, 0, 0, STANDARD_GRAVITY])
    for index, mode in enumerate(cargo.oscillators):
        if mode.yaws:
            state = np.zeros(2 * len(cargo.oscillators))
            state[index], state[len(cargo.oscillators) + index] = q, qd
            found = law(still, state).full().ravel()
            power = found[index] * qd + mode.frequency**2 * q * qd
            assert power == pytest.approx(-2 * mode.damping * mode.frequency * qd**2, abs=1e-9)
            assert np.all(np.delete(found, index) == 0.0)


def test_a_mirrored_turn_mirrors_the_modes_and_leaves_those_along_the_sides() -> None:
    cargo, law = turning_law(0.24, 0.2, 0.02)
    yaws = np.array([mode.yaws for mode in cargo.oscillators])
    state = np.zeros(2 * len(yaws))
    left, right = (law([0, 0, 0, 0, 0, sign * 12.0, 0, 0, 9.8], state).full().ravel() for sign in (1, -1))
    np.testing.assert_allclose(left, -right)
    np.testing.assert_allclose(left[yaws], [-12.0 * mode.arm for mode in cargo.oscillators if mode.yaws])
    assert np.all(left[~yaws] == 0.0)


@given(st.floats(1.0, 3.0), st.floats(0.02, 0.1), st.floats(0.3, 1.3), st.booleans())
@settings(deadline=None, max_examples=15)
def test_the_places_looked_at_miss_little_of_the_wall(ratio: float, level: float, time: float, along_x: bool) -> None:
    """During and after a turn; exact steps of every mode under an acceleration constant in each."""
    shape = (0.2 * ratio, 0.2) if along_x else (0.2, 0.2 * ratio)
    found, step = yaw_of(*shape, level), 2e-3
    t = step * np.arange(round((time + 1.0) / step))
    acceleration = np.where(t < time, np.sin(2 * np.pi * t / time), 0.0)
    omega, arm = (np.array([getattr(mode, name) for mode in found.oscillators]) for name in ("frequency", "arm"))
    turn, q, rate = np.exp(1j * omega * step), np.zeros(len(omega)), np.zeros(len(omega))
    rows = [q]
    for value in (acceleration[1:] + acceleration[:-1]) / 2:
        rest = -arm * value / omega**2
        phase = (q - rest - 1j * rate / omega) * turn
        q, rate = rest + phase.real, -phase.imag * omega
        rows.append(q)
    part = np.linspace(0.0, 1.0, 101)[:, None]
    half = np.array(shape) / 2
    wall = np.concatenate([half * np.hstack([part, np.ones_like(part)]), half * np.hstack([np.ones_like(part), part])])

    def heights(points: np.ndarray) -> np.ndarray:
        at_once = zhukovsky_potential(shape, points) - mode_shapes(found, points) @ (arm * STANDARD_GRAVITY / omega**2)
        return np.abs(
            np.array(rows) @ mode_shapes(found, points).T - np.outer(acceleration / STANDARD_GRAVITY, at_once)
        )

    looked_at, whole = heights(wall_points(shape)), heights(wall)
    # Where a turn leaves the first mode at rest, higher ones are left, and more of them is missed: of a height that is
    # little beside that of the turn itself.
    greatest = np.max(whole)
    for when, part in ((t <= time, 0.94), (t > time, 0.85)):
        seen, there = np.max(looked_at[when]), np.max(whole[when])
        assert part * there <= seen <= there * (1 + 1e-3)
        assert there - seen <= 0.05 * greatest
