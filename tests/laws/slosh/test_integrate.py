"""Runge-Kutta steps of several liquids at once: a swing in closed form, and each what it does alone."""

from __future__ import annotations

import shutil
from typing import Any

import casadi as ca
import numpy as np
import pytest

from nospill.compiled import codegen
from nospill.laws.slosh.integrate import SHARED, STEPS, integrate, runge_kutta_step, step_sequence
from tests.hasty import COMPILER

SX = ca.SX
STEP = 1e-3


def step() -> Any:
    """Of a driven swing, x'' = -p x + b."""

    def rate(state: SX, body: SX, parameters: SX) -> SX:
        return ca.vertcat(state[1], body - parameters * state[0])

    return runge_kutta_step(rate, states=2, inputs=1, parameters=1)


def driven(steps: Any, stiffness: list[float], count: int, force: float = 0.0) -> np.ndarray:
    """States (count + 1, liquids, 2) of swings let go at 1."""
    return integrate(
        steps,
        np.tile([1.0, 0.0], (len(stiffness), 1)),
        inputs=np.full((1, 2 * count + 1), force),
        lengths=np.full(count, STEP),
        parameters=np.array(stiffness)[:, None],
    )


@pytest.mark.parametrize("count", [1, STEPS - 1, STEPS, STEPS + 1, 2 * STEPS + 7])
@pytest.mark.parametrize("force", [0.0, 3.0])
def test_swings_in_closed_form(count: int, force: float) -> None:
    stiffness = [9.0, 100.0, 400.0]
    states, t = driven(step_sequence(step()), stiffness, count, force), STEP * np.arange(count + 1)
    assert states.shape == (count + 1, 3, 2)
    for index, own in enumerate(stiffness):
        omega, rest = own**0.5, force / own
        np.testing.assert_allclose(states[:, index, 0], rest + (1 - rest) * np.cos(omega * t), atol=1e-7)
        np.testing.assert_allclose(states[:, index, 1], -(1 - rest) * omega * np.sin(omega * t), atol=1e-6)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which(COMPILER) is None, reason="no C compiler")
@pytest.mark.parametrize("liquids", [1, 3, 4, 5, 9])
def test_machine_code_of_several_gives_each_what_it_does_alone(liquids: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", COMPILER)
    several = codegen.functions(
        "test", f"swing {STEPS}", lambda: ({"step": step()}, None), of_columns={"step": SHARED}, steps=STEPS
    )[0]["step"]
    assert several.size2_in(0) == 4
    stiffness = np.linspace(9.0, 400.0, liquids).tolist()
    found = driven(several, stiffness, STEPS + 20, force=1.0)
    for index, own in enumerate(stiffness):
        alone = driven(step_sequence(step()), [own], STEPS + 20, force=1.0)
        np.testing.assert_array_equal(found[:, index], alone[:, 0])
