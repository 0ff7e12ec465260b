"""The solvers: names, limits, words, and what counts as a violation."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.constraints.base import RowId
from nospill.scene.scene import Scene
from nospill.transcription.problem import Problem, build_problem
from nospill.transcription.solvers import SOLVERS, Solution, SolveOptions, solve
from nospill.transcription.solvers.solution import violation
from nospill.transcription.stages import Stages
from nospill.transcription.starting_motions import smooth_start
from tests.builders import joint_path_of

INTERVALS = 20
PATIENT = SolveOptions(max_iterations=300, max_time=60.0)
BOTH = pytest.mark.parametrize("solver", sorted(SOLVERS))


@dataclass(frozen=True)
class Task:
    """One solid on a level tray: 20 intervals, a tenth of a second to solve."""

    scene: Scene
    start: Stages

    def problem(self, solver: str = "ipopt") -> Problem:
        planning = dataclasses.replace(self.scene.planning, solver=solver)
        scene = dataclasses.replace(self.scene, planning=planning)
        return build_problem(scene, INTERVALS, nominal_duration=1.5, backoff={})

    def solve(self, solver: str, options: SolveOptions = PATIENT, warm: Solution | None = None) -> Solution:
        return solve(self.problem(solver), self.start, solver=solver, options=options, warm=warm)


@pytest.fixture(scope="module")
def task(changed_scene: Callable[..., Scene]) -> Task:
    scene = changed_scene("matrix-rigid", {"motion.tilt": "fixed"})
    scene = dataclasses.replace(scene, cargo=scene.cargo[:1])
    path = joint_path_of(scene)
    return Task(scene, smooth_start(scene, path, INTERVALS))


@BOTH
def test_an_optimum_is_reached_and_reported_in_a_sentence(task: Task, solver: str) -> None:
    solution = task.solve(solver)
    assert solution.converged
    assert solution.status == f"{solver} converged to an optimum"
    assert solution.violation < 1e-6
    assert 0 < solution.iterations < 100 and solution.solve_time_s > 0
    assert solution.stages.intervals == INTERVALS
    assert solution.objective >= solution.stages.duration
    assert len(solution.variables) == task.problem().transcription.variables


def test_both_solvers_agree(task: Task) -> None:
    one, other = (task.solve(solver) for solver in sorted(SOLVERS))
    assert other.stages.duration == pytest.approx(one.stages.duration, rel=1e-4)
    assert other.objective == pytest.approx(one.objective, rel=1e-4)


def test_an_unknown_solver_is_named_with_the_known_ones(task: Task) -> None:
    with pytest.raises(ScenarioError, match=r'^planning\.solver "snopt" is not known; allowed: ipopt, fatrop$'):
        solve(task.problem(), task.start, solver="snopt", options=PATIENT)


@pytest.mark.parametrize("solver", ["ipopt", "fatrop"])
def test_the_limit_of_iterations_is_reported(task: Task, solver: str) -> None:
    solution = task.solve(solver, SolveOptions(max_iterations=2, max_time=60.0))
    assert not solution.converged
    assert solution.status.startswith(f"{solver} stopped at the limit of iterations")
    assert solution.violation > 1e-6


def test_the_time_limit_is_reported(task: Task) -> None:
    solution = task.solve("ipopt", SolveOptions(max_iterations=300, max_time=1e-6))
    assert not solution.converged
    assert solution.status.startswith("ipopt stopped at the time limit")
    assert "planning.max_solve_time" in solution.status


def test_progress_counts_iterations_up_to_the_answer(task: Task) -> None:
    calls: list[tuple[int, float, float]] = []
    options = dataclasses.replace(PATIENT, progress=lambda *call: calls.append(call))
    solution = task.solve("ipopt", options)
    assert [number for number, _, _ in calls] == list(range(solution.iterations + 1))
    assert calls[0][1] == pytest.approx(task.start.duration, rel=0.05)
    assert calls[-1][1] == pytest.approx(solution.stages.duration, rel=1e-4)
    assert calls[-1][2] < 1e-5 < max(call[2] for call in calls)
    # Looking on changes nothing.
    assert task.solve("ipopt").stages.duration == solution.stages.duration


def test_from_its_own_answer_a_few_steps_are_enough(task: Task) -> None:
    first = task.solve("ipopt")
    again = solve(
        task.problem(),
        first.stages,
        solver="ipopt",
        options=dataclasses.replace(PATIENT, barrier_start=1e-6, bound_push=1e-6),
        warm=first,
    )
    assert again.converged and again.iterations < first.iterations / 2
    assert again.stages.duration == pytest.approx(first.stages.duration, rel=1e-4)


def test_encode_and_decode_are_inverse(task: Task) -> None:
    problem = task.problem()
    layout = problem.transcription.layout
    back = problem.decode(problem.encode(task.start))
    np.testing.assert_allclose(back.table[:-1], task.start.table[:-1], rtol=1e-14)
    np.testing.assert_allclose(back.table[-1, : layout.states], task.start.table[-1, : layout.states], rtol=1e-14)


# --- violation ------------------------------------------------------------------------------------------------------


def test_violation_is_the_largest_distance_outside(task: Task) -> None:
    problem = task.problem()
    lower, upper = problem.transcription.lower, problem.transcription.upper
    inside = np.clip(np.zeros(len(lower)), lower, upper)
    assert violation(problem, inside) == 0.0
    low, high = int(np.flatnonzero(np.isfinite(lower))[0]), int(np.flatnonzero(np.isfinite(upper))[-1])
    outside = inside.copy()
    outside[low] = lower[low] - 0.25
    assert violation(problem, outside) == 0.25
    outside[high] = upper[high] + 0.5
    assert violation(problem, outside) == 0.5


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_value_that_is_no_number_is_the_largest_violation(task: Task, value: float) -> None:
    problem = task.problem()
    for place in (0, len(problem.transcription.lower) - 1):
        values = np.clip(np.zeros(len(problem.transcription.lower)), problem.transcription.lower, math.inf)
        values[place] = value
        with np.errstate(invalid="ignore"):
            assert violation(problem, values) == math.inf


def test_slack_is_kept_for_every_subject_and_never_far_below_zero(task: Task) -> None:
    solution = task.solve("ipopt")
    wanted = {RowId(item.name, subject) for item in CONSTRAINTS for subject in item.subjects(task.scene)}
    assert set(solution.slack) == wanted
    assert min(solution.slack.values()) > -1e-6
    # A time-optimal motion meets some limit, and not all of them.
    assert min(solution.slack.values()) < 1e-3 and max(solution.slack.values()) > 0.3
