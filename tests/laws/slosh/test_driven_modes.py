"""Waves of second order as coordinates of the laws, against both orders of the flow together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from nospill.core.frames import body_motion
from nospill.core.trees import constants
from nospill.laws.parameters import ObjectNumbers
from nospill.laws.sample import object_states
from nospill.laws.scene_parameters import object_numbers, object_structure
from nospill.laws.slosh.driven_modes import driven_frequencies, driven_residual, swinging_on
from nospill.laws.slosh.motion import OscillatorState, modal_accelerations
from nospill.potential_flow import rows_at
from nospill.potential_flow.driven_numbers import (
    driven_gains,
    driven_kind,
    driven_modes,
    driven_numbers,
    driven_patterns,
    driven_terms,
    masses_of_modes,
)
from nospill.potential_flow.solving import two_orders
from nospill.scene.cargo import Cargo
from nospill.scene.carriers import with_modes
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from tests.waters import cup, pushed_and_turned, tub

_STEP, _COUNT = 1e-3, 700
_WEAK = 0.5
_SX = ca.SX


def _carrying(cargo: Cargo) -> Cargo:
    """With two modes and what they drive."""
    few = with_modes(cargo, 2)
    assert few.filling is not None
    return replace(few, filling=replace(few.filling, drives=True))


def _turning(cargo: Cargo) -> Cargo:
    assert cargo.filling is not None
    return replace(cargo, filling=replace(cargo.filling, turns=True))


def _linear_numbers(cargo: Cargo) -> ObjectNumbers:
    """With masses that slide on planes, as linear theory has them."""
    numbers = object_numbers(cargo, fidelity="full", gravity=STANDARD_GRAVITY)
    return replace(numbers, oscillators=tuple(replace(mode, curvature=0.0) for mode in numbers.oscillators))


def _functions(cargo: Cargo) -> tuple[ca.Function, ca.Function]:
    """(b, b', body, q, q') -> accelerations of the modes with states; amplitudes of all modes that are left."""
    item = object_structure(cargo)
    numbers = constants(_linear_numbers(cargo))
    count = item.driven_coordinates
    height, rate, body = _SX.sym("b", count), _SX.sym("v", count), _SX.sym("body", 9)
    q, qd = _SX.sym("q", item.linear_coordinates), _SX.sym("qd", item.linear_coordinates)
    states = object_states(item, q, qd, _SX.zeros(item.linear_coordinates))
    own = OscillatorState(height, rate, _SX.zeros(count))
    arguments = [height, rate, body, q, qd]
    motion = body_motion(body)
    masses, squares = swinging_on(item, numbers, motion, states, own)
    moved = masses_of_modes(item.oscillators, item.driven)
    amplitudes = [
        numbers.oscillators[index].surface_gain
        * ca.sqrt(masses[index].displacement ** 2 + (masses[index].velocity / numbers.oscillators[index].frequency) ** 2)
        for index in moved
    ]
    return (
        ca.Function("a", arguments, [-driven_residual(item, numbers, motion, states, own)]),
        ca.Function("s", arguments, [ca.vertcat(*amplitudes, ca.sqrt(squares))]),
    )


def _rolled(rate: Callable[[np.ndarray, int], np.ndarray], size: int) -> np.ndarray:
    """States (m + 1, size) from rest, by Runge-Kutta steps over two instants each."""
    state = np.zeros(size)
    found = [state]
    for index in range(0, _COUNT, 2):
        k1 = rate(state, index)
        k2 = rate(state + _STEP * k1, index + 1)
        k3 = rate(state + _STEP * k2, index + 1)
        k4 = rate(state + 2 * _STEP * k3, index + 2)
        state = state + _STEP / 3 * (k1 + 2 * k2 + 2 * k3 + k4)
        found.append(state)
    return np.array(found)


def _followed(cargo: Cargo, body: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Masses by their law and states by theirs, (m + 1, k) and (m + 1, d) displacements, and amplitudes at the end.

    `body` are rows (9, 2 m + 1).
    """
    item = object_structure(cargo)
    accelerations, left = _functions(cargo)
    k, d = item.linear_coordinates, item.driven_coordinates
    numbers = constants(_linear_numbers(cargo))
    q, qd, row = _SX.sym("q", k), _SX.sym("qd", k), _SX.sym("body", 9)
    of_masses = modal_accelerations(item, numbers, body_motion(row), q, qd, damp_against_spin=False)
    masses = ca.Function("m", [q, qd, row], [of_masses])

    def rate(state: np.ndarray, index: int) -> np.ndarray:
        parts, at = np.split(state, [k, 2 * k, 2 * k + d]), body[:, index]
        of_states = np.array(accelerations(parts[2], parts[3], at, parts[0], parts[1])).ravel()
        return np.concatenate([parts[1], np.array(masses(parts[0], parts[1], at)).ravel(), parts[3], of_states])

    states = _rolled(rate, 2 * (k + d))
    end = np.split(states[-1], [k, 2 * k, 2 * k + d])
    amplitudes = np.array(left(end[2], end[3], body[:, -1], end[0], end[1])).ravel()
    return states[:, :k], states[:, 2 * k : 2 * k + d], amplitudes


@pytest.mark.parametrize("liquid", [cup(), tub(), _turning(tub())], ids=["cup", "box", "turning box"])
@pytest.mark.parametrize(("turn", "lean"), [(0.0, 0.0), (4.0, 0.0), (4.0, 0.8)])
def test_their_equations_are_those_of_both_orders_together(liquid: Cargo, turn: float, lean: float) -> None:
    cargo = _carrying(liquid)
    kind, terms = driven_modes(driven_kind(cargo)), driven_terms(cargo)
    if driven_kind(cargo) == "box" and turn:
        pytest.skip("a box that does not turn")
    rows = _WEAK * pushed_and_turned(0.0, lean, _STEP, _COUNT) + (1 - _WEAK) * np.r_[np.zeros(8), STANDARD_GRAVITY][:, None]
    rows[[2, 5]] = pushed_and_turned(turn, 0.0, _STEP, _COUNT)[[2, 5]]
    about_surface = rows_at(rows, np.array([0.0, 0.0, terms.basin.depth]))
    both = two_orders(terms, np.zeros((2, kind.count)), about_surface, _STEP)[::2]
    masses, states, left = _followed(cargo, rows[:, ::2])
    of_masses = masses @ driven_gains(cargo).T
    found, wanted = of_masses.copy(), both[:, :, 0].sum(axis=1)
    found[:, kind.first :] += states
    largest = np.max(np.abs(wanted), axis=0)
    print(np.max(np.abs(found - wanted), axis=0) / np.max(largest), largest)
@pytest.mark.parametrize(("radius", "depth"), [(0.035, 0.049), (0.05, 0.02), (0.02, 0.09)])
def test_what_is_zero_in_one_cup_is_in_all(radius: float, depth: float) -> None:
    numbers = driven_numbers(cup(radius, depth))
    for name, pattern in driven_patterns().items():
        largest = np.max(np.abs(numbers[name]), initial=1e-300)
        assert np.all(np.abs(numbers[name][~pattern]) <= 1e-9 * largest), name


def test_there_are_those_without_nodal_diameters_and_with_two() -> None:
    cargo = cup()
    waves = driven(cargo).terms.basin.modes.wave_number[_swings(cargo)] * 0.035
    np.testing.assert_allclose(waves, [3.8317, 7.0156, 3.0542, 3.0542, 6.7061, 6.7061], atol=1e-4)
    np.testing.assert_allclose(
        _frequencies(_carrying(cargo)), driven(cargo).terms.basin.frequency[_swings(cargo)], rtol=1e-9
    )
