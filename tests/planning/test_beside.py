"""A computation beside the process: its result comes back, its failure harms nobody, nothing is left of it."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nospill.planning import beside as module
from nospill.planning import run as planning_run
from nospill.planning.beside import beside
from nospill.planning.planner import plan
from nospill.scenario import read_scenario

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="forks are made on Linux only")


@pytest.fixture(autouse=True)
def two_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NOSPILL_THREADS", "2")


def children() -> set[int]:
    """Process numbers of those that this process has started and not yet seen the end of."""
    tasks = Path(f"/proc/{os.getpid()}/task")
    return {int(number) for task in tasks.iterdir() for number in (task / "children").read_text().split()}


def die() -> None:
    raise ValueError("of its own")


def test_the_result_comes_back_whole() -> None:
    before = children()
    large = np.arange(200_000.0)  # more than a pipe holds
    with beside(lambda: (os.getpid(), large * 2)) as other:
        assert other is not None
        found = other.result()
    assert found is not None and found[0] != os.getpid()
    assert np.array_equal(found[1], large * 2)
    assert children() == before


@pytest.mark.parametrize(
    "work", [die, sys.exit, lambda: os._exit(0), lambda: os.kill(os.getpid(), 9), lambda: lambda: None]
)
def test_no_result_is_none(work: Callable[[], object], capfd: pytest.CaptureFixture[str]) -> None:
    """It raises, exits, ends without a word, is killed, or gives what cannot be handed over."""
    with beside(work) as other:
        assert other is not None and other.result() is None
    assert capfd.readouterr() == ("", "")


def test_it_is_stopped_at_the_end() -> None:
    before, descriptors = children(), set(os.listdir("/proc/self/fd"))
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt), beside(lambda: time.sleep(60)) as other:
        assert other is not None and len(children() - before) == 1
        raise KeyboardInterrupt
    assert time.monotonic() - began < 20.0
    assert children() == before
    assert set(os.listdir("/proc/self/fd")) == descriptors
    assert other is not None and other.result() is None


def test_where_there_is_nothing_to_gain_there_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    with beside(None) as other:
        assert other is None
    monkeypatch.setenv("NOSPILL_THREADS", "1")
    with beside(os.getpid) as other:
        assert other is None
    monkeypatch.setenv("NOSPILL_THREADS", "2")
    monkeypatch.setattr(module.sys, "platform", "darwin")
    with beside(os.getpid) as other:
        assert other is None


def test_no_room_for_another_process(monkeypatch: pytest.MonkeyPatch) -> None:
    def full() -> int:
        raise BlockingIOError(11, "Resource temporarily unavailable")

    descriptors = set(os.listdir("/proc/self/fd"))
    monkeypatch.setattr(module.os, "fork", full)
    with beside(os.getpid) as other:
        assert other is None
    assert set(os.listdir("/proc/self/fd")) == descriptors


# --- the second start -----------------------------------------------------------------------------------------------


@pytest.fixture
def forked(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Whether each second answer was taken; forks are made without machine code too."""
    taken: list[bool] = []
    usual = planning_run.PlanningRun._taken

    def noted(run: planning_run.PlanningRun, *arguments: Any) -> Any:
        found = usual(run, *arguments)
        taken.append(found is not None)
        return found

    monkeypatch.setattr(planning_run.PlanningRun, "_taken", noted)
    monkeypatch.setattr(planning_run.PlanningRun, "_is_compiled", lambda run, joint_path: True)
    return taken


@pytest.mark.slow
@pytest.mark.parametrize("name", ["matrix-rigid", "pp-two-cups"])
def test_the_answer_is_the_same_to_the_last_bit(name: str, forked: list[bool]) -> None:
    scene = read_scenario(name)
    alone = plan(scene)
    assert forked == []
    beside_it = plan(scene, fork=True)
    assert forked == [True]
    assert np.array_equal(alone.trajectory.joint_position, beside_it.trajectory.joint_position)
    assert alone.report.starts == beside_it.report.starts
    assert alone.report.iterations == beside_it.report.iterations


@pytest.mark.slow
@pytest.mark.parametrize("wrong", ["other rows", "no answer"])
def test_an_answer_that_would_not_come_out_here_is_not_taken(
    wrong: str, forked: list[bool], monkeypatch: pytest.MonkeyPatch
) -> None:
    second = planning_run.PlanningRun._second

    def changed(run: planning_run.PlanningRun, *arguments: Any) -> Any:
        if wrong == "no answer":
            raise RuntimeError
        return replace(second(run, *arguments), joined=set())

    monkeypatch.setattr(planning_run.PlanningRun, "_second", changed)
    scene = read_scenario("pp-two-cups")
    alone, beside_it = plan(scene), plan(scene, fork=True)
    assert forked == [False]
    assert np.array_equal(alone.trajectory.joint_position, beside_it.trajectory.joint_position)
    assert alone.report.iterations == beside_it.report.iterations


@pytest.mark.slow
def test_where_the_first_start_fails_the_second_is_solved_with_patience(
    forked: list[bool], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(planning_run, "usable", lambda solution: len(tried) > 1 or bool(tried.append(solution)))
    tried: list[Any] = []
    scene = read_scenario("matrix-rigid")
    found = plan(replace(scene, planning=replace(scene.planning, intervals=40)), fork=True)
    assert forked == [False] and found.certificate.ok
