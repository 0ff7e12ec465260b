"""Limits of the tray's speed and acceleration as rows of a stage; without them nothing is there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from nospill.laws.constraints import TrayAcceleration, TraySpeed
from nospill.laws.kinds import motion_kind, object_kind
from nospill.laws.scene_parameters import structure_of
from nospill.scenario import read_scenario
from nospill.scene.scene import Scene
from nospill.transcription.problem import Problem, build_problem

LIMITS = {"motion.max_speed": "0.5 m/s", "motion.max_acceleration": "3 m/s^2"}
INTERVALS = 3
NAMES = {TraySpeed.name, TrayAcceleration.name}


@pytest.fixture(scope="module")
def limited(changed_scene: Callable[..., Scene]) -> Problem:
    """One solid on a tray that tilts."""
    scene = changed_scene("matrix-rigid", LIMITS)
    return build_problem(replace(scene, cargo=scene.cargo[:1]), INTERVALS, nominal_duration=1.8, backoff={})


def rows_of(found: Problem) -> dict[str, int]:
    """Place among the rows of a stage, by constraint."""
    blocks = found.transcription.blocks
    assert all(block.count == 1 for block in blocks if block.constraint in NAMES)
    return {block.constraint: block.first for block in blocks if block.constraint in NAMES}


def random_point(found: Problem) -> np.ndarray:
    random, layout = np.random.default_rng(1), found.transcription.layout
    table = random.uniform(-1, 1, (INTERVALS + 1, layout.size))
    table[:, 0] = random.uniform(0.05, 0.95, INTERVALS + 1)
    table[:, layout.interval] = 1.0
    return table.ravel()[: found.transcription.variables]


def test_without_limits_no_row_and_the_kinds_of_other_scenes(changed_scene: Callable[..., Scene]) -> None:
    bare, scene = read_scenario("matrix-rigid"), changed_scene("matrix-rigid", LIMITS)
    for constraint in (TraySpeed(), TrayAcceleration()):
        assert constraint.subjects(bare) == () and constraint.subjects(scene) == ("tray",)
    plain, other = structure_of(bare), structure_of(scene)
    assert plain.motion_limits == () and other.motion_limits == ("max_speed", "max_acceleration")
    assert replace(other, motion_limits=()) == plain
    assert motion_kind(plain) == motion_kind(other)
    assert object_kind(plain, plain.objects[0]) == object_kind(other, other.objects[0])
    problem = build_problem(replace(bare, cargo=bare.cargo[:1]), INTERVALS, nominal_duration=1.8, backoff={})
    assert not rows_of(problem) and not NAMES & {row.constraint for row in problem.rows.values()}


def test_rows_are_those_of_the_control_point_of_the_speed_and_of_the_acceleration(limited: Problem) -> None:
    """One less the square of the use, of v + a h/2 and of a, by the derivatives of the path."""
    point, transcription = random_point(limited), limited.transcription
    values = transcription.constraint_function(point, limited.parameters).full().ravel()
    places, path = rows_of(limited), limited.scene.path
    for stage in range(INTERVALS):
        table = point[stage * transcription.layout.size :][: transcription.layout.size] * limited.scales
        s, rate, change = table[:3]
        first, second = (path.derivative(np.array([s]), order)[0, :3] for order in (1, 2))
        acceleration = second * rate**2 + first * change
        control = first * rate + acceleration * table[transcription.layout.interval] / 2
        for name, vector, limit in ((TraySpeed.name, control, 0.5), (TrayAcceleration.name, acceleration, 3.0)):
            found = values[stage * transcription.rows_per_stage + places[name]]
            assert found == pytest.approx(1.0 - (np.linalg.norm(vector) / limit) ** 2, rel=1e-9)


def test_derivatives_against_finite_differences(limited: Problem) -> None:
    transcription, p = limited.transcription, limited.parameters
    point, random = random_point(limited), np.random.default_rng(2)
    direction, multipliers = random.normal(size=len(point)), np.zeros(len(transcription.lower))
    for stage in range(INTERVALS):
        for place in rows_of(limited).values():
            multipliers[stage * transcription.rows_per_stage + place] = random.normal()

    def slopes(at: np.ndarray) -> np.ndarray:
        return transcription.derivatives.jac_g(at, p)[1].full().T @ multipliers

    step = 1e-6
    ahead, behind = (transcription.constraint_function(point + sign * step * direction, p).full() for sign in (1, -1))
    change = multipliers @ (ahead - behind).ravel() / (2 * step)
    assert slopes(point) @ direction == pytest.approx(change, rel=1e-6)
    half = transcription.derivatives.hess_lag(point, p, 0.0, multipliers).full()
    bend = (slopes(point + step * direction) - slopes(point - step * direction)) / (2 * step)
    hessian = half + half.T - np.diag(np.diag(half))
    np.testing.assert_allclose(hessian @ direction, bend, atol=1e-6 * np.abs(bend).max())
    assert np.isfinite(ca.DM(half).full()).all()
