"""Multipliers of an answer in a problem with other objects: what is known of the ones that are in both."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from nospill.scene.scene import Scene
from nospill.transcription.problem import Problem, build_problem
from nospill.transcription.solvers import Solution, SolveOptions, carried_over, solve
from nospill.transcription.starting_motions import smooth_start
from tests.builders import joint_path_of

INTERVALS = 20
PATIENT = SolveOptions(max_iterations=300, max_time=60.0)


@dataclass(frozen=True)
class Tray:
    """Two cups of which a problem has some; the flange carries both."""

    scene: Scene

    def problem(self, *names: str, rows_of: tuple[str, ...] | None = None, intervals: int = INTERVALS) -> Problem:
        """With the cups in this order; rows on objects of `rows_of` alone take part."""
        cargo = {item.name: item for item in self.scene.cargo}
        scene = replace(self.scene, cargo=tuple(cargo[name] for name in names))
        problem = build_problem(scene, intervals, nominal_duration=2.0, backoff={}, payload=self.scene.cargo)
        if rows_of is None:
            return problem
        active = {row for row in problem.rows.values() if row.subject not in cargo or row.subject in rows_of}
        return build_problem(
            scene, intervals, nominal_duration=2.0, backoff={}, payload=self.scene.cargo, active=active
        )

    def solved(self, problem: Problem) -> Solution:
        start = smooth_start(problem.scene, joint_path_of(problem.scene), problem.transcription.intervals)
        return solve(problem, start, options=PATIENT)


@pytest.fixture(scope="module")
def tray(changed_scene: Callable[..., Scene]) -> Tray:
    return Tray(changed_scene("pp-two-cups", {}).with_one_mode())


@pytest.fixture(scope="module")
def alone(tray: Tray) -> tuple[Problem, Solution]:
    problem = tray.problem(tray.scene.cargo[0].name)
    solution = tray.solved(problem)
    assert solution.converged
    return problem, solution


def columns(problem: Problem, name: str) -> np.ndarray:
    """Of a stage, the variables of one cup; the rest are the tray's."""
    layout = problem.transcription.layout
    index = [item.name for item in problem.scene.cargo].index(name)
    own = problem.structure.slosh_slices[index]
    parts = layout.displacement, layout.velocity, layout.acceleration(0), layout.acceleration(1)
    return np.concatenate([np.arange(part.start, part.stop)[own] for part in parts])


def of_tray(problem: Problem) -> np.ndarray:
    liquid = [columns(problem, item.name) for item in problem.scene.cargo]
    return np.setdiff1d(np.arange(problem.transcription.layout.size), np.concatenate(liquid))


def gradient_of_lagrangian(problem: Problem, variables: np.ndarray, found: Solution) -> np.ndarray:
    derivatives = problem.transcription.derivatives
    _, gradient = (np.array(part) for part in derivatives.grad_f(variables, problem.parameters))
    jacobian = derivatives.jac_g(variables, problem.parameters)[1].sparse()
    return gradient.ravel() + jacobian.T @ found.multipliers + found.bound_multipliers


def test_the_same_problem_gets_what_it_had(alone: tuple[Problem, Solution]) -> None:
    problem, solution = alone
    again = carried_over(solution, problem, problem)
    assert again is not None and again.pivot_order is None
    np.testing.assert_array_equal(again.multipliers, solution.multipliers)
    np.testing.assert_array_equal(again.bound_multipliers, solution.bound_multipliers)


def test_an_answer_is_one_of_a_problem_with_another_cup_that_asks_for_nothing(
    tray: Tray, alone: tuple[Problem, Solution]
) -> None:
    """The Lagrangian is stationary in all variables, those of the cup before the known one among them."""
    first, second = (item.name for item in tray.scene.cargo)
    before, solution = alone
    problem = tray.problem(second, first, rows_of=(first,))
    found = carried_over(solution, before, problem)
    assert found is not None and np.count_nonzero(found.multipliers) == np.count_nonzero(solution.multipliers)

    sizes = [item.transcription.layout.size for item in (before, problem)]
    known, table = np.zeros((INTERVALS + 1) * sizes[0]), np.zeros((INTERVALS + 1, sizes[1]))
    known[: before.transcription.motion_variables] = solution.variables
    for one, other in ((of_tray(before), of_tray(problem)), (columns(before, first), columns(problem, first))):
        table[:, other] = known.reshape(-1, sizes[0])[:, one]
    variables = table.ravel()[: problem.transcription.motion_variables]
    assert np.abs(gradient_of_lagrangian(problem, variables, found)).max() < 1e-5
    wrong = replace(found, multipliers=np.roll(found.multipliers, 1))
    assert np.abs(gradient_of_lagrangian(problem, variables, wrong)).max() > 1e-3


def test_there_and_back_nothing_of_the_known_cup_is_lost(tray: Tray, alone: tuple[Problem, Solution]) -> None:
    before, solution = alone
    problem = tray.problem(*(item.name for item in reversed(tray.scene.cargo)))
    there = carried_over(solution, before, problem)
    assert there is not None
    back = carried_over(there, problem, before)
    assert back is not None
    np.testing.assert_array_equal(back.multipliers, solution.multipliers)
    np.testing.assert_array_equal(back.bound_multipliers, solution.bound_multipliers)


def test_another_grid_or_tray_has_no_use_for_them(
    tray: Tray, alone: tuple[Problem, Solution], changed_scene: Callable[..., Scene]
) -> None:
    before, solution = alone
    name = tray.scene.cargo[0].name
    assert carried_over(solution, before, tray.problem(name, intervals=INTERVALS + 1)) is None
    tilting = Tray(changed_scene("pp-two-cups", {"motion.tilt": "free"}).with_one_mode())
    assert carried_over(solution, before, tilting.problem(name)) is None
