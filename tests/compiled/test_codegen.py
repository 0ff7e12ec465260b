"""Compiled functions: the same numbers as the virtual machine's, and never in the way when anything is wrong.

What may bring a process down, or needs an environment of its own, runs in a process of its own.
"""

from __future__ import annotations

import contextlib
import dataclasses
import io
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import casadi as ca
import pytest

from nospill.certification import traces
from nospill.compiled import codegen as compiled
from nospill.compiled.cache_folder import cache_folder
from nospill.compiled.kept import forget_functions
from nospill.compiled.small_libraries import small_library
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.kinds import object_kind, tray_kind
from nospill.laws.scene_parameters import structure_of
from nospill.laws.structure import Structure
from nospill.native import libraries
from nospill.planning.planner import plan
from nospill.robots.kinematics.forward import kinematics
from nospill.scene.scene import Scene
from nospill.transcription import stage_functions
from tests.compiling import assert_same
from tests.hasty import COMPILER, hasty_compiler
from tests.waiting import finished

pytestmark = pytest.mark.slow
needs_compiler = pytest.mark.skipif(shutil.which(COMPILER) is None, reason="no C compiler")

# A function of two outputs under a key, as any user of the cache has them; prints what it is served.
USER = """
import casadi as ca
from nospill.compiled import codegen as compiled

def build():
    x = ca.SX.sym("x", 3)
    return {"twice": ca.Function("twice", [x], [2 * x, ca.sin(x)])}, {"sizes": [3, 3]}

functions, data, is_compiled = compiled.functions("test", ("a", "structure"), build)
print(is_compiled, data, float(functions["twice"](1.5)[0][0]))
"""


@pytest.fixture(scope="module", autouse=True)
def as_users_have_it() -> Iterator[None]:
    """The user's compiler, and nothing compiled but where a test says so."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CC", COMPILER)
        patch.setenv("NOSPILL_COMPILE", "off")
        yield


@pytest.fixture
def forgotten() -> Iterator[None]:
    """Nothing kept from before, nothing left behind."""
    forget_functions()
    yield
    forget_functions()


def run(folder: Path | str, **environment: str) -> str:
    """What the user of the cache prints, in a process of its own."""
    process = start(folder, **environment)
    out, err = finished(process, "a user of the cache")
    assert (process.returncode, err) == (0, "")
    return out.strip()


def run_here(folder: Path) -> str:
    """The same in this process, which has forgotten what it was served before: of damage that ends no process."""
    printed = io.StringIO()
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(printed):
        patch.setenv("NOSPILL_COMPILE", "wait")
        patch.setenv("NOSPILL_CACHE", str(folder))
        forget_functions()
        exec(USER, {})
    forget_functions()
    return printed.getvalue().strip()


def start(folder: Path | str, **environment: str) -> subprocess.Popen[str]:
    settings = os.environ | {"NOSPILL_COMPILE": "wait", "NOSPILL_CACHE": str(folder)} | environment
    return subprocess.Popen(
        [sys.executable, "-c", USER], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=settings
    )


@pytest.fixture(scope="module")
def first_cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a cache that one process has filled."""
    folder = tmp_path_factory.mktemp("first")
    assert run(folder) == served(True)
    return folder


@pytest.fixture
def filled(first_cache: Path, tmp_path: Path) -> Path:
    """A copy of it."""
    return shutil.copytree(first_cache, tmp_path / "filled")


def served(is_compiled: bool) -> str:
    return f"{is_compiled} {{'sizes': [3, 3]}} 3.0"


def endings(folder: Path) -> list[str]:
    return sorted(path.suffix for path in folder.iterdir())


@pytest.fixture(scope="module")
def small(changed_scene: Callable[..., Scene]) -> Scene:
    """One solid on a level tray: little to compile."""
    scene = changed_scene("matrix-rigid", {"motion.tilt": "fixed", "planning.intervals": 20})
    return scene.changed({"cargo": scene.source["cargo"][:1]})


@needs_compiler
def test_machine_code_gives_the_same_values_and_the_same_plan(
    small: Scene,
    forgotten: None,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    structure = structure_of(small)
    monkeypatch.setenv("CC", str(hasty_compiler(tmp_path_factory.mktemp("compiler"), functions="-O0", solver="-O0")))
    slow = plan(small)
    plain = _functions(structure)
    forget_functions()
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path))
    monkeypatch.setenv("NOSPILL_COMPILE", "wait")
    assert stage_functions.stage_functions(structure).compiled
    fast = _functions(structure)
    assert fast.keys() == plain.keys() and len(fast) == 20
    for name, theirs in plain.items():
        assert_same(fast[name], theirs)
    again = plan(small)
    assert again.certificate.ok and slow.certificate.ok
    assert again.duration == pytest.approx(slow.duration, rel=1e-6)
    assert again.report.iterations == slow.report.iterations
    assert set(endings(tmp_path)) == {".json", ".so", ".sum"}


def _functions(structure: Structure) -> dict[str, ca.Function]:
    """Every function of a structure of one object."""
    stage = stage_functions.stage_functions(structure)
    kind = object_kind(structure, structure.objects[0])
    blocks = {"tray": stage.tray.block, "object": stage.objects[0].block, "end": stage.objects[0].end}
    found = {
        f"{block} {name}": value
        for block, content in blocks.items()
        for name, value in vars(content).items()
        if isinstance(value, ca.Function)
    }
    for point in (EvaluationPoint.JOINT, EvaluationPoint.CONTROL):
        found[point.value] = traces.tray_figures_function(tray_kind(structure), point)[0]
    found["contact"] = traces.object_figures_function(kind, EvaluationPoint.OBJECT)[0]
    return found | {f"arm {name}": value for name, value in kinematics(structure).sampled.items()}


@needs_compiler
def test_the_second_process_finds_what_the_first_has_left(tmp_path: Path) -> None:
    assert run(tmp_path) == served(True)
    assert endings(tmp_path) == [".json", ".so", ".sum"]
    times = [path.stat().st_mtime_ns for path in sorted(tmp_path.iterdir())]
    # Without a compiler too: what is there is used.
    assert run(tmp_path, CC="/nonexistent/cc") == served(True)
    assert [path.stat().st_mtime_ns for path in sorted(tmp_path.iterdir())] == times


@needs_compiler
@pytest.mark.parametrize("damage", [b"", b"not a library", "half"], ids=["empty", "text", "half"])
def test_a_damaged_library_is_built_anew(filled: Path, damage: bytes | str) -> None:
    library = next(filled.glob("*.so"))
    whole = library.read_bytes()
    library.unlink()
    library.write_bytes(whole[: len(whole) // 2] if isinstance(damage, str) else damage)
    assert run(filled) == served(True)
    assert library.read_bytes() == whole
    assert endings(filled) == [".json", ".so", ".sum"]


@needs_compiler
@pytest.mark.parametrize("damage", ["", "{", "[]", "{}", "null", '{"functions": 3, "data": 1}', "\x00\x01"])
def test_a_damaged_table_is_written_anew(filled: Path, damage: str) -> None:
    table = next(filled.glob("*.json"))
    whole = table.read_text()
    table.write_text(damage)
    assert run_here(filled) == served(True)
    assert table.read_text() == whole
    assert json.loads(whole)["data"] == {"sizes": [3, 3]}


@needs_compiler
def test_the_table_of_another_entry_is_not_taken(filled: Path) -> None:
    table = next(filled.glob("*.json"))
    own = table.read_text()
    table.write_text(own.replace(table.stem, "test-" + 32 * "0").replace("[3, 3]", "[4, 4]"))
    assert run_here(filled) == served(True)
    assert table.read_text() == own


@needs_compiler
def test_a_missing_table_or_library_is_made_anew(filled: Path) -> None:
    for ending in ("json", "so", "sum"):
        next(filled.glob(f"*.{ending}")).unlink()
        assert run_here(filled) == served(True)
        assert endings(filled) == [".json", ".so", ".sum"]


def test_switched_off_it_neither_writes_nor_reads(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    assert run(cache, NOSPILL_COMPILE="off") == served(False)
    assert not cache.exists()


@needs_compiler
def test_switched_off_what_is_there_is_not_used(filled: Path) -> None:
    assert run(filled, NOSPILL_COMPILE="off") == served(False)


def test_without_a_compiler_the_virtual_machine_serves(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    for mode in ("wait", "background"):
        assert run(cache, NOSPILL_COMPILE=mode, CC="/nonexistent/cc") == served(False)
    assert not cache.exists()


def test_a_compiler_that_fails_leaves_nothing_but_the_table(tmp_path: Path) -> None:
    broken = tmp_path / "cc"
    broken.write_text("#!/bin/sh\nexit 1\n")
    broken.chmod(0o755)
    cache = tmp_path / "cache"
    assert run(cache, CC=str(broken)) == served(False)
    assert endings(cache) == [".json"]
    # It may be tried again at once.
    assert run(cache, CC=str(broken)) == served(False)


@needs_compiler
def test_two_processes_at_once_do_not_disturb_each_other(tmp_path: Path) -> None:
    pair = [start(tmp_path), start(tmp_path)]
    for process in pair:
        out, err = finished(process, "a user of the cache")
        assert (process.returncode, err) == (0, "")
        assert out.strip() in (served(True), served(False))
    assert run(tmp_path) == served(True)
    assert endings(tmp_path) == [".json", ".so", ".sum"]


def test_a_cache_that_cannot_be_written_is_done_without(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("in the way")
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o500)
    assert run(file) == served(False)
    assert run(file / "cache") == served(False)
    # The superuser writes there all the same.
    assert run(closed) == served(os.access(closed, os.W_OK) and shutil.which(COMPILER) is not None)


@needs_compiler
def test_a_full_cache_that_cannot_be_written_is_read(filled: Path) -> None:
    filled.chmod(0o500)
    try:
        assert run(filled) == served(True)
    finally:
        filled.chmod(0o700)


@needs_compiler
def test_odd_places_are_no_obstacle(tmp_path: Path) -> None:
    odd = tmp_path / "a b'c$(d) ä"
    assert run(odd) == served(True)
    assert run(odd) == served(True)


@needs_compiler
@pytest.mark.parametrize("mode", [0o770, 0o702, 0o777], ids=oct)
def test_a_folder_that_others_may_write_to_is_not_used(filled: Path, mode: int) -> None:
    """Neither what is there nor for anything new: a library in it is code that anyone may have put there."""
    before = endings(filled)
    filled.chmod(mode)
    try:
        process = start(filled)
        out, err = finished(process, "a user of the cache")
        assert (process.returncode, out.strip()) == (0, served(False))
        assert err.count("RuntimeWarning") == 1 and str(filled) in err and "chmod go-w" in err
        assert endings(filled) == before
    finally:
        filled.chmod(0o700)
    assert run(filled) == served(True)


@needs_compiler
def test_a_folder_of_another_user_is_not_used(small: Scene, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path))
    monkeypatch.setenv("NOSPILL_COMPILE", "wait")
    structure, owner = structure_of(small), os.getuid()

    def build() -> tuple[compiled.Functions, None]:
        x = ca.SX.sym("x")
        return {"twice": ca.Function("twice", [x], [2 * x])}, None

    monkeypatch.setattr(os, "getuid", lambda: owner + 1)
    with pytest.warns(RuntimeWarning, match="belongs to another user"):
        assert not compiled.functions("test", structure, build)[2]
    assert not list(tmp_path.iterdir())
    monkeypatch.setattr(os, "getuid", lambda: owner)
    assert compiled.functions("test", structure, build)[2]
    monkeypatch.setattr(os, "getuid", lambda: owner + 1)
    with pytest.warns(RuntimeWarning, match="belongs to another user"):
        assert not compiled.functions("test", structure, build)[2]


@needs_compiler
def test_compilation_in_the_background_outlives_the_process(tmp_path: Path) -> None:
    assert run(tmp_path, NOSPILL_COMPILE="background") == served(False)
    for _ in range(600):
        if endings(tmp_path) == [".json", ".so", ".sum"]:
            break
        time.sleep(0.1)
    assert run(tmp_path, NOSPILL_COMPILE="background", CC="/nonexistent/cc") == served(True)


@needs_compiler
def test_no_compiler_runs_beside_a_plan(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path))
    monkeypatch.setenv("NOSPILL_COMPILE", "background")

    def build() -> tuple[compiled.Functions, None]:
        x = ca.SX.sym("x")
        return {"twice": ca.Function("twice", [x], [2 * x])}, None

    @compiled.compiles_afterwards
    def planned(error: Exception | None) -> None:
        before = sorted(tmp_path.iterdir())
        assert not compiled.functions("test", str(error), build)[2]
        assert sorted(tmp_path.iterdir()) == before
        if error is not None:
            raise error

    planned(None)
    assert there(tmp_path, 1)
    with pytest.raises(ValueError, match="no motion"):
        planned(ValueError("no motion"))
    assert there(tmp_path, 2)
    assert compiled.functions("test", "None", build)[2]


@needs_compiler
def test_a_small_file_is_compiled_meanwhile_unless_it_is_waited_for(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path))
    monkeypatch.setenv("NOSPILL_COMPILE", "background")
    text = ["int one(void) { return 1; }\n"]
    monkeypatch.setattr(libraries, "source", lambda _: text[-1])
    assert small_library("ldl", wait=False) is None
    assert there(tmp_path, 1)
    assert small_library("ldl", wait=False) is not None
    text.append("int one(void) { return 11; }\n")
    assert small_library("ldl", wait=True) is not None
    text.append("int one(void) { return 111; }\n")
    assert small_library("ldl", wait=False) is None
    assert small_library("ldl", wait=True) is not None  # which is being compiled


def there(folder: Path, count: int) -> bool:
    """Whether so many libraries are there before a minute is over, and no compiler is at work any more."""
    for _ in range(600):
        if len(list(folder.glob("*.so"))) == count and not list(folder.glob("*.lock")):
            return True
        time.sleep(0.1)
    return False


def test_the_folder_comes_from_the_environment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path / "own"))
    assert cache_folder() == tmp_path / "own"
    monkeypatch.delenv("NOSPILL_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder() == tmp_path / "nospill"
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert cache_folder() == Path.home() / ".cache" / "nospill"


def test_other_structures_and_kinds_have_other_entries(
    small: Scene, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path))
    structure = structure_of(small)
    others = [dataclasses.replace(structure, tilt_free=True), dataclasses.replace(structure, fidelity="full")]
    places = [compiled._places(kind, item) for kind in ("stage", "replay") for item in (structure, *others)]
    assert len({library for library, _ in places}) == len({table for _, table in places}) == 6
    assert compiled._places("stage", structure) == places[0]
