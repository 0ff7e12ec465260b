"""The order in which starting motions are tried, and when that ends."""

from __future__ import annotations

from dataclasses import replace

import pytest

from nospill.planning.starts import agreed, alike, attempts
from nospill.scenario import read_scenario
from nospill.transcription.starting_motions import USUAL_START


@pytest.mark.parametrize("count", [1, 3, 6])
def test_starts_beyond_those_asked_for_are_for_when_nothing_is_found(count: int) -> None:
    scene = read_scenario("matrix-rigid")
    scene = replace(scene, planning=replace(scene.planning, starts=count))
    found = attempts(scene, briefly=False)
    starts = [attempt.start for attempt in found]
    assert starts[0] == USUAL_START
    assert len(set(starts[: count + 1])) == count + 1
    assert found[count].iterations > found[0].iterations
    assert [attempt.all_rows for attempt in found] == [False] * (count + 1) + [True] * (len(found) - count - 1)
    # the usual two again, then what has not been tried
    assert starts[count + 1 : count + 3] == [starts[1], starts[0]]
    assert not set(starts[count + 3 :]) & set(starts[: count + 1])
    assert attempts(scene, briefly=True) == found[:count]


def test_both_ways_of_accepting_steps_take_turns() -> None:
    asked = attempts(read_scenario("matrix-rigid"), briefly=True)
    assert [attempt.by_error for attempt in asked] == [False, True, False]


def test_two_answers_that_are_the_same_are_enough_but_for_still_liquids() -> None:
    rigid, still = read_scenario("matrix-rigid"), read_scenario("matrix-liquid-still")
    assert not agreed(rigid, [1.4]) and not agreed(rigid, [1.4, 1.5])
    assert agreed(rigid, [1.5, 1.4, 1.4009])
    assert not agreed(still, [2.0, 2.0])


def test_answers_near_the_best_are_counted() -> None:
    assert [alike(durations) for durations in ([1.4], [1.4, 1.4069], [1.4, 1.408], [1.5, 1.4, 1.404])] == [1, 2, 1, 2]
