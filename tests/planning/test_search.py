"""What a search does beside solving: rows that join together, and tasks that are hopeless."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from nospill.errors import NoSolutionError
from nospill.laws.constraints.base import RowId
from nospill.planning import candidate, search
from nospill.planning.active_set import ActiveSet
from nospill.planning.attempts import attempts
from nospill.planning.candidate import Candidate, problem_about
from nospill.planning.log import Log
from nospill.planning.search import PassageSearch
from nospill.planning.task import Task
from nospill.scenario import read_scenario
from nospill.transcription.solvers import Solution
from nospill.transcription.solvers.options import Options
from nospill.transcription.stages import Stages
from nospill.transcription.starting_motions import coarse_start
from tests.builders import joint_path_of


def answer(active: ActiveSet, motion: Any, *_: Any) -> Candidate:
    """A motion as if it had been solved for."""
    none = np.zeros(0)
    solution = Solution(motion, none, none, none, 1.0, 0.0, {}, True, "", 1, 0.0, "none")
    return Candidate(active, solution, problem_about(active, motion))


def test_with_a_broken_row_those_near_their_limit_join(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = read_scenario("matrix-liquid-tilt")
    joint_path = joint_path_of(scene)
    active = ActiveSet.of(Task.of(scene), joint_path.q).with_rows(())
    broken, near, far = (RowId("slip", name) for name in ("c1", "c2", "c3"))
    assert {broken, near, far} <= active.possible - active.rows
    solved: list[ActiveSet] = []

    def recorded(given: ActiveSet, motion: Any, *_: Any) -> Candidate:
        solved.append(given)
        return answer(given, motion)

    monkeypatch.setattr(candidate, "solved", recorded)
    monkeypatch.setattr(
        candidate, "slack_of", lambda *_: {broken: -0.1 if len(solved) == 1 else 0.1, near: 0.2, far: 0.5}
    )
    found = candidate.solve_lazily(active, coarse_start(active.scene, joint_path), Log(None, 60.0), {})
    assert len(solved) == 2
    assert found.active.rows - active.rows == {broken, near}


def test_near_rows_alone_ask_for_no_further_solve(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = read_scenario("matrix-liquid-tilt")
    joint_path = joint_path_of(scene)
    active = ActiveSet.of(Task.of(scene), joint_path.q).with_rows(())
    monkeypatch.setattr(candidate, "solved", answer)
    monkeypatch.setattr(candidate, "slack_of", lambda *_: {RowId("slip", "c1"): 0.01})
    found = candidate.solve_lazily(active, coarse_start(active.scene, joint_path), Log(None, 60.0), {})
    assert found.active.rows == active.rows


@pytest.mark.parametrize(("hopeless", "tried"), [(False, 3), (True, 1)])
def test_whether_a_task_is_hopeless_is_looked_at_once(
    monkeypatch: pytest.MonkeyPatch, hopeless: bool, tried: int
) -> None:
    task, looks = Task.of(read_scenario("matrix-rigid")), []

    def looked(*given: Any) -> bool:
        looks.append(given)
        return hopeless

    monkeypatch.setattr(search.diagnosis, "is_hopeless", looked)
    monkeypatch.setattr(search, "solve_lazily", answer)
    monkeypatch.setattr(search, "usable", lambda _: False)
    log = Log(None, 60.0)
    best, last = search.best_of(task, joint_path_of(task.scene), log, attempts(task)[:3])
    assert best is None and last is not None
    assert log.starts == [None] * tried
    assert len(looks) == 1


@pytest.mark.parametrize("compared", [1, 2])
def test_a_search_goes_on_where_it_was_left(monkeypatch: pytest.MonkeyPatch, compared: int) -> None:
    """Every attempt is made once, whatever else was tried in the same call."""
    scene = read_scenario("matrix-rigid")
    task = Task.of(replace(scene, planning=replace(scene.planning, starts=compared)))
    tries, made = attempts(task), list[Options]()

    def noted(active: ActiveSet, start: Stages, log: Log, options: Options) -> Candidate:
        made.append(options)
        return answer(active, start)

    monkeypatch.setattr(search, "solve_lazily", noted)
    monkeypatch.setattr(search, "usable", lambda _: len(made) >= 2)  # the first attempt leads nowhere
    monkeypatch.setattr(search.diagnosis, "is_hopeless", lambda *_: False)
    found, log = PassageSearch(task, joint_path_of(task.scene), iter(tries)), Log(None, 60.0, starts=[None, 1.5])
    found.first(log)
    assert len(made) == 2
    assert log.starts[:3] == [None, None, None]  # what was found on another passage does not compare
    while len(made) < len(tries):
        found.further(log)
    assert all(ours is own.options for ours, own in zip(made, tries, strict=True))
    with pytest.raises(NoSolutionError, match="No other motion"):
        found.further(log)
