"""The order of the starts of a search, and how each is tried."""

from __future__ import annotations

from dataclasses import replace

import pytest

from nospill.planning.attempts import attempts, first_attempts
from nospill.planning.task import Task
from nospill.plans.records import Starts
from nospill.scenario import read_scenario
from nospill.transcription.starting_motions import USUAL_START


@pytest.mark.parametrize(("compared", "first"), [(1, 3), (3, 3), (6, 6)])
def test_the_last_starts_are_for_when_nothing_is_found(compared: int, first: int) -> None:
    scene = read_scenario("matrix-rigid")
    scene = replace(scene, planning=replace(scene.planning, starts=compared))
    found = attempts(Task.of(scene))
    starts = [attempt.start for attempt in found]
    assert starts[0] == USUAL_START
    assert len(set(starts[: first + 1])) == first + 1
    assert found[first].options["max_iterations"] > found[0].options["max_iterations"]
    assert [attempt.all_rows for attempt in found] == [False] * (first + 1) + [True] * (len(found) - first - 1)
    # the usual two again, then what has not been tried
    assert starts[first + 1 : first + 3] == [starts[1], starts[0]]
    assert not set(starts[first + 3 :]) & set(starts[: first + 1])
    assert first_attempts(Task.of(scene)) == first


def test_both_barrier_strategies_take_turns() -> None:
    """Around obstacles the adaptive one comes first; that bodies keep apart from each other alone changes no order."""
    turns = {"matrix-rigid": [True, False, True], "cups-around-a-column": [False, True, False]}
    for name, expected in turns.items():
        task = Task.of(read_scenario(name))
        assert task.keeps_apart and task.leads_past != expected[0]
        assert ["barrier_start" in attempt.options for attempt in attempts(task)[:3]] == expected


def test_answers_near_the_best_are_counted() -> None:
    cases = ([1.4], [1.4, 1.4069], [1.4, 1.408], [1.5, 1.4, 1.404])
    assert [Starts.of([None, *durations]).agreed for durations in cases] == [1, 2, 1, 2]
