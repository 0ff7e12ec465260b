"""The nonlinear flow of several liquids at once, against each followed by itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nospill.errors import ModelError
from nospill.laws.slosh.residual import free_states
from nospill.potential_flow import flow_terms, flows_along, of_masses, rows_at
from nospill.potential_flow.solving import whole_flow
from nospill.scene.cargo import Cargo
from nospill.scene.swing import Swing, swing_of
from tests.waters import STILL, cup, tub

_T = np.linspace(0.0, 0.5, 501)


def _moved(size: float) -> np.ndarray:
    """(9, m) a move sideways with a turn and a lean, from rest to rest, with a largest acceleration of `size` m/s^2."""
    shape = np.where(_T < 0.4, np.sin(np.pi * _T / 0.4), 0.0)
    body = np.tile(STILL[:, None], (1, len(_T)))
    body[6], body[2], body[0] = size * np.sin(2 * np.pi * _T / 0.4) * (_T < 0.4), 2.0 * shape**2, 0.3 * shape**2
    body[5], body[3] = np.gradient(body[2], _T), np.gradient(body[0], _T)
    return body


def _alone(cargo: Cargo, body: np.ndarray, count: int = 240) -> np.ndarray:
    terms = flow_terms(cargo)
    t = np.linspace(0.0, _T[-1], 2 * count + 1)
    rows = np.stack([np.interp(t, _T, row) for row in body])
    own = rows_at(rows_at(rows, cargo.place, cargo.yaw), np.array([0.0, 0.0, terms.basin.depth]))
    return whole_flow(terms, np.zeros((2, len(terms.stiffness))), own, t[2])[-1]


def test_each_is_as_if_followed_alone() -> None:
    near, far = cup(), replace(cup(), position=(0.1, 0.05), yaw=0.5)
    objects, body = [near, tub(), far, cup(0.05, 0.03), cup(0.025, 0.08)], _moved(0.5)
    found = flows_along(objects, _T, body)
    for cargo, flow in zip(objects, found, strict=True):
        expected = _alone(cargo, body)
        np.testing.assert_allclose(flow.end[0], expected[0], atol=0.02 * np.max(np.abs(expected[0])))
        assert flow.breaks_at is None
    assert np.max(np.abs(found[0].end - found[2].end)) > 1e-4


def test_what_is_faster_than_the_steps_is_not_taken_for_something_slow() -> None:
    """Rows of joints with six digits at 1 kHz: they scatter, and their sums do not; at the steps alone they would."""
    scatter = np.zeros((9, len(_T)))
    places = 1e-6 * np.random.default_rng(3).standard_normal((3, len(_T)))
    scatter[6:, 1:-1] = np.diff(places, 2) / (_T[1] - _T[0]) ** 2
    body = _moved(0.5)
    (calm,), (rough,) = flows_along([cup()], _T, body), flows_along([cup()], _T, body + scatter)
    assert np.max(np.abs(scatter)) > 2.0  # m/s^2, four times what moves it
    np.testing.assert_allclose(rough.end[0], calm.end[0], atol=0.03 * np.max(np.abs(calm.end[0])))


def test_which_others_there_are_changes_nothing() -> None:
    """Each cup has steps of its own, however small those of a faster one are."""
    objects, body = [cup(0.05, 0.03), cup(0.025, 0.08), cup()], _moved(0.5)
    for cargo, flow in zip(objects, flows_along(objects, _T, body), strict=True):
        (alone,) = flows_along([cargo], _T, body)
        assert flow.step == alone.step and flow.states.shape == alone.states.shape
        np.testing.assert_allclose(flow.states, alone.states, atol=1e-11 * np.max(np.abs(alone.states)))


def test_one_that_breaks_down_leaves_the_others() -> None:
    calm, far = cup(), replace(cup(), position=(3.0, 0.0))
    body = _moved(0.5)
    body[2] *= 4.0
    body[5] *= 4.0
    together, alone = flows_along([calm, far], _T, body), flows_along([calm], _T, body)
    assert np.all(np.isnan(together[1].end))
    assert together[1].breaks_at is not None and 0.02 < together[1].breaks_at < 0.4
    np.testing.assert_allclose(together[0].end, alone[0].end, atol=1e-12)


def _swinging(cargo: Cargo, swing: Swing) -> Cargo:
    assert cargo.filling is not None
    return replace(cargo, filling=replace(cargo.filling, initial_swing=swing))


def test_a_flow_goes_on_from_its_own_state() -> None:
    """From a step of the motion on, with the masses where they are and without: what is theirs is in the rest then."""
    for cargo in (cup(), tub()):
        (whole,), terms = flows_along([cargo], _T, _moved(0.5)), flow_terms(cargo)
        middle = len(whole.states) // 2
        t, count = middle * whole.step, sum(len(mode.directions) for mode in cargo.oscillators)
        later = _T[t < _T]
        body = np.hstack([np.array([[np.interp(t, _T, row)] for row in _moved(0.5)]), _moved(0.5)[:, t < _T]])
        moved = np.random.default_rng(1).normal(size=(2, count)) * [[1e-3], [1e-2]]
        for masses in (np.zeros((2, count)), moved):
            height, potential = whole.states[middle] - of_masses(cargo, terms, *masses)
            swing = replace(
                swing_of(cargo.oscillators, *masses),
                flow_height=tuple(height.tolist()),
                flow_potential=tuple(potential.tolist()),
            )
            (found,) = flows_along([_swinging(cargo, swing)], np.r_[t, later], body)
            np.testing.assert_allclose(found.states[0], whole.states[middle], atol=1e-12)
            np.testing.assert_allclose(found.end[0], whole.end[0], atol=0.01 * np.max(np.abs(whole.end[0])))


def test_a_mass_that_is_moved_moves_the_flow_as_its_mode_does() -> None:
    """A little swing of one mode in a container that stands: the crest swings with its frequency and damping."""
    cargo = cup()
    slowest = min(cargo.oscillators, key=lambda mode: mode.frequency)
    empty = (0.0,) * len(flow_terms(cargo).stiffness)
    swing = Swing(((1e-5, 0.0),), ((0.0, 0.0),), flow_height=empty, flow_potential=empty)
    (flow,) = flows_along([_swinging(cargo, swing)], _T, np.tile(STILL[:, None], (1, len(_T))))
    t = flow.step * np.arange(len(flow.states))
    mode = int(np.argmax(np.abs(flow.states[0, 0])))
    expected = (
        slowest.surface_gain
        * free_states(np.array([slowest.frequency]), np.array([slowest.damping]), np.array([1e-5]), np.zeros(1), t)[0][
            :, 0
        ]
    )
    np.testing.assert_allclose(flow.states[:, 0, mode], expected, atol=2e-3 * expected[0])


def test_a_flow_of_other_modes_is_refused() -> None:
    swing = Swing(((1e-5, 0.0),), ((0.0, 0.0),), flow_height=(0.0,) * 5, flow_potential=(0.0,) * 5)
    with pytest.raises(ModelError, match="has the flow in 5 modes; its liquid has 28"):
        flows_along([_swinging(cup(), swing)], _T, _moved(0.5))


def test_without_liquids_there_is_nothing() -> None:
    assert flows_along([], _T, _moved(1.0)) == []


def test_terms_are_kept_for_like_liquids() -> None:
    assert flow_terms(cup()) is flow_terms(replace(cup(), position=(0.1, 0.0)))
    assert flow_terms(cup()) is not flow_terms(cup(liquid_height=0.03))
    assert len(flow_terms(cup()).stiffness) == pytest.approx(28)


def test_steps_follow_the_damping_of_syrups() -> None:
    """With steps of the fastest mode alone its crests, which damping acts on more than on low waves, break down."""
    liquid = {"density": 1200, "kinematic_viscosity": 1e-3, "surface_tension": 0.06}
    syrup, body = cup(liquid=liquid), _moved(2.0)
    (flow,), expected = flows_along([syrup], _T, body), _alone(syrup, body, 960)
    assert flow.breaks_at is None
    np.testing.assert_allclose(flow.end[0], expected[0], atol=0.02 * np.max(np.abs(expected[0])))
