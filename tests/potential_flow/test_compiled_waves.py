"""Waves of second order as machine code: what the law in Python gives, motion by motion, and what serves without it."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from nospill.compiled.small_libraries import small_library
from nospill.native import libraries
from nospill.potential_flow import Driven, driven, second_order_states
from nospill.potential_flow.compiled_waves import compiled_waves
from nospill.scene.cargo import Cargo
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from tests.compiling import own_library
from tests.hasty import COMPILER
from tests.waters import cup, pushed_and_turned, tub

pytestmark = pytest.mark.skipif(shutil.which(COMPILER) is None, reason="no C compiler")
_LIQUIDS = [
    pytest.param(cup(), id="cup"),
    pytest.param(cup(0.1, 0.02), id="a shallow bowl"),
    pytest.param(cup(0.02, 0.3), id="a deep cup"),
    pytest.param(tub(), id="box"),
]


@pytest.fixture(scope="module", autouse=True)
def library(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The compiled flow, of this module's tests alone."""
    with own_library("flow", tmp_path_factory.mktemp("waves")) as found:
        yield found


def _states(liquid: Driven, motions: int = 1, step: float = 5e-4, count: int = 401) -> np.ndarray:
    """States (m, 2, J) from a random one on, driven by random waves of all masses in axes that lean and turn."""
    random = np.random.default_rng(3)
    body = np.tile(pushed_and_turned(3.0, 0.8, step, count - 1)[:, ::2], (1, motions))
    t, swing = step * np.arange(count * motions)[:, None], 1e-3 * random.normal(size=(2, liquid.gains.shape[1]))
    q, qd = np.sin(25 * t) * swing[0] + swing[1], 25 * np.cos(25 * t) * swing[0]
    begin = random.normal(size=(2, len(liquid.terms.stiffness))) * [[1e-3], [1e-2]]
    return second_order_states(liquid, body, q, qd, step, begin * np.any(liquid.axes, axis=1), motions=motions)


def _by_law(
    monkeypatch: pytest.MonkeyPatch, liquid: Driven, motions: int = 1, step: float = 5e-4, count: int = 401
) -> np.ndarray:
    with monkeypatch.context() as patch:
        patch.setenv("NOSPILL_COMPILE", "off")
        assert compiled_waves(liquid) is None
        return _states(liquid, motions, step, count)


def _assert_same(found: np.ndarray, expected: np.ndarray) -> None:
    for order in (0, 1):
        largest = np.max(np.abs(expected[:, order]))
        assert largest > 1e-4
        np.testing.assert_allclose(found[:, order], expected[:, order], atol=1e-13 * largest, rtol=0)


@pytest.mark.parametrize("cargo", _LIQUIDS)
@pytest.mark.parametrize("motions", [1, 3])
def test_states_are_those_by_law(cargo: Cargo, motions: int, monkeypatch: pytest.MonkeyPatch) -> None:
    liquid = driven(cargo)
    assert compiled_waves(liquid) is not None
    _assert_same(_states(liquid, motions), _by_law(monkeypatch, liquid, motions))


@pytest.mark.parametrize(("step", "count"), [(1e-4, 403), (5e-2, 40)], ids=["a last step of its own", "long steps"])
def test_steps_of_other_lengths(step: float, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    liquid = driven(cup())
    _assert_same(_states(liquid, 1, step, count), _by_law(monkeypatch, liquid, 1, step, count))


def test_modes_that_creep(monkeypatch: pytest.MonkeyPatch) -> None:
    """Damped beyond swinging, as no liquid of a scene is: then the step has hyperbolic functions."""
    liquid = driven(cup())
    terms = replace(liquid.terms, friction=3.0 * np.sqrt(STANDARD_GRAVITY / liquid.terms.stiffness))
    thick = replace(liquid, terms=terms, interactions=replace(liquid.interactions, terms=terms))
    _assert_same(_states(thick), _by_law(monkeypatch, thick))


def test_a_processor_without_fused_products_finds_the_same(
    library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = _states(driven(cup()))
    plain = "#define WITHOUT_FMA\n" + libraries.source("flow")
    monkeypatch.setattr(libraries, "source", lambda _: plain)
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path / "cache"))
    other = small_library("flow", wait=True)
    assert other is not None and other != library
    _assert_same(_states(driven(cup())), expected)
