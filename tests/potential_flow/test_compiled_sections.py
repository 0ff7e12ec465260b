"""The flow in boxes as machine code: what the law in Python gives, box by box, and what serves without it."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from nospill.compiled.small_libraries import small_library
from nospill.native import libraries
from nospill.potential_flow.basin import COARSE, FINE, basin_of
from nospill.potential_flow.compiled_sections import compiled_sections
from nospill.potential_flow.nonlinear import full_flow
from nospill.potential_flow.orders import LinearTerms, linear_terms
from nospill.potential_flow.solving import whole_flow
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from tests.hasty import COMPILER
from tests.waters import STILL, cup, tub

pytestmark = [
    pytest.mark.skipif(shutil.which(COMPILER) is None, reason="no C compiler"),
    pytest.mark.usefixtures("flow_library"),
]
STEP = 1e-3


def _case(terms: LinearTerms, seed: int, count: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """A random state (2, J) with waves of all modes, and rows (9, 2 m + 1) with leans and turns about all axes."""
    random, k = np.random.default_rng(seed), terms.basin.modes.wave_number
    state = random.normal(size=(2, len(k))) * 0.02 / np.min(k) * (np.min(k) / k) ** 1.5
    state[1] *= np.sqrt(STANDARD_GRAVITY / terms.stiffness)
    rows = 2.0 * random.normal(size=(9, 2 * count + 1))
    rows[8] += STANDARD_GRAVITY
    return state, rows


def _by_law(terms: LinearTerms, state: np.ndarray, rows: np.ndarray, step: float) -> np.ndarray:
    """One step: the classical Runge-Kutta method on `full_flow`."""
    k1 = full_flow(terms, state, rows[:, 0])
    k2 = full_flow(terms, state + step / 2 * k1, rows[:, 1])
    k3 = full_flow(terms, state + step / 2 * k2, rows[:, 1])
    k4 = full_flow(terms, state + step * k3, rows[:, 2])
    return state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def _stepped(terms: list[LinearTerms], states: np.ndarray, rows: np.ndarray, step: np.ndarray) -> np.ndarray:
    steps = compiled_sections(terms)
    assert steps is not None
    return steps(states, rows, step)


@pytest.mark.parametrize(
    ("liquid", "finest"),
    [
        pytest.param(tub(), FINE, id="box"),
        pytest.param(tub(), COARSE, id="fewer modes"),
        pytest.param(tub(0.2, 0.03, 0.3), FINE, id="long and deep"),
        pytest.param(tub(0.05, 0.05, 0.01), FINE, id="square and shallow"),
        pytest.param(cup(), FINE, id="cup"),
    ],
)
def test_a_step_is_the_one_by_law(liquid: object, finest: float) -> None:
    terms = linear_terms(basin_of(liquid, finest))  # type: ignore[arg-type]
    cases = [_case(terms, seed) for seed in (1, 2)]
    states, rows = np.stack([state for state, _ in cases]), np.stack([own for _, own in cases], axis=-1)
    step = STEP * np.array([1.0, 0.7])
    found = _stepped([terms, terms], states, rows, step)
    np.testing.assert_array_equal(found[0], states)
    for index, (state, own) in enumerate(cases):
        expected = _by_law(terms, state, own, float(step[index]))
        change = np.max(np.abs(expected - state), axis=-1, keepdims=True)
        assert np.all(np.abs(found[1, index] - expected) <= 1e-11 * change)


def test_a_processor_without_fused_products_finds_the_same(
    flow_library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    terms = linear_terms(basin_of(tub()))
    state, rows = _case(terms, 3, 3)
    arguments = [terms], state[None], rows[..., None], np.array([STEP])
    expected = _stepped(*arguments)
    plain = "#define WITHOUT_FMA\n" + libraries.source("flow")
    monkeypatch.setattr(libraries, "source", lambda _: plain)
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path / "cache"))
    other = small_library("flow", wait=True)
    assert other is not None and other != flow_library
    np.testing.assert_allclose(_stepped(*arguments), expected, rtol=1e-10, atol=1e-12 * np.max(np.abs(expected)))


@pytest.mark.parametrize("count", [90, 400], ids=["goes through", "breaks down"])
def test_flows_end_where_they_end_by_law(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    terms = linear_terms(basin_of(tub(), COARSE))
    rows = np.tile(STILL[:, None], (1, 2 * count + 1))
    rows[6] = np.linspace(0.0, 30.0, 801)[: rows.shape[1]]
    start = np.zeros((2, len(terms.stiffness)))
    states = whole_flow(terms, start, rows, STEP)
    monkeypatch.setenv("NOSPILL_COMPILE", "off")
    assert compiled_sections([terms]) is None
    expected = whole_flow(terms, start, rows, STEP)
    assert len(states) == len(expected) and (len(states) == count + 1) == (count == 90)
    np.testing.assert_allclose(states[:80], expected[:80], atol=1e-10 * np.max(np.abs(expected[:80])))
