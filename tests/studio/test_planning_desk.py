"""Planning beside the studio: progress, stopping, several at once, and what comes out."""

from __future__ import annotations

import threading
import time
from typing import Any

import pytest

from nospill.errors import NoSolutionError
from nospill.planning.planner import plan
from nospill.scenario import scene_from_table
from nospill.scene.scene import Scene
from nospill.studio import planning
from nospill.studio.planning import BUSY, PlanningDesk, PlanningSlots, PlanningState
from tests.waiting import wait_until


class Watched:
    """A desk with everything it said."""

    def __init__(self, seats: PlanningSlots) -> None:
        self.states: list[PlanningState] = []
        self.desk = PlanningDesk(seats, report=self._note)

    def _note(self) -> None:
        self.states.append(self.desk.state)

    def start(self, scene: Scene, *, warm: bool = True) -> bool:
        return self.desk.start(scene, warm=warm)

    def ended(self) -> PlanningState:
        wait_until(lambda: not self.desk.busy, "planning has ended")
        self.desk.wait()
        return self.desk.state


class SlowPlanner:
    """A planner that reports until it is stopped."""

    def __init__(self) -> None:
        self.last = None

    def plan(self, scene: Scene, *, progress: Any) -> Any:
        for number in range(10_000):
            progress(planning.PlanningProgress("solve", number, 1.0, 0.1))
            time.sleep(0.002)
        raise AssertionError("nobody stopped it")


def scene_of(table: dict[str, Any], level: str = "49 mm") -> Scene:
    cargo = [table["cargo"][0] | {"liquid_height": level}, table["cargo"][1]]
    return scene_from_table(table | {"cargo": cargo}, name="small")


@pytest.mark.slow
def test_progress_comes_at_once_and_the_answer_is_the_planners(table: dict[str, Any]) -> None:
    watched = Watched(PlanningSlots(1))
    scene = scene_of(table)
    assert watched.start(scene)
    assert watched.states  # said before anything is planned
    assert not watched.desk.start(scene)  # one at a time
    ended = watched.ended()
    assert ended.stage == "planned" and ended.plan is not None and ended.plan.status == "certified as published"
    assert ended.plan.duration == pytest.approx(plan(scene).duration, abs=1e-9)
    phases = [state.phase for state in watched.states]
    assert [phase for phase in ("start", "kinematics", "build", "solve", "certify") if phase in phases] == [
        "start",
        "kinematics",
        "build",
        "solve",
        "certify",
    ]
    solving = [state for state in watched.states if state.iteration is not None]
    assert solving and all(state.duration_s is not None and state.violation is not None for state in solving)
    seconds = [state.seconds for state in watched.states]
    assert seconds == sorted(seconds)
    assert [state.stage in BUSY for state in watched.states[:-1]] == [True] * (len(watched.states) - 1)
    warm = Watched(PlanningSlots(1))
    warm.desk._planner.last = ended.plan
    warm.start(scene_of(table, "48 mm"))
    again = warm.ended()
    assert again.plan is not None and again.plan.report.starts.tried == 1
    warm.start(scene_of(table, "48 mm"), warm=False)
    anew = warm.ended()
    assert anew.plan is not None and "kinematics" in anew.plan.report.phases
    assert again.plan.duration == pytest.approx(anew.plan.duration, rel=2e-3)


@pytest.mark.slow
def test_two_sessions_plan_at_the_same_time(table: dict[str, Any]) -> None:
    seats = PlanningSlots(2)
    scenes = [scene_of(table, level) for level in ("49 mm", "40 mm")]
    alone = [plan(scene).duration for scene in scenes]
    desks = [Watched(seats), Watched(seats)]
    for desk, scene in zip(desks, scenes, strict=True):
        desk.start(scene)
    assert [desk.desk.busy for desk in desks] == [True, True]
    found = [desk.ended().plan for desk in desks]
    assert [one.duration for one in found if one is not None] == pytest.approx(alone, abs=1e-9)


def test_who_finds_no_seat_says_so_and_can_leave(table: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(planning, "Planner", SlowPlanner)
    seats = PlanningSlots(1)
    first, second = Watched(seats), Watched(seats)
    first.start(scene_of(table))
    wait_until(lambda: first.desk.state.iteration is not None, "the first iteration")
    second.start(scene_of(table))
    wait_until(lambda: second.desk.state.stage == "waiting", "the second waits for a seat")
    second.desk.stop()
    assert second.ended().stage == "stopped"
    second.start(scene_of(table))
    wait_until(lambda: second.desk.state.stage == "waiting", "the second waits for a seat")
    first.desk.stop()
    assert first.desk.state.stage in ("stopping", "stopped")
    assert first.ended().stage == "stopped"
    wait_until(lambda: second.desk.state.iteration is not None, "the second plans")  # the seat is free again
    second.desk.stop()
    assert second.ended().stage == "stopped"
    second.desk.stop()  # nothing to stop
    assert second.desk.state.stage == "stopped"


@pytest.mark.slow
def test_a_real_plan_is_stopped_and_the_next_one_is_right(table: dict[str, Any]) -> None:
    watched = Watched(PlanningSlots(1))
    watched.start(scene_of(table))
    wait_until(lambda: watched.desk.state.iteration is not None, "the first iteration")
    before = len(watched.states)
    watched.desk.stop()
    assert watched.ended().stage == "stopped"
    # Said at once, and at most the iteration that was at work is said after it.
    assert len(watched.states) - before <= 3
    watched.start(scene_of(table))
    ended = watched.ended()
    assert ended.plan is not None
    assert ended.plan.duration == pytest.approx(plan(scene_of(table)).duration, abs=1e-9)


@pytest.mark.parametrize(
    ("error", "says"), [(NoSolutionError("No motion:\nslip"), "No motion: slip"), (ZeroDivisionError("x"), "Internal")]
)
def test_what_goes_wrong_is_said(
    table: dict[str, Any], monkeypatch: pytest.MonkeyPatch, error: Exception, says: str
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise error

    seats = PlanningSlots(1)
    watched = Watched(seats)
    monkeypatch.setattr(watched.desk._planner, "plan", fail)
    watched.start(scene_of(table))
    ended = watched.ended()
    assert ended.stage == "failed" and ended.message.startswith(says) and ended.plan is None
    assert seats.take(threading.Event(), waiting=lambda: pytest.fail("the seat was not given back"))
