"""What several test files share: measured data, and smooth motions that need no solver."""

from __future__ import annotations

import ctypes
import gc
import os
import shutil
import signal
import sys
from collections.abc import Callable, Generator, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read when numpy is loaded; two threads wait for each other here

import pytest
from filelock import FileLock, Timeout
from hypothesis import settings
from typer.main import get_command
from typer.testing import CliRunner, Result

from nospill.cli.reporting import INTERNAL_ERROR
from tests.hasty import COMPILED, NO_COMPILER, compile_frequent_functions, compiled_first

if TYPE_CHECKING:  # a file of tests that plans nothing is run without the planner and the judge
    from nospill.certification.verdict import Row
    from nospill.motion.interpolation import JointSamples
    from nospill.motion.trajectory import Trajectory
    from nospill.plans.plan import Plan
    from nospill.scene.scene import Scene
    from tests.motions import SmoothMotion

# Memory that arrays give back stays in the process (glibc): to ask the system for it again is two fifths of its time.
_TRIM_THRESHOLD, _TOP_PAD, _MMAP_THRESHOLD = -1, -2, -3
_mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
if _mallopt is not None:
    _mallopt(_TRIM_THRESHOLD, 2**31 - 1)
    _mallopt(_TOP_PAD, 64 * 2**20)
    _mallopt(_MMAP_THRESHOLD, 32 * 2**20)  # the largest it takes

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # As a shell starts what it puts in the background; processes started by the tests would inherit it and never stop.
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Of properties that state no number of their own; HYPOTHESIS_PROFILE=thorough, as in the workflow of CI, tries more.
settings.register_profile("usual", max_examples=60, deadline=None)
settings.register_profile("thorough", max_examples=300, deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "usual"))


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """In a fresh clone one worker collects first: the others read the bytecode of the tests that it has written.

    To rewrite their assertions takes twice as long as to collect them. Meanwhile another worker compiles what all need.
    """
    collected = COMPILED / "collected"
    if "PYTEST_XDIST_WORKER" not in os.environ or sys.dont_write_bytecode or collected.exists():
        return (yield)
    COMPILED.mkdir(parents=True, exist_ok=True, mode=0o700)
    lock = FileLock(COMPILED / "collection.lock")
    try:
        lock.acquire(blocking=False)
    except Timeout:
        with pytest.MonkeyPatch.context() as patch:
            compiled_first(patch)
        lock.acquire()
    try:
        return (yield)
    finally:
        lock.release()
        collected.touch()


def pytest_collection_finish() -> None:
    """What was imported and collected stays to the end: the garbage collector need not look at it again and again."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)


@pytest.fixture(scope="session", autouse=True)
def hasty() -> Iterator[None]:
    """Functions that are evaluated often, hastily compiled once for all tests; one thread each.

    The others are interpreted, those of problems too: most scenes of the tests are planned once or twice, and to
    compile their functions takes longer than to interpret them. None of the user's compiled functions are used. A test
    that wants otherwise sets the variables itself (monkeypatch).
    """
    with pytest.MonkeyPatch.context() as patch:
        compiler = compiled_first(patch)
        if compiler is not None:
            compile_frequent_functions(compiler, patch)
        patch.setenv("CC", NO_COMPILER)
        yield


@pytest.fixture(scope="module")
def in_virtual_machine() -> Iterator[None]:
    """Functions of a module's tests are CasADi's own, which it can differentiate and look into."""
    from nospill.compiled.kept import forget_functions

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("NOSPILL_COMPILE", "off")
        forget_functions()
        yield
    forget_functions()


@pytest.fixture(scope="session", autouse=True)
def internal_errors_are_shown() -> Iterator[None]:
    """Beside a failed test stands the traceback of a command's internal error, which the runner of commands keeps.

    The runner makes the commands of the program anew for every one that it runs; here they are made once.
    """
    invoke = CliRunner.invoke

    def shown(self: CliRunner, *args: Any, **options: Any) -> Result:
        result = invoke(self, *args, **options)
        if result.exit_code == INTERNAL_ERROR:
            print(result.stderr, file=sys.stderr)
        return result

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("NOSPILL_TRACEBACK", "1")
        patch.setattr(CliRunner, "invoke", shown)
        patch.setattr("typer.testing._get_command", cache(get_command))
        yield


@pytest.fixture(scope="session", autouse=True)
def few_other_speeds() -> Iterator[None]:
    """Plans that are saved, printed and drawn are looked at at three other speeds instead of 12 and 19.

    Commands in processes of their own have all, and so has a test that says so (`every_other_speed`).
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("nospill.certification.other_speeds.uses_at.__defaults__", ((0.1, 0.5, 0.95),))
        patch.setattr("nospill.plots.evidence._SPEEDS", (0.1, 0.5, 1.0))
        yield


@pytest.fixture(scope="session", autouse=True)
def survived_without_a_search() -> Iterator[None]:
    """What a saved or printed plan survives is the plan itself, played as those who survive are, and no search.

    Tests of the figures ask `certification.survival` itself, and a command in a process of its own searches.
    """
    from nospill.certification.survival import Looked
    from nospill.certification.survived import Survival, Survived
    from nospill.certification.tracked_rows import Followed, worst_of
    from nospill.plans import plan

    def played(trajectory: Trajectory, scene: Scene, rows: tuple[Row, ...]) -> Survival | None:
        if not scene.cargo:
            return None
        use, first = worst_of(Looked.at(Followed.of(trajectory, scene, rows)).stated)
        return Survival(Survived(1e-3 if use < 1.0 else 0.0, first.label), Survived(1e-4), Survived(60.0))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plan, "survival", played)
        yield


@pytest.fixture(scope="session", autouse=True)
def examples_are_built_once() -> Iterator[None]:
    """A bundled example with the same settings is the same scene, which nothing changes: a thousand tests read one."""
    from nospill.scenario import loading
    from nospill.scenario.examples import example_path

    bundled, built, read = example_path("matrix-liquid").parent, {}, loading.scene_from_table

    def once(table: Mapping[str, Any], *, name: str, folder: Path, label: str) -> Scene:
        if folder != bundled:
            return read(table, name=name, folder=folder, label=label)
        key = (name, label, repr(table))
        if key not in built:
            built[key] = read(table, name=name, folder=folder, label=label)
        return built[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(loading, "scene_from_table", once)
        yield


@pytest.fixture
def every_other_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    from nospill.certification.other_speeds import SPEEDS, uses_at

    monkeypatch.setattr(uses_at, "__defaults__", (SPEEDS,))


@pytest.fixture(scope="session")
def changed_scene() -> Callable[..., Scene]:
    """Make a variant of an example: its name, and new values by place, for example {"motion.tilt": "fixed"}."""

    from nospill.scenario import read_scenario

    def make(name: str, changes: Mapping[str, Any]) -> Scene:
        return read_scenario(name).changed(changes)

    return make


@pytest.fixture(scope="session")
def example_plan() -> Callable[[str], Plan]:
    """Plan an example, once for all tests until the package changes (`example_plans`)."""

    from nospill.planning.planner import plan
    from nospill.scenario import read_scenario
    from tests.example_plans import planned_once

    @cache
    def shared(name: str) -> Plan:
        return planned_once(name, lambda: plan(read_scenario(name)))

    return shared


@pytest.fixture(scope="session")
def smooth_motion() -> Callable[..., SmoothMotion]:
    """Make (once) the smooth motion of an example (`motions`)."""
    from tests.motions import smooth_motion

    return smooth_motion


@pytest.fixture(scope="session")
def gentle_plan() -> Callable[..., Plan]:
    """Make (once) a certified plan of a smooth motion (`motions`)."""
    from tests.motions import gentle_plan

    return gentle_plan


@pytest.fixture(scope="session")
def samples() -> Callable[..., JointSamples]:
    """Make joint samples from rest to rest (`motions`)."""
    from tests.motions import curve

    return curve


@pytest.fixture(scope="session")
def measured() -> Path:
    """The folder of measured and published data, named by NOSPILL_DATA; tests that ask for it are skipped without."""
    from tests.measured import measured_data  # brings a benchmark along

    return measured_data()


_FEW_FRAMES = """(() => {
  const soon = window.requestAnimationFrame.bind(window);
  window.requestAnimationFrame = drawn => window.setTimeout(() => soon(drawn), 250);
  window.cancelAnimationFrame = number => window.clearTimeout(number);
})()"""
"""Pages draw four times a second instead of sixty: without a graphics card a picture takes as long as all the rest."""


def _with_few_frames(new_page: Callable[..., Any]) -> Callable[..., Any]:
    def opened(**options: Any) -> Any:
        page = new_page(**options)
        page.add_init_script(_FEW_FRAMES)
        return page

    return opened


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
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(found, "new_page", _with_few_frames(found.new_page))
            yield found
        found.close()
    gc.collect()  # what Playwright leaves in cycles goes here, and not in the midst of another test
