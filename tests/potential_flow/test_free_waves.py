"""Free waves in full: invariants, published standing waves, and a free-surface flow solver's cup."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from nospill.potential_flow.basin import FINE, Basin, basin_of
from nospill.potential_flow.nonlinear import energy, full_flow
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from tests.waters import STILL, FreeWave, cup, free_wave, frequency_of, mode_like, tub, undamped

RADIUS = 0.035
LENGTH = 0.3


SOLVER = np.array([
    12.00, 7.69, -1.96, -9.69, -10.99, -4.47, 5.71, 10.86, 8.77, 0.50, -8.63, -11.28, -5.98, 3.67, 10.42,
    10.09, 2.62, -6.97, -11.23, -7.67, 1.42, 9.26, 10.53, 4.28, -5.36, -10.56,
])  # fmt: skip
"""mm, first mode of a wave of 12 mm in that cup by interFoam (29,400 cells), every 40 ms."""


def _first_mode(basin: Basin, height: float) -> np.ndarray:
    start = np.zeros(len(basin.damping))
    start[mode_like(basin, lambda x, y: x)] = height
    return start


def _cup_wave(height: float, duration: float = 2.0) -> FreeWave:
    basin = basin_of(cup(RADIUS, 0.049))
    return free_wave(basin, _first_mode(basin, height), duration)


def test_an_ideal_liquid_keeps_its_volume_and_energy() -> None:
    wave = _cup_wave(0.005)
    modes = wave.basin.modes
    held = [energy(wave.basin, state, STANDARD_GRAVITY) for state in wave.full[:: len(wave.full) // 8]]
    assert held == pytest.approx(np.full(len(held), held[0]), rel=2e-4)
    assert np.abs(modes.weight @ (modes.shape @ wave.full[:, 0].T)).max() < 1e-12


def test_energy_changes_as_the_pressure_works() -> None:
    """Instant by instant, whatever the state: the rate of the energy is nothing but damping."""
    basin, random = basin_of(tub()), np.random.default_rng(1)
    state = random.normal(size=(2, len(basin.damping))) * np.array([[4e-4], [2e-5]])
    rate, step = full_flow(undamped(basin), state, STILL), 1e-6
    before, after = (energy(basin, state + sign * step * rate, STANDARD_GRAVITY) for sign in (-1, 1))
    assert abs(after - before) / (2 * step) < 1e-5 * energy(basin, state, STANDARD_GRAVITY) * np.max(basin.frequency)


def test_damping_takes_energy_as_in_the_linear_model() -> None:
    basin = basin_of(cup())
    start = _first_mode(basin, 1e-4)
    index, terms = int(np.argmax(start)), undamped(basin)
    state = np.stack([np.zeros_like(start), start / 1e-4 * 1e-6])
    loss = full_flow(replace(terms, friction=basin.friction), state, STILL)[1] - full_flow(terms, state, STILL)[1]
    expected = -2 * basin.damping[index] * basin.frequency[index] * state[1, index]
    assert loss[index] == pytest.approx(expected, rel=1e-3)


def _tadjbakhsh_keller(depth: float) -> tuple[float, float, float, float]:
    """Frequency and its correction, and the second-order surface's constant and swinging part, wave number 1.

    omega = w0 + e^2 w2/2 and eta = e cos x cos t + e^2 (b0 + b2 cos 2t) cos 2x [Tadjbakhsh and Keller 1960]; their
    waves go through the level at t = 0, ours are at rest then.
    """
    w0 = np.sqrt(np.tanh(depth))
    w2 = (9 * w0**-7 - 12 * w0**-3 - 3 * w0 - 2 * w0**5) / 32
    return w0, w2, (w0**2 + w0**-2) / 8, (3 * w0**-6 - w0**-2) / 8


@pytest.mark.parametrize("depth", [0.8, 1.5, 3.0], ids="depth {}".format)
def test_standing_waves_in_a_box_are_the_published_ones(depth: float) -> None:
    wave_number = np.pi / LENGTH
    basin = basin_of(tub(LENGTH, 0.04, depth / wave_number))
    w0, w2, constant, swinging = _tadjbakhsh_keller(depth)
    first = mode_like(basin, lambda x, y: np.sin(wave_number * x))
    second = mode_like(basin, lambda x, y: np.cos(2 * wave_number * x))
    steepness = 0.05
    start, added = np.zeros((2, len(basin.damping)))
    start[first] = steepness / wave_number
    sign = np.sign(basin.modes.coefficients(np.cos(2 * wave_number * (basin.modes.points[:, 0] + LENGTH / 2)))[second])
    added[second] = sign * steepness**2 / wave_number * (constant + swinging)
    wave = free_wave(basin, start, 12 * 2 * np.pi / (w0 * np.sqrt(STANDARD_GRAVITY * wave_number)), addition=added)
    angle = w0 * np.sqrt(STANDARD_GRAVITY * wave_number) * wave.t
    published = sign * steepness**2 / wave_number * (constant + swinging * np.cos(2 * angle))
    assert wave.second[:, 0, second] == pytest.approx(published, abs=2e-3 * np.abs(published).max())
    found = frequency_of(wave.t, wave.full[:, 0, first]) / np.sqrt(STANDARD_GRAVITY * wave_number) / w0 - 1
    assert found == pytest.approx(steepness**2 * w2 / (2 * w0), rel=0.04)


def _crest_ratios(wave: FreeWave) -> tuple[float, float, float]:
    """Mean crest and trough at both ends of the diameter over the mean amplitude of the first mode, and that, m."""
    index = int(np.argmax(np.abs(wave.full[0, 0])))
    heights = wave.full[:, 0] @ wave.basin.modes.wall_shape.T
    ends = heights[:, [0, heights.shape[1] // 2]]
    course = wave.full[:, 0, index]
    half = np.pi / frequency_of(wave.t, course)
    count = int((wave.t[-1] - half / 2) / half)
    crests, troughs, swings = [], [], []
    for number in range(1, count + 1):  # the half swings about the turning points after the start
        part = np.abs(wave.t - number * half) < half / 2
        up = (number % 2) * 1
        crests.append(np.max(ends[part, up]))
        troughs.append(-np.min(ends[part, 1 - up]))
        swings.append(np.max(np.abs(course[part])))
    amplitude = float(np.mean(swings))
    return float(np.mean(crests)) / amplitude, float(np.mean(troughs)) / amplitude, amplitude


@pytest.mark.oracle
@pytest.mark.parametrize(
    ("height", "crest", "trough"),
    [(0.002, 1.05, 0.96), (0.005, 1.15, 0.90)],
    ids=["2 mm", "5 mm"],
)
def test_free_waves_in_a_cup_are_those_of_a_flow_solver(height: float, crest: float, trough: float) -> None:
    """Figures of a second of interFoam, 29,400 cells, no surface tension, no friction at the walls."""
    wave = _cup_wave(height, 1.05)
    found = _crest_ratios(wave)
    assert found[:2] == pytest.approx((crest, trough), rel=0.03)
    shift = frequency_of(wave.t, wave.full[:, 0, int(np.argmax(np.abs(wave.full[0, 0])))])
    linear = float(np.min(wave.basin.frequency))
    assert shift / linear - 1 == pytest.approx(-0.34 * (found[2] / RADIUS) ** 2, abs=0.003)


@pytest.mark.oracle
def test_a_free_wave_of_a_quarter_of_the_radius_is_that_of_another_flow() -> None:
    """9 mm, by `benchmarks.water.tapered` with an upright wall; an expansion to the third order has 1.29, 0.83."""
    wave = _cup_wave(0.009, 1.05)
    assert _crest_ratios(wave)[:2] == pytest.approx((1.267, 0.864), rel=0.03)
    found = frequency_of(wave.t, wave.full[:, 0, int(np.argmax(np.abs(wave.full[0, 0])))])
    assert found / float(np.min(wave.basin.frequency)) - 1 == pytest.approx(-0.0201, abs=0.001)


@pytest.mark.oracle
def test_a_high_free_wave_follows_the_flow_solver() -> None:
    """12 mm, a third of the radius, where an expansion to the third order diverges: interFoam's own course."""
    wave, t = _cup_wave(0.012, 1.05), 0.04 * np.arange(len(SOLVER))
    index = int(np.argmax(np.abs(wave.full[0, 0])))
    fine = np.arange(0.0, t[-1], 0.001)
    theirs = CubicSpline(t, SOLVER)(fine)
    ours = CubicSpline(wave.t, 1e3 * wave.full[:, 0, index])(fine)
    assert ours == pytest.approx(theirs, abs=0.9)
    assert frequency_of(fine, ours) == pytest.approx(frequency_of(fine, theirs), rel=0.003)


def test_second_order_of_a_free_wave_is_free_of_its_frequency() -> None:
    """Modes of none and of two nodal diameters swing at their own frequencies beside twice the wave's."""
    wave = _cup_wave(0.001)
    moved = np.abs(wave.second[:, 0]).max(axis=0) > 1e-9
    diameters = {round(float(k) * RADIUS, 2) for k in wave.basin.modes.wave_number[moved]}
    assert diameters == {3.05, 3.83, 6.71, 7.02}


@pytest.mark.parametrize("finest", [FINE, 4.3])
def test_third_order_of_the_frequency_hardly_depends_on_the_number_of_modes(finest: float) -> None:
    basin = basin_of(cup(), finest)
    wave = free_wave(basin, _first_mode(basin, 0.003), 4.0)
    found = frequency_of(wave.t, wave.full[:, 0, int(np.argmax(wave.full[0, 0]))]) / np.min(basin.frequency) - 1
    assert found == pytest.approx(-0.31 * (0.003 / RADIUS) ** 2, rel=0.08)
