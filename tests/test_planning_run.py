"""The order in which starting motions are tried."""

from __future__ import annotations

from dataclasses import replace

import pytest

from nospill.ocp.guess import USUAL_START
from nospill.planning_run import PlanningRun
from nospill.scenario import read_scenario


@pytest.mark.parametrize("count", [1, 3, 6])
def test_starts_beyond_those_asked_for_are_for_when_nothing_is_found(count: int) -> None:
    scene = read_scenario("matrix-rigid")
    run = PlanningRun(replace(scene, planning=replace(scene.planning, starts=count)), None, frozenset())
    starts, patience, _, all_rows = zip(*run._attempts(briefly=False), strict=True)
    assert starts[0] == USUAL_START
    assert len(set(starts[: count + 1])) == count + 1
    assert patience[count] > patience[0] and not any(all_rows[: count + 1])
    # the usual two again, then what has not been tried
    assert starts[count + 1 : count + 3] == (starts[1], starts[0]) and all(all_rows[count + 1 :])
    assert not set(starts[count + 3 :]) & set(starts[: count + 1])
    assert [attempt[:2] for attempt in run._attempts(briefly=True)] == list(zip(starts, patience, strict=True))[:count]
