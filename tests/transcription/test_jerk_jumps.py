"""Jumps of the jerk in the cost where joints ring, against sums and differences."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from nospill.scenario import read_scenario
from nospill.transcription.problem import Problem, build_problem
from nospill.transcription.weights import jerk_weights

INTERVALS, FACTOR = 5, 7.0


def _problem(factor: float, *settings: str) -> Problem:
    scene = read_scenario("matrix-rigid", settings=settings)
    return build_problem(scene, INTERVALS, nominal_duration=1.5, jerk_weight_factor=factor, backoff={})


@pytest.fixture(scope="module")
def rings() -> Problem:
    return _problem(FACTOR, "tolerance.tracking.resonance=20 Hz", "motion.tilt=free")


def _cost(problem: Problem, variables: np.ndarray) -> float:
    nlp = problem.transcription.nlp
    return float(ca.Function("cost", [nlp["x"], nlp["p"]], [nlp["f"]])(variables, problem.parameters))


def test_where_joints_ring_their_factor_is_on_jumps(rings: Problem) -> None:
    """A chain's jump counts as its jerk over the time 1 / w; the jerks keep the weights they have."""
    layout = rings.transcription.layout
    usual = jerk_weights(rings.scene, 1.5, FACTOR)
    assert usual == jerk_weights(rings.scene, 1.5) and rings.own.path_jerk_weight == usual["path_jerk_weight"]
    jerks = np.zeros((INTERVALS, layout.chains))
    jerks[:, 0] = 2.0, 2.0, -1.0, 0.0, 3.0
    variables = np.zeros(rings.transcription.variables)
    places = np.arange(INTERVALS)[:, None] * layout.size + np.arange(layout.jerks.start, layout.jerks.stop)
    variables[places] = jerks / rings.scales[layout.jerks]
    jumps = 2.0**2 + 3.0**2 + 1.0 + 3.0**2 + 3.0**2
    share = 6.0 * (INTERVALS / 1.5 / (2.0 * np.pi * 20.0)) ** 2
    expected = usual["path_jerk_weight"] / INTERVALS * (np.sum(jerks**2) + share * jumps)
    assert _cost(rings, variables) == pytest.approx(expected)


def test_their_derivatives_are_those_of_the_cost(rings: Problem) -> None:
    transcription, rng = rings.transcription, np.random.default_rng(1)
    at, way = rng.normal(size=(2, transcription.variables))
    step = 1e-6

    def gradient(variables: np.ndarray) -> np.ndarray:
        return np.array(transcription.derivatives.grad_f(variables, rings.parameters)[1]).ravel()

    slope = (_cost(rings, at + step * way) - _cost(rings, at - step * way)) / (2.0 * step)
    assert gradient(at) @ way == pytest.approx(slope, rel=1e-5)
    none = np.zeros(len(transcription.lower))
    upper = np.array(transcription.derivatives.hess_lag(at, rings.parameters, 1.0, none))
    bend = (gradient(at + step * way) - gradient(at - step * way)) / (2.0 * step)
    assert np.allclose((upper + np.triu(upper, 1).T) @ way, bend, atol=1e-6 * np.max(np.abs(bend)))


def test_without_them_no_problem_has_jumps() -> None:
    problem = _problem(FACTOR)
    assert len(problem.jump_weights) == 0
    assert problem.own.path_jerk_weight == pytest.approx(FACTOR * _problem(1.0).own.path_jerk_weight)
