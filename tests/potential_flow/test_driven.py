"""The second order along known waves of the first, against the integration of both orders together."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.potential_flow import driven, height_gains, rows_at, second_order_states
from nospill.potential_flow.basin import basin_of
from nospill.potential_flow.driven_along import recursion
from nospill.potential_flow.orders import first_order, linear_terms, second_order_sources
from nospill.potential_flow.solving import two_orders
from nospill.scenario import read_scenario
from nospill.scene.cargo import Cargo
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from tests.waters import cup, pushed_and_turned, tub

_STEP = 1e-3
_COUNT = 900


def _both(cargo: Cargo, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Heights (m, J) of second order, both orders integrated together and driven by the first order's masses."""
    liquid = driven(cargo)
    start = np.zeros((2, len(liquid.terms.stiffness)))
    states = two_orders(liquid.terms, start, rows, _STEP)
    first, at = states[:, 0], rows[:, ::2]
    masses = np.linalg.pinv(liquid.gains).T
    velocity = first_order(liquid.terms, first, at)[:, 0] @ masses
    body = rows_at(at, np.array([0.0, 0.0, -liquid.terms.basin.depth]))
    return states[:, 1, 0], second_order_states(liquid, body, first[:, 0] @ masses, velocity, _STEP)[:, 0]


@pytest.mark.parametrize(("turn", "lean"), [(0.0, 0.0), (4.0, 0.0), (4.0, 0.8)])
def test_in_a_cup_it_is_that_of_both_orders_together(turn: float, lean: float) -> None:
    expected, found = _both(cup(), pushed_and_turned(turn, lean, _STEP, _COUNT))
    largest = np.max(np.abs(expected))
    assert largest > 2e-4
    np.testing.assert_allclose(found, expected, atol=0.01 * largest)


def test_in_a_box_that_does_not_turn_too() -> None:
    expected, found = _both(tub(), pushed_and_turned(0.0, 0.8, _STEP, _COUNT))
    largest = np.max(np.abs(expected))
    assert largest > 2e-4
    np.testing.assert_allclose(found, expected, atol=0.015 * largest)


@pytest.mark.parametrize("sides", [(0.08, 0.06), (0.08, 0.08)])
def test_a_turn_pushes_a_yaw_mode_as_it_pushes_its_mass(sides: tuple[float, float]) -> None:
    """Of both modes of one frequency in a square box, too: C d'' of the mass is kappa times the turn's pressure."""
    changes: dict[str, object] = {"cargo.box.length": sides[0], "cargo.box.width": sides[1]}
    box = next(item for item in read_scenario("mixed-tray").changed(changes).cargo if item.name == "box")
    terms, columns = linear_terms(basin_of(box)), [mode for mode in box.oscillators for _ in mode.directions]
    gains = height_gains(box.oscillators, terms.basin)
    carried = [(mode, column) for mode, column in zip(columns, gains.T, strict=True) if mode.yaws and np.any(column)]
    assert len(carried) >= 4
    for mode, column in carried:
        own = int(np.argmax(np.abs(column)))
        assert column[own] * mode.arm == pytest.approx(terms.stiffness[own] * terms.turn[own], rel=1e-6, abs=1e-9)
    assert len({int(np.argmax(np.abs(column))) for _, column in carried}) == len(carried)


def test_twice_the_waves_drive_four_times_the_heights() -> None:
    rows = pushed_and_turned(3.0, 0.0, _STEP, _COUNT)
    liquid = driven(cup())
    swing = np.random.default_rng(1).normal(size=(liquid.gains.shape[1], 2)) * 1e-3
    t = _STEP * np.arange(_COUNT + 1)
    q, qd = np.sin(25 * t)[:, None] * swing[:, 0], 25 * np.cos(25 * t)[:, None] * swing[:, 0]
    body = rows[:, ::2].copy()
    body[:6], body[6:8] = 0.0, 0.0  # the waves alone
    once, twice = (second_order_states(liquid, body, by * q, by * qd, _STEP)[:, 0] for by in (1.0, 2.0))
    np.testing.assert_allclose(twice, 4 * once, atol=1e-12)


@pytest.mark.parametrize("cargo", [cup(), tub()])
def test_what_begins_in_a_state_goes_on_as_it_did(cargo: Cargo) -> None:
    step, count = _STEP / 4, 2 * _COUNT  # several to each of the instants at which it is integrated
    liquid, rows = driven(cargo), pushed_and_turned(3.0, 0.8, step, count)[:, ::2]
    swing = np.random.default_rng(2).normal(size=liquid.gains.shape[1]) * 1e-3
    t = step * np.arange(count + 1)
    q, qd = np.sin(25 * t)[:, None] * swing, 25 * np.cos(25 * t)[:, None] * swing
    whole = second_order_states(liquid, rows, q, qd, step)
    half = count // 2 + 1  # between two of these
    rest = second_order_states(liquid, rows[:, half:], q[half:], qd[half:], step, whole[half])
    largest = np.max(np.abs(whole), axis=(0, 2))
    assert np.all(largest > 1e-5)
    for order in (0, 1):
        np.testing.assert_allclose(rest[:, order], whole[half:, order], atol=2e-4 * largest[order])


@pytest.mark.parametrize("liquid", [cup(), tub()], ids=["cup", "box"])
def test_forms_of_the_modes_that_drive_are_products_at_points(liquid: Cargo) -> None:
    followed, draws = driven(liquid), np.random.default_rng(3)
    rows = draws.normal(size=(9, 6)) + np.array([0, 0, 0, 0, 0, 0, 0, 0, STANDARD_GRAVITY])[:, None]
    first = np.zeros((6, 2, len(followed.terms.stiffness)))
    first[..., followed.interactions.moved] = 0.01 * draws.normal(size=(6, 2, len(followed.interactions.moved)))
    expected = second_order_sources(followed.terms, first, rows)
    found = followed.interactions.sources(first, rows)
    np.testing.assert_allclose(found, expected, atol=1e-12 * np.max(np.abs(expected)), rtol=0)


@pytest.mark.parametrize("count", [1, 2, 3, 7, 50])
def test_blocks_of_a_recursion_are_its_steps(count: int) -> None:
    draws = np.random.default_rng(count)
    onwards, pushed = draws.normal(size=(count, 2, 2, 3)), draws.normal(size=(count, 2, 3)) + 1j
    expected = [draws.normal(size=(2, 3)).astype(complex)]
    for matrix, push in zip(onwards, pushed, strict=True):
        expected.append(np.einsum("xyl,yl->xl", matrix, expected[-1]) + push)
    found = recursion(onwards, pushed, expected[0])
    np.testing.assert_allclose(found, expected, atol=1e-12 * np.max(np.abs(expected)), rtol=0)
