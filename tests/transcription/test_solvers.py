"""Solves: linear solvers, limits, words, and what counts as a violation."""

from __future__ import annotations

import dataclasses
import hashlib
import math
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.constraints.base import RowId
from nospill.native import libraries
from nospill.scene.scene import Scene
from nospill.transcription.problem import Problem, build_problem
from nospill.transcription.solvers import FEASIBLE, Solution, SolveOptions, linear_solvers, solve
from nospill.transcription.solvers.options import (
    BARRIERS,
    LOOSE,
    LOOSEST,
    TIGHT,
    Tolerances,
    near_adapted,
    near_optimum,
)
from nospill.transcription.solvers.solution import violation
from nospill.transcription.stages import Stages
from nospill.transcription.starting_motions import smooth_start
from tests.builders import joint_path_of
from tests.hasty import COMPILER, hasty_compiler

INTERVALS = 20
PATIENT = SolveOptions(max_iterations=300, max_time=60.0)
BOTH = pytest.mark.parametrize("name", sorted(linear_solvers.LINEAR_SOLVERS))
needs_compiler = pytest.mark.skipif(shutil.which(COMPILER) is None, reason="no C compiler")


@dataclass(frozen=True)
class Task:
    """One solid on a level tray: 20 intervals, a tenth of a second to solve."""

    scene: Scene
    start: Stages

    def problem(self, linear_solver: str = "mumps") -> Problem:
        planning = dataclasses.replace(self.scene.planning, linear_solver=linear_solver)
        scene = dataclasses.replace(self.scene, planning=planning)
        return build_problem(scene, INTERVALS, nominal_duration=1.5, backoff={})

    def solve(self, linear_solver: str = "mumps", options: SolveOptions = PATIENT) -> Solution:
        return solve(self.problem(linear_solver), self.start, options=options)


@pytest.fixture(scope="module")
def task(changed_scene: Callable[..., Scene]) -> Task:
    scene = changed_scene("matrix-rigid", {"motion.tilt": "fixed"})
    scene = dataclasses.replace(scene, cargo=scene.cargo[:1])
    path = joint_path_of(scene)
    return Task(scene, smooth_start(scene, path, INTERVALS))


@pytest.mark.parametrize("tolerances", [TIGHT, LOOSE, LOOSEST])
def test_what_converges_is_gone_on_with_and_back_off_is_far_above_it(tolerances: Tolerances) -> None:
    assert tolerances.violation < FEASIBLE
    assert min(constraint.backoff for constraint in CONSTRAINTS) / 10 > FEASIBLE


@pytest.fixture
def compiling(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A cache folder of this test alone, and leave to compile, in haste."""
    monkeypatch.setenv("CC", str(hasty_compiler(tmp_path, solver="-O0") or COMPILER))
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.mark.slow
@BOTH
@needs_compiler
def test_an_optimum_is_reached_and_reported_in_a_sentence(task: Task, name: str) -> None:
    solution = task.solve(name)
    assert solution.converged and solution.linear_solver == name
    assert solution.status == "ipopt converged to an optimum"
    assert solution.violation < 1e-6
    assert 0 < solution.iterations < 100 and solution.solve_time_s > 0
    assert solution.stages.intervals == INTERVALS
    assert solution.objective >= solution.stages.duration
    assert len(solution.variables) == task.problem().transcription.variables


@needs_compiler
def test_with_heavier_jerks_multipliers_and_an_adapted_barrier_lead_there_in_fewer_iterations(task: Task) -> None:
    """To the same motion: the weights change the multipliers less than a barrier that goes down from its first one."""
    before, problem = task.solve("ldl"), task.problem("ldl")
    heavier = build_problem(
        problem.scene, INTERVALS, nominal_duration=1.5, jerk_weight_factor=3.0, backoff=problem.backoff
    )
    adapted, down = (
        solve(heavier, before.stages, options=dataclasses.replace(PATIENT, tolerances=LOOSE, **own), warm=warm)
        for own, warm in ((near_adapted(60), before), (near_optimum(BARRIERS[0]), None))
    )
    assert adapted.converged and down.converged
    assert adapted.objective == pytest.approx(down.objective, rel=2e-4)
    assert adapted.objective > before.objective + 1e-4
    assert adapted.iterations < down.iterations


@needs_compiler
def test_both_linear_solvers_agree(task: Task) -> None:
    one, other = (task.solve(name) for name in sorted(linear_solvers.LINEAR_SOLVERS))
    assert other.stages.duration == pytest.approx(one.stages.duration, abs=1e-6)
    assert other.objective == pytest.approx(one.objective, abs=1e-6)
    assert other.iterations == pytest.approx(one.iterations, abs=3)


def test_an_unknown_linear_solver_is_named_with_the_known_ones(task: Task) -> None:
    known = r'^planning\.linear_solver "ma57" is not known; allowed: auto, ldl, mumps$'
    with pytest.raises(ScenarioError, match=known):
        task.solve("ma57")


# --- where there is no ldl ------------------------------------------------------------------------------------------


def test_nothing_is_compiled_where_that_is_off(task: Task, compiling: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NOSPILL_COMPILE", "off")
    assert task.solve("auto").linear_solver == "mumps"
    assert not compiling.exists()
    with pytest.raises(ScenarioError, match=r'^planning\.linear_solver "ldl" cannot be had here: .*; use "auto" or '):
        task.solve("ldl")


def test_without_a_compiler_mumps_serves(task: Task, compiling: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    solution = task.solve("auto")
    assert solution.converged and solution.linear_solver == "mumps"


@needs_compiler
def test_a_damaged_library_is_made_anew(compiling: Path) -> None:
    library = linear_solvers.ldl_library()
    assert library is not None and library.parent == compiling
    whole = library.read_bytes()
    library.unlink()  # the open file must not change under the process that has loaded it
    library.write_bytes(whole[: len(whole) // 2])
    assert linear_solvers.ldl_library() == library
    assert library.with_suffix(".sum").read_text() == hashlib.sha256(library.read_bytes()).hexdigest()
    assert len(library.read_bytes()) == len(whole)


@needs_compiler
def test_a_library_that_does_not_load_is_not_handed_to_ipopt(
    task: Task, compiling: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(libraries, "source", lambda _: "void nowhere(void);\nvoid ma27id_(void) { nowhere(); }\n")
    assert linear_solvers.ldl_library() is None
    assert task.solve("auto").linear_solver == "mumps"


@needs_compiler
def test_a_solve_whose_systems_fail_is_made_again_and_says_so(
    task: Task, compiling: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A factorisation that reports a fault at its third call."""
    text = libraries.source("ldl")
    fault = "static int calls;\nif (++calls > 2) { info[0] = NO_MEMORY; return; }\n"
    marked = "    *maxfrt = 2 * *n;\n"
    assert text.count(marked) == 1
    failing = text.replace(marked, marked + fault)
    monkeypatch.setattr(libraries, "source", lambda _: failing)
    alone, together = task.solve("ldl"), task.solve("auto")
    assert not alone.converged and alone.linear_solver == "ldl"
    assert together.converged and together.linear_solver == "mumps after ldl"
    assert together.pivot_order is None
    assert together.stages.duration == task.solve("mumps").stages.duration


# --- limits and progress --------------------------------------------------------------------------------------------


def test_the_limit_of_iterations_is_reported(task: Task) -> None:
    solution = task.solve(options=SolveOptions(max_iterations=2, max_time=60.0))
    assert not solution.converged
    assert solution.status.startswith("ipopt stopped at the limit of iterations")
    assert solution.violation > 1e-6


def test_the_time_limit_is_reported(task: Task) -> None:
    solution = task.solve(options=SolveOptions(max_iterations=300, max_time=1e-6))
    assert not solution.converged
    assert solution.status.startswith("ipopt stopped at the time limit")
    assert "planning.max_solve_time" in solution.status


def test_progress_counts_iterations_up_to_the_answer(task: Task) -> None:
    calls: list[tuple[int, float, float]] = []
    options = dataclasses.replace(PATIENT, progress=lambda *call: calls.append(call))
    solution = task.solve(options=options)
    assert [number for number, _, _ in calls] == list(range(solution.iterations + 1))
    assert calls[0][1] == pytest.approx(task.start.duration, rel=0.05)
    assert calls[-1][1] == pytest.approx(solution.stages.duration, rel=1e-4)
    assert calls[-1][2] < 1e-5 < max(call[2] for call in calls)
    # Looking on changes nothing.
    assert task.solve().stages.duration == solution.stages.duration


def test_from_its_own_answer_a_few_steps_are_enough(task: Task) -> None:
    first = task.solve()
    again = solve(
        task.problem(),
        first.stages,
        options=dataclasses.replace(PATIENT, barrier_start=1e-6, bound_push=1e-6),
        warm=first,
    )
    assert again.converged and again.iterations < first.iterations / 2
    assert again.stages.duration == pytest.approx(first.stages.duration, rel=1e-4)


@needs_compiler
def test_the_order_of_pivots_goes_on_to_the_next_solve(task: Task) -> None:
    assert linear_solvers.ldl_library() is not None
    first, options = task.solve("ldl"), dataclasses.replace(PATIENT, barrier_start=1e-6, bound_push=1e-6)
    assert first.pivot_order is not None
    kept = solve(task.problem("ldl"), first.stages, options=options, warm=first)
    fresh = solve(task.problem("ldl"), first.stages, options=options, warm=dataclasses.replace(first, pivot_order=None))
    assert kept.pivot_order is first.pivot_order
    assert fresh.pivot_order is not None and fresh.pivot_order is not first.pivot_order
    assert kept.iterations == fresh.iterations
    np.testing.assert_allclose(kept.variables, fresh.variables, rtol=1e-6, atol=1e-9)
    by_mumps = solve(task.problem("mumps"), first.stages, options=options, warm=first)
    assert by_mumps.pivot_order is None


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
    solution = task.solve()
    wanted = {RowId(item.name, subject) for item in CONSTRAINTS for subject in item.subjects(task.scene)}
    assert set(solution.slack) == wanted
    assert min(solution.slack.values()) > -1e-6
    # A time-optimal motion meets some limit, and not all of them.
    assert min(solution.slack.values()) < 1e-3 and max(solution.slack.values()) > 0.3
