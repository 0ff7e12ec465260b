"""The players of examples/players against stand-ins: what they ask for, where they refuse, the log that they write."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from nospill.execution.reading import read_log
from nospill.motion.interpolation import JointSamples
from nospill.plans.handover import exporter_named, with_options
from nospill.robots.description.catalog import load_robot
from nospill.scenario import read_scenario

FOLDER = Path(__file__).parents[2] / "examples" / "players"


@pytest.fixture(scope="module")
def player() -> Iterator[Callable[[str], ModuleType]]:
    """A script of the folder by its name; scripts find each other there."""
    sys.path.insert(0, str(FOLDER))

    def loaded(name: str) -> ModuleType:
        spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
        assert spec is not None and spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    yield loaded
    sys.path.remove(str(FOLDER))


class Recorder:
    """The part of ur_rtde that is used: an arm that is where it was last asked to be, and what it was asked."""

    def __init__(self, q: np.ndarray) -> None:
        self.q, self.asked, self.said = q, [], []

    def getActualQ(self) -> list[float]:  # as ur_rtde has it
        return self.q.tolist()

    def servoJ(self, q: list[float], *options: float) -> bool:
        self.q = np.array(q)
        self.asked.append((self.q, options))
        return True

    def moveJ(self, q: list[float], *_: float) -> bool:
        self.said.append("moveJ")
        self.q = np.array(q)
        return True

    def __getattr__(self, name: str) -> Any:
        return lambda *_: self.said.append(name)


@pytest.fixture(scope="module")
def table(samples: Callable[..., JointSamples], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of a UR5e at 500 Hz."""
    path = tmp_path_factory.mktemp("table") / "tea.csv"
    with_options(exporter_named("csv"), {"profile": "servoj"}).write(samples(), read_scenario("coffee-to-go"), path)
    return path


def test_rows_are_those_of_the_table(
    player: Callable[[str], ModuleType], table: Path, samples: Callable[..., JointSamples]
) -> None:
    rate, rows = player("rows").read_rows(table)
    assert rate == pytest.approx(500.0)
    np.testing.assert_allclose(rows, samples().position, atol=1e-12)


def test_a_table_of_something_else_is_refused(player: Callable[[str], ModuleType], tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text("t_s,A1_deg\n0,1\n1,2\n")
    with pytest.raises(SystemExit, match="no table of positions in rad; export it with --format csv"):
        player("rows").read_rows(tmp_path / "x.csv")


def test_the_way_to_the_start_is_straight_slow_and_from_rest_to_rest(player: Callable[[str], ModuleType]) -> None:
    start, goal = np.array([0.0, 1.0, -1.0]), np.array([0.5, -1.0, -1.0])
    rows = player("rows").way_to(start, goal, 1000.0, 0.2)
    np.testing.assert_allclose(rows[[0, -1]], [start, goal])
    speed = np.abs(np.diff(rows, axis=0)) * 1000.0
    assert 0.19 < np.max(speed) <= 0.2 + 1e-9
    assert np.max(speed[[0, -1]]) < 1e-5
    share = (rows - start)[:, :2] / (goal - start)[:2]
    np.testing.assert_allclose(share[:, 0], share[:, 1], atol=1e-12)


def test_servoj_is_asked_for_every_row_between_rests(
    player: Callable[[str], ModuleType], table: Path, tmp_path: Path
) -> None:
    rate, rows = player("rows").read_rows(table)
    arm = Recorder(rows[0])
    player("play_ur_rtde").run(arm, arm, rows, rate, tmp_path / "run.csv", approach=False, rest=0.1)
    asked = np.array([q for q, _ in arm.asked])
    np.testing.assert_array_equal(asked[50:-50], rows)
    np.testing.assert_array_equal(asked[[0, -1]], rows[[0, -1]])
    assert {options for _, options in arm.asked} == {(0.0, 0.0, 0.002, 0.03, 2000.0)}
    said = [name for name in arm.said if name not in ("initPeriod", "waitPeriod")]
    assert said == ["startFileRecording", "servoStop", "stopFileRecording"]


def test_an_arm_elsewhere_is_moved_only_where_that_is_said(
    player: Callable[[str], ModuleType], table: Path, tmp_path: Path
) -> None:
    rate, rows = player("rows").read_rows(table)
    script, out = player("play_ur_rtde"), tmp_path / "run.csv"
    arm = Recorder(rows[0] + np.array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0]))
    with pytest.raises(SystemExit, match=r"joint 3 stands 0\.100 rad from the first row .* say --approach"):
        script.run(arm, arm, rows, rate, out, approach=False, rest=0.0)
    assert not arm.asked
    script.run(arm, arm, rows, rate, out, approach=True, rest=0.0)
    assert "moveJ" in arm.said


def test_the_franka_is_asked_for_every_row_and_its_log_is_read(
    player: Callable[[str], ModuleType], samples: Callable[..., JointSamples], tmp_path: Path
) -> None:
    pytest.importorskip("pylibfranka", reason="pylibfranka is not installed; make robots does it")
    rows = np.linspace(0.0, 0.05, 200)[:, None] + np.array([0.1, 0.2, 0.3, -1.5, 0.0, 1.6, 0.4])
    asked: list[Any] = []

    class Robot:
        """Every cycle takes 1 ms, but one; the arm is one row behind."""

        def read_once(self) -> Any:
            return SimpleNamespace(q=list(rows[0]), q_d=list(rows[0]))

        def start_joint_position_control(self, _: Any) -> Any:
            return self

        def readOnce(self) -> Any:  # as pylibfranka has it
            passed = 3e-3 if len(asked) == 400 else 1e-3
            q = asked[-1].q if asked else rows[0]
            return SimpleNamespace(q=list(q)), SimpleNamespace(to_sec=lambda: passed)

        def writeOnce(self, command: Any) -> None:
            asked.append(command)

    log, lost = player("play_franka").play(Robot(), rows)
    assert lost == 0
    asked.clear()
    out = tmp_path / "run.csv"
    player("play_franka").run(Robot(), rows, out, approach=False)
    np.testing.assert_array_equal([own.q for own in asked[300:-800]], rows)
    assert [own.motion_finished for own in asked] == [False] * (len(asked) - 1) + [True]
    found = read_log(out, load_robot("franka-fr3"))
    assert found.command is not None
    np.testing.assert_allclose(found.position[301:501], found.command[300:500], atol=1e-8)
    np.testing.assert_allclose(np.diff(found.t), 1e-3, atol=1e-9)
    assert len(log) == len(rows)
