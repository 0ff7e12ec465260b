"""Problems with liquids at many speeds: what joins them, and what their own rows get meanwhile."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from nospill.certification.certificate import Judgement
from nospill.certification.verdict import Certificate, Row
from nospill.laws.constraints.base import RowId
from nospill.planning import refinement
from nospill.planning.active_set import ActiveSet
from nospill.planning.log import Log
from nospill.planning.next_set import next_set
from nospill.planning.row_backoff import crests_of, tightened
from nospill.planning.task import Task
from nospill.planning.widest_range import broken_speeds
from nospill.scenario import read_scenario

Q = np.zeros((2, 6))


@pytest.fixture(scope="module")
def task() -> Task:
    return Task.of(read_scenario("mixed-tray").changed({"motion.speed_range": [0.5, 1.0]}))


def at(task: Task, speed: float) -> tuple[str, str]:
    """The cup at the speed of the range that is nearest."""
    own = [item for item in task.speeds if item[0] == "cup"]
    return min(own, key=lambda item: abs(task.speeds[item] - speed))


def with_cups(task: Task, *speeds: float) -> ActiveSet:
    members = task.first_members | {at(task, speed) for speed in speeds}
    return ActiveSet.of(task, Q, members, frozenset({"cup", "box", "mug"}), 3)


def judgement(*uses: tuple[str, tuple[str, str], float]) -> Judgement:
    """Of rows with a limit of 1, by constraint and variant."""
    rows = tuple(
        Row(constraint, name, "1", 1.0, use, 1.0 - use, 0.5, use <= 1.0, text) for constraint, (name, text), use in uses
    )
    replay: Any = SimpleNamespace(joint_position=Q, t=np.array([0.0, 1.0]))
    return Judgement(Certificate(all(row.ok for row in rows), 2000.0, ()), (), replay, 1.0, rows)


def test_of_many_speeds_no_row_is_stuck_and_no_modes_join(task: Task) -> None:
    active = replace(with_cups(task, 0.9, 0.8, 0.7), excess=0.02)
    after = next_set(active, judgement(("residual height", at(task, 0.8), 1.018)))
    key = RowId("residual height", active.names[at(task, 0.8)])
    assert (after.modes, after.smoothness.factor, after.members) == (3, 1.0, active.members)
    assert {row for row, value in after.backoff.items() if value > active.backoff[row]} == {key}

    alone = replace(with_cups(task), excess=0.02)
    assert next_set(alone, judgement(("residual height", ("cup", ""), 1.018))).modes == 6

    spent = active.with_backoff({key: 0.85})
    heavier = next_set(spent, judgement(("residual height", at(task, 0.8), 1.018)))
    assert (heavier.modes, heavier.smoothness.factor) == (3, 2.0)


def test_rows_at_the_planned_speed_are_of_members_that_move_so_fast() -> None:
    """Half of what a slowed member has left would be kept back of it, for nothing."""
    scene = read_scenario("matrix-liquid-tilt-robust").changed({"motion.speed_range": [0.5, 1.0]})
    task = Task.of(scene)
    speeds = [item for item in task.speeds if item[0] == "c1" and task.speeds[item] < 1.0]
    active = ActiveSet.of(task, Q, task.first_members | {speeds[len(speeds) // 2]})
    outside = next(item for item in task.speeds if item[0] == "c1" and "fill" in item[1] and task.speeds[item] == 1.0)
    assert outside not in active.names
    rows = judgement(("slosh height", outside, 1.003)).corners
    assert {row.subject for row in active.on_members(rows)} == {"c1"}
    slowed = judgement(("slosh height", speeds[0], 1.003)).corners
    assert {row.subject for row in active.on_members(slowed)} == {active.names[speeds[len(speeds) // 2]]}


def test_a_height_after_the_end_that_hardly_falls_is_tightened_by_the_secant() -> None:
    """By modes outside the problem: 1.014 of the limit, and a tenth of each step of the back-off less."""
    key = RowId("residual height", "a")

    def rounds(by_secant: bool) -> int:
        backoff, before, count = {key: 0.08}, dict[RowId, tuple[float, float]](), 0
        while (use := 1.014 - 0.1 * (backoff[key] - 0.08)) > 1.0 and count < 30:
            rows = [Row(*key, "m", 1.0, use, 1.0 - use, 0.0, False)]
            following, _ = tightened(rows, [key], backoff, {}, before if by_secant else {})
            before, backoff, count = crests_of(rows, backoff), following, count + 1
        assert backoff[key] < 0.3  # no farther than a little below the limit
        return count

    assert rounds(by_secant=True) <= 6 < 20 < rounds(by_secant=False)


def test_a_height_that_back_off_has_raised_says_no_secant() -> None:
    """Other waves make it: 1.019 of the limit, then 1.038 with more back-off."""
    key = RowId("residual height", "a")
    row = Row(*key, "m", 1.0, 1.038, -0.038, 0.0, False)
    rising, _ = tightened([row], [key], {key: 0.53}, {}, {key: (0.5, 1.019)})
    unknown, _ = tightened([row], [key], {key: 0.53}, {}, {})
    assert rising == unknown


def test_what_falls_as_the_law_says_is_not_tightened_further() -> None:
    key = RowId("residual height", "a")
    backoff, before = {key: 0.05}, {key: (0.0, 1.05)}
    row = Row(*key, "m", 1.0, 1.01, -0.01, 0.0, False)
    assert tightened([row], [key], backoff, {}, before) == tightened([row], [key], backoff, {})


@pytest.mark.parametrize(("speeds", "rounds"), [((), 8), ((0.9, 0.8), 1)])
def test_a_certified_motion_over_a_range_is_solved_once_more(
    monkeypatch: pytest.MonkeyPatch, speeds: tuple[float, ...], rounds: int
) -> None:
    """For what a finer grid may find; as often as it takes where no verdict is one at many speeds."""
    scene: Any = SimpleNamespace(tracking=None, motion=SimpleNamespace(speeds=speeds, speed_range=None))

    def candidate() -> Any:
        same = SimpleNamespace(factor=1.0)
        active = SimpleNamespace(task=SimpleNamespace(scene=scene), scene=scene, margins={}, smoothness=same)
        solution, stages = SimpleNamespace(slack={}), SimpleNamespace(duration=1.0)
        return SimpleNamespace(active=active, solution=solution, stages=stages)

    verdict: Any = SimpleNamespace(certificate=SimpleNamespace(ok=True), leaves_margin=False)
    record: Any = SimpleNamespace(end_time=1.0)
    monkeypatch.setattr(refinement, "_judge", lambda one, *_, **__: refinement.Judged(one, record, verdict))
    monkeypatch.setattr(refinement, "next_set", lambda active, *_: SimpleNamespace(**vars(active)))
    monkeypatch.setattr(refinement, "_at_least", lambda *_: 1.0)
    monkeypatch.setattr(refinement, "tighten", lambda *_, **__: candidate())
    log = Log(None, 60.0)
    assert refinement.refine_until_certified(candidate(), log).judgement is verdict
    assert log.rounds == rounds


def test_broken_speeds_are_those_of_objects(task: Task) -> None:
    found = judgement(("residual height", at(task, 0.8), 1.1), ("slosh height", at(task, 0.7), 0.9))
    assert broken_speeds(found, task) == {task.speeds[at(task, 0.8)]}
    assert broken_speeds(judgement(("slosh height", ("cup", ""), 1.1)), task) == {1.0}
