"""What several test files share: measured data, and smooth motions that need no solver."""

from __future__ import annotations

import gc
import os
import shutil
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read when numpy is loaded; two threads wait for each other here

import numpy as np
import pytest
from filelock import FileLock
from hypothesis import settings
from typer.testing import CliRunner, Result

from nospill.cli.reporting import INTERNAL_ERROR
from nospill.compiled.small_libraries import small_library
from nospill.judge.certificate import judge
from nospill.motion.interpolation import JointSamples
from nospill.motion.trajectory import Trajectory
from nospill.planning.planner import plan
from nospill.plans.plan import Plan
from nospill.plans.records import PlanningReport, motion_maxima
from nospill.robots.joint_paths.search import JointPath
from nospill.scenario import read_scenario
from nospill.scene.scene import Scene
from nospill.transcription.export_samples import export_samples
from nospill.transcription.stages import Stages
from nospill.transcription.starting_motions import Start, smooth_start
from nospill.warmup.usual import usual_parts
from nospill.warmup.warming import warm_cache
from tests.builders import joint_path_of, one_mode, with_few_speeds
from tests.compiling import AT_FIRST, forget, hasty_compiler
from tests.example_plans import planned_once

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # As a shell starts what it puts in the background; processes started by the tests would inherit it and never stop.
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Of properties that state no number of their own; HYPOTHESIS_PROFILE=thorough, as in the workflow of CI, tries more.
settings.register_profile("usual", max_examples=60, deadline=None)
settings.register_profile("thorough", max_examples=300, deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "usual"))

COMPILED = Path(__file__).parents[1] / ".pytest_cache" / "compiled"
"""Compiled functions are kept between runs: their key is the source they are made of. `make clean` removes them."""


@pytest.fixture(scope="session", autouse=True)
def hasty() -> Iterator[Path | None]:
    """A hasty compiler, with which the largest functions are compiled for all tests; one thread each.

    The others are compiled where an example is planned and interpreted elsewhere: most scenes of the tests are planned
    once, and to compile their functions takes longer than to interpret them. None of the user's compiled functions are
    used. A test that wants otherwise sets the variables itself (monkeypatch).
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("NOSPILL_COMPILE", "wait")
        patch.setenv("NOSPILL_THREADS", "1")  # tests run side by side
        patch.setenv("NOSPILL_CACHE", str(COMPILED))
        COMPILED.mkdir(parents=True, exist_ok=True, mode=0o700)
        with FileLock(COMPILED / "compiler.lock"):
            compiler = hasty_compiler(COMPILED)
            if compiler is not None:
                patch.setenv("CC", str(compiler))
                # What every worker needs: one that comes while another compiles goes on without.
                small_library("interpreter", wait=True)
                warm_cache(tuple(part for part in usual_parts() if part.label.startswith(AT_FIRST)), progress=print)
        patch.setenv("CC", "no-compiler-for-what-is-planned-once")
        yield compiler


@pytest.fixture(scope="module")
def in_virtual_machine() -> Iterator[None]:
    """Functions of a module's tests are CasADi's own, which it can differentiate and look into."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("NOSPILL_COMPILE", "off")
        forget()
        yield
    forget()


@pytest.fixture(scope="session", autouse=True)
def internal_errors_are_shown() -> Iterator[None]:
    """Beside a failed test stands the traceback of a command's internal error, which the runner of commands keeps."""
    invoke = CliRunner.invoke

    def shown(self: CliRunner, *args: Any, **options: Any) -> Result:
        result = invoke(self, *args, **options)
        if result.exit_code == INTERNAL_ERROR:
            print(result.stderr, file=sys.stderr)
        return result

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("NOSPILL_TRACEBACK", "1")
        patch.setattr(CliRunner, "invoke", shown)
        yield


@pytest.fixture(scope="session", autouse=True)
def few_speeds_on_figures() -> Iterator[None]:
    """The curve over the other speeds has three points instead of 19; commands in processes of their own have all."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("nospill.plots.evidence._SPEEDS", (0.1, 0.5, 1.0))
        yield


@pytest.fixture(scope="session")
def changed_scene() -> Callable[..., Scene]:
    """Make a variant of an example: its name, and new values by place, for example {"motion.tilt": "fixed"}."""

    def make(name: str, changes: Mapping[str, Any]) -> Scene:
        return read_scenario(name).changed(changes)

    return make


@pytest.fixture(scope="session")
def example_plan(hasty: Path | None) -> Callable[[str], Plan]:
    """Plan an example, once for all tests until the package changes (`example_plans`)."""

    def planned(name: str) -> Plan:
        with pytest.MonkeyPatch.context() as patch:
            if hasty is not None:
                patch.setenv("CC", str(hasty))
            return plan(read_scenario(name))

    @cache
    def shared(name: str) -> Plan:
        return planned_once(name, lambda: planned(name))

    return shared


@dataclass(frozen=True)
class SmoothMotion:
    """A scene with a quintic motion along its path, on the grid of the optimal control problem and as exported.

    The scene states one mode of each liquid; the model is the scene with one mode, of which the grid is.
    """

    scene: Scene
    model: Scene
    stages: Stages
    trajectory: Trajectory


@cache
def _joint_path(name: str) -> JointPath:
    scene = read_scenario(name)
    return joint_path_of(scene)


@cache
def _smooth_motion(name: str, cargo: int | None, intervals: int, start: Start) -> SmoothMotion:
    scene = one_mode(name)
    scene = scene.changed({"cargo": scene.source["cargo"][:cargo]})
    model = scene.with_one_mode()
    stages = smooth_start(model, _joint_path(name), intervals, start)
    return SmoothMotion(scene, model, stages, export_samples(model, stages))


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
def gentle_plan(smooth_motion) -> Callable[..., Plan]:
    """A certified plan of an example, slow enough to keep every limit with room: its name, and how many objects."""

    @cache
    def make(name: str, cargo: int | None = None) -> Plan:
        motion = smooth_motion(name, cargo=cargo, stretch=0.8 if name == "matrix-rigid" else 1.3)
        judgement = judge(motion.trajectory, motion.scene)
        assert judgement.certificate.ok
        report = PlanningReport.empty()
        maxima = motion_maxima(judgement, motion.scene)
        return with_few_speeds(Plan(motion.scene, motion.trajectory, judgement.certificate, maxima, report))

    return make


def curve(samples: int = 40, joints: int = 6, rate: float = 500.0) -> JointSamples:
    """A rest-to-rest quintic in every joint, with different ends; times as whole nanoseconds."""
    t = np.round(np.arange(samples) / rate * 1e9) / 1e9
    u, length = (t / t[-1])[:, None], t[-1]
    start, way = np.linspace(-1.3, 2.1, joints), np.linspace(0.5, -3.0, joints)
    return JointSamples(
        t,
        start + way * (10 * u**3 - 15 * u**4 + 6 * u**5),
        way * (30 * u**2 - 60 * u**3 + 30 * u**4) / length,
        way * (60 * u - 180 * u**2 + 120 * u**3) / length**2,
    )


@pytest.fixture(scope="session")
def samples() -> Callable[..., JointSamples]:
    """Make the `curve`."""
    return curve


@pytest.fixture(scope="session")
def measured() -> Path:
    """The folder of measured and published data, named by NOSPILL_DATA; tests that ask for it are skipped without."""
    from tests.measured import measured_data  # brings a benchmark along

    return measured_data()


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
    gc.collect()  # what Playwright leaves in cycles goes here, and not in the midst of another test
