"""Modes of a surface: closed forms, and the package's own modes of the same container."""

from __future__ import annotations

import math

import numpy as np
import pytest

from nospill.potential_flow.basin import Basin, basin_of, laminar_damping, linear_basin
from nospill.scene.cargo import Cargo
from nospill.scene.sloshing.yaw_modes import YawMode, zhukovsky_potential
from tests.waters import cup, tub

CONTAINERS = {"cup": cup(), "tub": tub()}


@pytest.mark.parametrize("cargo", CONTAINERS.values(), ids=CONTAINERS)
def test_modes_are_orthogonal_eigenfunctions_of_the_cross_section(cargo: Cargo) -> None:
    modes = basin_of(cargo).modes
    scale = np.sqrt(np.outer(modes.norm, modes.norm))
    products = (modes.shape * modes.weight[:, None]).T @ modes.shape / scale
    slopes = np.einsum("p,xpi,xpj->ij", modes.weight, modes.slope, modes.slope) / scale
    assert np.allclose(products, np.eye(len(scale)), atol=1e-7)
    assert np.allclose(slopes, np.diag(modes.wave_number**2), atol=1e-6 * np.max(modes.wave_number) ** 2)
    assert modes.weight @ modes.shape == pytest.approx(np.zeros(len(scale)), abs=1e-9)  # none adds volume


def test_weights_sum_to_area_and_circumference() -> None:
    disc, box = basin_of(cup()).modes, basin_of(tub()).modes
    assert (disc.weight.sum(), disc.wall_weight.sum()) == pytest.approx((math.pi * 0.035**2, 0.07 * math.pi))
    assert (box.weight.sum(), box.wall_weight.sum()) == pytest.approx((0.07 * 0.05, 0.24))


def test_a_cup_has_the_modes_of_tables_up_to_a_wave_number() -> None:
    roots = np.unique(np.round(basin_of(cup()).modes.wave_number * 0.035, 4))
    # Abramowitz and Stegun, table 9.5: zeros of J_m' up to 9.76
    expected = [1.8412, 3.0542, 3.8317, 4.2012, 5.3176, 5.3314, 6.4156, 6.7061, 7.0156, 7.5013, 8.0152, 8.5363, 8.5778]
    assert roots == pytest.approx([*expected, 9.2824, 9.6474])


@pytest.mark.parametrize("cargo", CONTAINERS.values(), ids=CONTAINERS)
def test_frequencies_and_damping_are_those_of_the_linear_model(cargo: Cargo) -> None:
    assert cargo.filling is not None
    basin = linear_basin(cargo)
    for mode in cargo.filling.oscillators[:8]:
        same = np.isclose(basin.modes.wave_number, mode.wave_number, rtol=1e-9)
        assert basin.frequency[same] == pytest.approx(np.full(same.sum(), mode.frequency))
        assert basin.damping[same] == pytest.approx(np.full(same.sum(), mode.damping), rel=1e-6)


def test_laminar_damping_of_a_yaw_mode_is_that_of_the_linear_model() -> None:
    cargo = tub()
    assert cargo.filling is not None
    basin, mode = linear_basin(cargo), YawMode((0.07, 0.05), (1, 1), 0.049)
    same = int(np.argmin(np.abs(basin.modes.wave_number - mode.wave_number)))
    expected = mode.laminar_damping(cargo.filling.liquid)
    # a trapezoid rule along the wall
    assert laminar_damping(basin, cargo.filling.liquid.kinematic_viscosity)[same] == pytest.approx(expected, rel=1e-6)


def test_potential_of_a_turn_is_that_of_the_linear_model_and_slides_along_the_wall() -> None:
    modes = basin_of(tub()).modes
    assert modes.turn_potential == pytest.approx(zhukovsky_potential((0.07, 0.05), np.asarray(modes.points)), abs=1e-12)
    # no flow through the wall: its product with every slope is that of a divergence-free field without normal part
    assert np.abs(_divergence(basin_of(tub()))).max() < 1e-6


def _divergence(basin: Basin) -> np.ndarray:
    modes = basin.modes
    through = np.einsum("p,xp,xpj->j", modes.weight, modes.turn, modes.slope)
    return through / (modes.wave_number * modes.norm)
