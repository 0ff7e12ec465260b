"""Stage functions as machine code, kept on the disk by content.

The key of an entry is a hash of the structure, of the source of the laws and the problem and of the versions of
CasADi and of the file format; so a changed law never meets old code. An entry is a shared library and the stage's
shape beside it; the library is put in place last. Where there is no compiler nothing happens and the virtual machine
serves.

NOSPILL_COMPILE = background (default) | wait | off; NOSPILL_CACHE = folder, else the user's cache folder.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import tempfile
import time
from contextlib import suppress
from dataclasses import asdict, fields
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from nospill.numbers import Structure
from nospill.ocp.stage import Block

if TYPE_CHECKING:
    from nospill.ocp.stage_functions import StageShape

FUNCTIONS = ("values", "slopes", "costs", "curvatures", "end_values", "end_slopes", "end_curvatures")

_ABOVE = {
    "__init__",
    "certificate",
    "cli",
    "compare",
    "cup_file",
    "examples",
    "export",
    "files",
    "motion_file",
    "planner",
    "plans",
    "plots",
    "replay",
    "scenario",
    "simulate",
    "solvers",
    "units",
}
"""Modules whose source is left out of the key: the layer rules keep the problem from importing them."""

_FORMAT = "1"
_LONGEST_COMPILATION = 600.0
_FLAGS = ("-O1", "-shared", "-fPIC")


def load(structure: Structure) -> tuple[StageShape, dict[str, Any]] | None:
    """The kept functions of a structure, or None where there are none (or compiling is switched off)."""
    if _mode() == "off":
        return None
    library, shape_file = _places(structure)
    try:
        if not library.is_file():
            return None
        shape = _read_shape(shape_file)
        return shape, {name: ca.external(name, str(library)) for name in FUNCTIONS}
    except (OSError, ValueError, KeyError, TypeError, RuntimeError):
        # A damaged entry is as good as none; it is built anew.
        with suppress(OSError):
            library.unlink()
        return None


def waits() -> bool:
    """Whether `start` returns only when the compiler has finished."""
    return _mode() == "wait"


def start(structure: Structure, shape: StageShape, functions: dict[str, Any]) -> None:
    """Start the compiler for a structure, in the background unless NOSPILL_COMPILE=wait; failures are silent."""
    mode, compiler = _mode(), shutil.which(os.environ.get("CC", "cc"))
    if mode == "off" or compiler is None:
        return
    library, shape_file = _places(structure)
    with suppress(OSError):
        library.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        lock = library.parent / "compiling"
        if not _take(lock):
            return
        source = Path(tempfile.mkdtemp(dir=library.parent, prefix="build-"))
        _write_shape(shape, shape_file)
        _generate(functions, source)
        # One shell does the rest, so that it goes on when this process has ended: compile, put in place, clean up.
        script = (
            'trap \'rm -rf "$3" "$4"\' EXIT; nice -n 10 "$1" $5 -o "$3/stage.so" "$3/stage.c" -lm >/dev/null 2>&1 && '
            'mv "$3/stage.so" "$2"'
        )
        arguments = [compiler, str(library), str(source), str(lock), " ".join(_FLAGS)]
        with suppress(subprocess.TimeoutExpired):
            subprocess.run(
                ["sh", "-c", script if mode == "wait" else f"({script}) &", "sh", *arguments],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
                timeout=_LONGEST_COMPILATION,
                check=False,
            )


def cache_folder() -> Path:
    """Where compiled functions are kept."""
    own = os.environ.get("NOSPILL_CACHE")
    if own:
        return Path(own)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "nospill"


def _mode() -> str:
    mode = os.environ.get("NOSPILL_COMPILE", "background")
    return mode if mode in ("wait", "off") else "background"


def _places(structure: Structure) -> tuple[Path, Path]:
    digest = hashlib.sha256()
    for part in (_FORMAT, _source_digest(), ca.CasadiMeta.version(), " ".join(_FLAGS), repr(structure)):
        digest.update(part.encode())
    stem = cache_folder() / digest.hexdigest()[:32]
    return stem.with_suffix(".so"), stem.with_suffix(".json")


@lru_cache(maxsize=1)
def _source_digest() -> str:
    digest = hashlib.sha256()
    package = Path(__file__).parents[1]
    for file in sorted(package.rglob("*.py")):
        if file.relative_to(package).parts[0].removesuffix(".py") in _ABOVE:
            continue
        digest.update(file.relative_to(package).as_posix().encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()


def _take(lock: Path) -> bool:
    """Whether this process may compile: one at a time per cache, unless the last one died long ago."""
    try:
        lock.touch(exist_ok=False)
    except FileExistsError:
        if time.time() - lock.stat().st_mtime < _LONGEST_COMPILATION:
            return False
        lock.touch()
    return True


def _generate(functions: dict[str, Any], folder: Path) -> None:
    generator = ca.CodeGenerator("stage.c", {"with_header": False, "main": False})
    for name in FUNCTIONS:
        generator.add(functions[name])
    generator.generate(f"{folder}/")


def _write_shape(shape: StageShape, path: Path) -> None:
    table = {field.name: _plain(getattr(shape, field.name)) for field in fields(shape)}
    temporary = path.with_suffix(f".{os.getpid()}.tmp")
    temporary.write_text(json.dumps(table), encoding="utf-8")
    temporary.replace(path)


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return asdict(value) if isinstance(value, Block) else value


def _read_shape(path: Path) -> StageShape:
    from nospill.ocp.stage_functions import StageShape

    table = json.loads(path.read_text(encoding="utf-8"))
    for name in ("lower", "upper", "end_lower", "end_upper"):
        table[name] = np.array(table[name], dtype=float)
    for name in ("blocks", "end_blocks"):
        table[name] = tuple(Block(**block) for block in table[name])
    for name in ("jacobian", "hessian", "end_jacobian", "end_hessian"):
        table[name] = tuple(np.array(part, dtype=int) for part in table[name])
    return StageShape(**table)
