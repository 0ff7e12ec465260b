"""The command line in a folder of its own, with stand-ins for planner, judge and figures."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.cli.stand_in import StandIn

ROOT = Path(__file__).parents[2]


@pytest.fixture
def stand_in(monkeypatch: pytest.MonkeyPatch) -> StandIn:
    made = StandIn()
    for name, module in made.modules().items():
        monkeypatch.setitem(sys.modules, name, module)
    return made


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("NOSPILL_TRACEBACK", raising=False)
    return tmp_path


@pytest.fixture
def outside(tmp_path: Path) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """The command in a process of its own, with the stand-ins and a line of code as the planner's work."""
    started: list[subprocess.Popen[str]] = []

    def start(work: str, *arguments: str) -> subprocess.Popen[str]:
        script = (
            f"import sys; sys.path.insert(0, {str(ROOT)!r})\n"
            "import ctypes, os, time\n"
            "from tests.cli.stand_in import StandIn\n"
            f"def work():\n    {work}\n"
            "sys.modules.update(StandIn(planning=work).modules())\n"
            "from nospill.cli import main\n"
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


@pytest.fixture
def plan_folder(folder: Path) -> Path:
    made = folder / "tea"
    made.mkdir()
    (made / "summary.json").write_text("old")
    return made
