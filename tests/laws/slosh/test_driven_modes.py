"""Waves of second order as coordinates of the laws, against both orders of the flow together."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from nospill.core.frames import body_motion
from nospill.core.trees import constants
from nospill.laws.sample import object_states
from nospill.laws.scene_parameters import object_numbers, object_structure
from nospill.laws.slosh.driven_modes import driven_frequencies, driven_residual, driven_squares
from nospill.laws.slosh.motion import OscillatorState
from nospill.potential_flow import driven, rows_at
from nospill.potential_flow.driven_numbers import driven_count, driven_numbers, driven_patterns
from nospill.potential_flow.orders import first_order
from nospill.potential_flow.solving import two_orders
from nospill.scene.cargo import Cargo
from nospill.scene.carriers import with_modes
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from tests.waters import cup, pushed_and_turned

_STEP, _COUNT = 1e-3, 700
_SX = ca.SX


def _carrying(cargo: Cargo) -> Cargo:
    """With two modes and what they drive."""
    few = with_modes(cargo, 2)
    assert few.filling is not None
    return replace(few, filling=replace(few.filling, drives=True))


def _swings(cargo: Cargo) -> np.ndarray:
    liquid = driven(cargo)
    return np.setdiff1d(np.arange(len(liquid.terms.stiffness)), liquid.interactions.moved)


def _functions(cargo: Cargo) -> tuple[ca.Function, ca.Function]:
    """(b, b', body, q, q') -> accelerations of the driven modes; squares of their amplitudes."""
    item = object_structure(cargo)
    numbers = constants(object_numbers(cargo, fidelity="full", gravity=STANDARD_GRAVITY))
    height, rate, body = _SX.sym("b", item.driven), _SX.sym("v", item.driven), _SX.sym("body", 9)
    q, qd = _SX.sym("q", item.linear_coordinates), _SX.sym("qd", item.linear_coordinates)
    states = object_states(item, q, qd, _SX.zeros(item.linear_coordinates))
    own = OscillatorState(height, rate, _SX.zeros(item.driven))
    arguments = [height, rate, body, q, qd]
    motion = body_motion(body)
    return (
        ca.Function("a", arguments, [-driven_residual(numbers, motion, states, own)]),
        ca.Function("s", arguments, [driven_squares(numbers, motion, states, own)]),
    )


def _both_orders(cargo: Cargo, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Displacements and velocities (m + 1, k) of the masses, and states (m + 1, 2, J) of second order, in one flow."""
    liquid = driven(cargo)
    about_surface = rows_at(rows, np.array([0.0, 0.0, liquid.terms.basin.depth]))
    states = two_orders(liquid.terms, np.zeros((2, len(liquid.terms.stiffness))), about_surface, _STEP)
    masses = np.linalg.pinv(liquid.gains).T
    rates = first_order(liquid.terms, states[:, 0], about_surface[:, ::2])[:, 0]
    return states[:, 0, 0] @ masses, rates @ masses, states[:, 1]


@pytest.mark.parametrize(("turn", "lean"), [(0.0, 0.0), (4.0, 0.0), (4.0, 0.8)])
def test_their_equations_are_those_of_both_orders_together(turn: float, lean: float) -> None:
    cargo, rows = _carrying(cup()), pushed_and_turned(turn, lean, _STEP, _COUNT)
    q, qd, second = _both_orders(cargo, rows)
    (accelerations, squares), at, count = _functions(cargo), rows[:, ::2], driven_count()
    every = accelerations.map(len(q))

    def at_all(state: np.ndarray) -> np.ndarray:
        parts = (np.repeat(part[:, None], len(q), axis=1) for part in np.split(state, 2))
        return np.array(every(*parts, at, q.T, qd.T))

    drive = at_all(np.zeros(2 * count))  # the equations are linear in their own state
    matrices = np.stack([at_all(unit) - drive for unit in np.eye(2 * count)], axis=1)

    def rate(state: np.ndarray, index: int) -> np.ndarray:
        return np.concatenate([state[count:], matrices[:, :, index] @ state + drive[:, index]])

    state, found = np.zeros(2 * count), [np.zeros(count)]
    for index in range(0, _COUNT, 2):
        k1 = rate(state, index)
        k2 = rate(state + _STEP * k1, index + 1)
        k3 = rate(state + _STEP * k2, index + 1)
        k4 = rate(state + 2 * _STEP * k3, index + 2)
        state = state + _STEP / 3 * (k1 + 2 * k2 + 2 * k3 + k4)
        found.append(state[:count])
    own = second[::2, :, _swings(cargo)]
    largest = np.max(np.abs(own[:, 0]))
    assert largest > 2e-4
    np.testing.assert_allclose(np.array(found), own[:, 0], atol=0.01 * largest)
    kappa, frequency = driven(cargo).terms.stiffness[_swings(cargo)], _frequencies(cargo)
    free = np.hypot(own[-1, 0], kappa * own[-1, 1] / frequency)  # once the cup stands
    left = np.array(squares(state[:count], state[count:], at[:, -1], q[-1], qd[-1])).ravel()
    np.testing.assert_allclose(np.sqrt(left), free, atol=0.01 * largest)


def _frequencies(cargo: Cargo) -> np.ndarray:
    numbers = object_numbers(cargo, fidelity="full", gravity=STANDARD_GRAVITY)
    return driven_frequencies(numbers.driven, STANDARD_GRAVITY)


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
