"""What several test files share: measured data, and smooth motions that need no solver."""

from __future__ import annotations

import copy
import os
import shutil
import signal
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from nospill.ocp.answer import export_samples
from nospill.ocp.guess import Start, smooth_start
from nospill.ocp.stages import Stages
from nospill.planner import plan
from nospill.plans import Plan
from nospill.robots.inverse import JointPath, joint_paths
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene import Scene
from nospill.trajectory import Trajectory

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # As a shell starts what it puts in the background; processes started by the tests would inherit it and never stop.
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session", autouse=True)
def no_compiled_functions(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """No compiler at work behind the tests, none of the user's compiled functions in them, and one thread each.

    A test that wants otherwise sets the variables itself (monkeypatch).
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("NOSPILL_COMPILE", "off")
        patch.setenv("NOSPILL_THREADS", "1")  # tests run side by side
        patch.setenv("NOSPILL_CACHE", str(tmp_path_factory.mktemp("nospill-cache")))
        yield


@pytest.fixture(scope="session")
def changed_scene() -> Callable[..., Scene]:
    """Make a variant of an example: its name, and new values by place, for example {"motion.tilt": "fixed"}."""

    def make(name: str, changes: Mapping[str, Any]) -> Scene:
        table: Any = copy.deepcopy(read_scenario(name).source)
        for place, value in changes.items():
            *parents, key = place.split(".")
            entry = table
            for parent in parents:
                entry = entry[int(parent)] if isinstance(entry, list) else entry.setdefault(parent, {})
            entry[int(key) if isinstance(entry, list) else key] = value
        return scene_from_table(table, name=name)

    return make


@pytest.fixture(scope="session")
def example_plan() -> Callable[[str], Plan]:
    """Plan an example, once for all tests."""
    return cache(lambda name: plan(read_scenario(name)))


@dataclass(frozen=True)
class SmoothMotion:
    """A scene with a quintic motion along its path, on the grid of the optimal control problem and as exported."""

    scene: Scene
    stages: Stages
    trajectory: Trajectory


@cache
def _joint_path(name: str) -> JointPath:
    scene = read_scenario(name)
    return joint_paths(scene.robot, scene.path, tool_position=scene.tray.offset, tool_yaw=scene.tray.yaw_on_flange)[0]


@cache
def _smooth_motion(name: str, cargo: int | None, intervals: int, start: Start) -> SmoothMotion:
    scene = read_scenario(name)
    scene = replace(scene, cargo=scene.cargo[:cargo])
    stages = smooth_start(scene, _joint_path(name), intervals, start)
    return SmoothMotion(scene, stages, export_samples(scene, stages))


@pytest.fixture(scope="session")
def smooth_motion() -> Callable[..., SmoothMotion]:
    """Make (once) the smooth motion of an example: name, number of objects kept, intervals, and how it starts."""

    def make(
        name: str,
        *,
        cargo: int | None = None,
        intervals: int = 200,
        stretch: float = 1.0,
        skew: float = 0.0,
        tilt: tuple[float, float] = (0.0, 0.0),
    ) -> SmoothMotion:
        return _smooth_motion(name, cargo, intervals, Start(stretch, skew, tilt))

    return make


@pytest.fixture(scope="session")
def measured() -> Path:
    """The folder of measured and published data, named by NOSPILL_DATA; tests that ask for it are skipped without."""
    folder = Path(os.environ.get("NOSPILL_DATA", Path(__file__).parents[2] / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"measured data missing: {folder}; set NOSPILL_DATA")
    return folder


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Headless Chromium, driven by Playwright, with software rendering; tests that ask for it are skipped without."""
    playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if program is None:
        pytest.skip("no chromium on the path; apt-get install chromium")
    flags = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with playwright.sync_playwright() as started:
        found = started.chromium.launch(executable_path=program, args=flags)
        yield found
        found.close()
