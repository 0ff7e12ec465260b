"""The flow in cups as machine code: what the law in Python gives, cup by cup, and what serves without it."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from nospill.compiled.small_libraries import small_library
from nospill.native import libraries
from nospill.potential_flow import compiled_steps as module
from nospill.potential_flow.basin import COARSE, FINE, basin_of
from nospill.potential_flow.compiled_steps import compiled_steps
from nospill.potential_flow.nonlinear import full_flow
from nospill.potential_flow.orders import LinearTerms, linear_terms
from nospill.potential_flow.solving import flow_states, whole_flow
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from tests.hasty import COMPILER
from tests.waters import STILL, cup, tub

pytestmark = [
    pytest.mark.skipif(shutil.which(COMPILER) is None, reason="no C compiler"),
    pytest.mark.usefixtures("flow_library"),
]
STEP = 1e-3


def _terms(finest: float = FINE, radius: float = 0.035, depth: float = 0.049) -> LinearTerms:
    return linear_terms(basin_of(cup(radius, depth), finest))


def _stepped(terms: LinearTerms, states: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """States (m + 1, c, 2, J) of c like cups."""
    return _stepped_each([terms] * len(states), states, rows, np.full(len(states), STEP))


def _stepped_each(terms: Sequence[LinearTerms], states: np.ndarray, rows: np.ndarray, step: np.ndarray) -> np.ndarray:
    steps = compiled_steps(terms)
    assert steps is not None
    return steps(states, rows, step)


def _case(terms: LinearTerms, cups: int, count: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Random states (c, 2, J) with waves of all modes, and rows (9, 2 m + 1, c) with leans and turns in all axes."""
    random, k = np.random.default_rng(cups), terms.basin.modes.wave_number
    states = random.normal(size=(cups, 2, len(k))) * 0.02 / k[0] * (k[0] / k) ** 1.5
    states[:, 1] *= np.sqrt(STANDARD_GRAVITY / terms.stiffness)
    rows = 2.0 * random.normal(size=(9, 2 * count + 1, cups))
    rows[8] += STANDARD_GRAVITY
    return states, rows


def _by_law(terms: LinearTerms, state: np.ndarray, rows: np.ndarray, step: float = STEP) -> np.ndarray:
    """One step of one cup: the classical Runge-Kutta method on `full_flow`."""
    k1 = full_flow(terms, state, rows[:, 0])
    k2 = full_flow(terms, state + step / 2 * k1, rows[:, 1])
    k3 = full_flow(terms, state + step / 2 * k2, rows[:, 1])
    k4 = full_flow(terms, state + step * k3, rows[:, 2])
    return state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


@pytest.mark.parametrize("cups", [1, 3, 4, 5, 9])
def test_a_step_is_the_one_by_law(cups: int) -> None:
    terms = _terms()
    states, rows = _case(terms, cups)
    found = _stepped(terms, states, rows)
    np.testing.assert_allclose(found[0], states, rtol=1e-15)
    for index in range(cups):
        expected = _by_law(terms, states[index], rows[..., index])
        change = np.max(np.abs(expected - states[index]), axis=-1, keepdims=True)
        assert np.all(np.abs(found[1, index] - expected) <= 1e-12 * change)


@pytest.mark.parametrize(
    ("finest", "radius", "depth"),
    [
        pytest.param(COARSE, 0.035, 0.049, id="an even number of spokes"),
        pytest.param(1.7, 0.035, 0.049, id="few modes"),
        pytest.param(FINE, 0.02, 0.3, id="a deep cup"),
        pytest.param(FINE, 0.1, 0.02, id="a shallow bowl"),
    ],
)
def test_cups_of_other_sizes_and_modes(finest: float, radius: float, depth: float) -> None:
    own = _terms(finest, radius, depth)
    (state,), rows = _case(own, 1)
    expected = _by_law(own, state, rows[..., 0])
    found = _stepped(own, state[None], rows)[1, 0]
    change = np.max(np.abs(expected - state), axis=-1, keepdims=True)
    assert np.all(np.abs(found - expected) <= 1e-12 * change)


def test_cups_of_other_sizes_and_steps_go_side_by_side() -> None:
    sizes = [(0.035, 0.049), (0.02, 0.3), (0.1, 0.02), (0.04, 0.01), (0.03, 0.06)]
    terms, step = [_terms(FINE, *size) for size in sizes], STEP * np.array([1.0, 0.5, 2.0, 0.7, 1.2])
    cases = [_case(one, 1) for one in terms]
    rows = np.concatenate([own for _, own in cases], axis=-1)
    found = _stepped_each(terms, np.concatenate([state for state, _ in cases]), rows, step)[1]
    for index, ((state,), own) in enumerate(cases):
        expected = _by_law(terms[index], state, own[..., 0], float(step[index]))
        change = np.max(np.abs(expected - state), axis=-1, keepdims=True)
        assert np.all(np.abs(found[index] - expected) <= 1e-11 * change)


def test_a_processor_without_fused_products_finds_the_same(
    flow_library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    terms = _terms(COARSE)
    states, rows = _case(terms, 2, 3)
    expected = _stepped(terms, states, rows)
    plain = "#define WITHOUT_FMA\n" + libraries.source("flow")
    monkeypatch.setattr(libraries, "source", lambda _: plain)
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path / "cache"))
    other = small_library("flow", wait=True)
    assert other is not None and other != flow_library
    found = _stepped(terms, states, rows)
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-12 * np.max(np.abs(expected)))


def test_a_cup_that_breaks_down_leaves_the_others_to_the_last_bit() -> None:
    terms = _terms(COARSE)
    states, rows = _case(terms, 3, 20)
    alone = _stepped(terms, states[:1], rows[..., :1])
    states[1] *= 30.0
    together = _stepped(terms, states, rows)
    np.testing.assert_array_equal(together[:, 0], alone[:, 0])
    assert not np.any(np.isfinite(together[-1, 1]))


def _pushed(count: int) -> np.ndarray:
    """(9, 2 m + 1) rows of a container that is pushed sideways harder and harder."""
    rows = np.tile(STILL[:, None], (1, 2 * count + 1))
    rows[6] = np.linspace(0.0, 30.0, rows.shape[1])
    return rows


@pytest.mark.parametrize("count", [90, 400], ids=["goes through", "breaks down"])
def test_flows_end_where_they_end_by_law(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    terms, rows = _terms(COARSE), _pushed(400)[:, : 2 * count + 1]
    start = np.zeros((2, len(terms.stiffness)))
    states, (ends, reached) = (
        whole_flow(terms, start, rows, STEP),
        flow_states([terms], start[None], rows[..., None], np.array([STEP])),
    )
    monkeypatch.setenv("NOSPILL_COMPILE", "off")
    assert compiled_steps([terms]) is None
    expected, (others, steps) = (
        whole_flow(terms, start, rows, STEP),
        flow_states([terms], start[None], rows[..., None], np.array([STEP])),
    )
    assert len(states) == len(expected) == steps[0] + 1 == reached[0] + 1
    assert (len(states) == count + 1) == (count == 90)
    np.testing.assert_allclose(states[:80], expected[:80], atol=1e-10 * np.max(np.abs(expected[:80])))
    np.testing.assert_allclose(ends, others, rtol=1e-6, atol=1e-9)


def test_boxes_and_libraries_that_do_not_load_are_left_to_python(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    assert compiled_steps([linear_terms(basin_of(tub()))]) is None
    broken = tmp_path / "flow.so"
    broken.write_bytes(b"not a library")
    monkeypatch.setattr(module, "_IN_USE", {})
    monkeypatch.setattr(module, "small_library", lambda *_, **__: broken)
    assert compiled_steps([_terms(COARSE)]) is None
