"""The command line in a folder of its own, with a real small plan that is there already in place of the planner's."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from unittest.mock import create_autospec

import pytest

from nospill.certification.certificate import judge
from nospill.laws.constraints.base import RowId
from nospill.planning import planner
from nospill.planning.log import OnProgress, PlanningProgress
from nospill.plans.plan import Plan
from nospill.plans.warnings.record import PlanWarning
from nospill.scenario import read_scenario
from nospill.scene.scene import Scene


@dataclass
class Boundary:
    """What stands in the planner's place: it hands back a plan, and keeps what it was asked for.

    Attributes:
        plan: handed back.
        work: what goes on meanwhile.
        scenes: asked for.
    """

    plan: Plan
    work: Callable[[], None] = lambda: None
    scenes: list[Scene] = field(default_factory=list)

    def answer(self, scene: Scene, *, progress: OnProgress) -> Plan:
        self.scenes.append(scene)
        progress(PlanningProgress("build"))
        for iteration in (1, 2):
            progress(PlanningProgress("solve", iteration, 1.9, 1e-3, "fine"))
        progress(PlanningProgress("certify"))
        self.work()
        return self.plan

    def fails(self, error: BaseException) -> None:
        def raising() -> None:
            raise error

        self.work = raising


@pytest.fixture(scope="session")
def tea(gentle_plan: Callable[..., Plan]) -> Plan:
    """A certified plan of one cup, of which it is known what holds it back and what it was warned of."""
    plan = gentle_plan("matrix-liquid", cargo=1)
    friction = RowId("slip", "c1").label
    return replace(
        plan,
        maxima=replace(plan.maxima, time_at_limit={friction: 0.31}),
        report=replace(plan.report, branch="start (0, 0) deg", savings={friction: 0.05}, compared={"level tray": 5.0}),
        warnings=(PlanWarning("crest", "c1", "it is high."),),
    )


@pytest.fixture(scope="session")
def saved_tea(tea: Plan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its folder, not to be written to."""
    place = tmp_path_factory.mktemp("saved") / "tea"
    tea.save(place)
    return place


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("NOSPILL_TRACEBACK", raising=False)
    return tmp_path


@pytest.fixture
def boundary(tea: Plan, saved_tea: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> Boundary:
    """The planner's place, and the scenario "tea.toml"; it is called as the planner is, or raises a TypeError."""
    shutil.copy(saved_tea / "scenario.toml", folder / "tea.toml")
    made = Boundary(tea)
    monkeypatch.setattr(planner, "plan", create_autospec(planner.plan, side_effect=made.answer))
    return made


@pytest.fixture
def failing(tea: Plan, saved_tea: Path) -> Plan:
    """The same motion on a smoother tray."""
    scene = read_scenario(str(saved_tea / "scenario.toml"), settings=["tray.friction=0.09"])
    return replace(tea, scene=scene, certificate=judge(tea.trajectory, scene).certificate)


@pytest.fixture
def plan_folder(saved_tea: Path, folder: Path) -> Path:
    return Path(shutil.copytree(saved_tea, folder / "tea"))


@pytest.fixture
def outside(saved_tea: Path, tmp_path: Path) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """The command in a process of its own, with a line of code as the planner's work."""
    started: list[subprocess.Popen[str]] = []

    def start(work: str, *arguments: str) -> subprocess.Popen[str]:
        script = (
            "import ctypes, os, time\n"
            "from nospill.cli import main\n"
            "from nospill.planning import planner\n"
            "from nospill.plans.loading import load_plan\n"
            "def plan(scene, **options):\n"
            f"    {work}\n"
            f"    return load_plan({str(saved_tea)!r})\n"
            "planner.plan = plan\n"
            "main()\n"
        )
        process = subprocess.Popen(
            [sys.executable, "-c", script, *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
        )
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()
