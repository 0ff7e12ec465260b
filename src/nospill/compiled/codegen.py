"""Functions as machine code, kept on the disk by content.

An entry holds the functions of one part of a scene (see `kinds`). Its key is a hash of what the functions are for, the
kind, the source of the laws and the problem and of the versions of CasADi and of the file format; so a changed law
never meets old code. An entry is a shared library, its own hash and a table of plain data, which names the key; the
library is put in place last (see `cache_folder` for who may).

What is not compiled is interpreted on many columns at once where the interpreter can be had (see `interpreter`), and by
CasADi's virtual machine otherwise. In the background functions are compiled when a plan is there
(`compiles_afterwards`) or the process ends: while a plan is made the compilers made it twice as slow.
"""

from __future__ import annotations

import atexit
import hashlib
import json
import os
import pickle
import tempfile
from collections.abc import Callable, Collection, Hashable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache, wraps
from pathlib import Path
from types import MappingProxyType
from typing import Any, ParamSpec, TypeVar

import casadi as ca

from nospill.compiled import simd_source
from nospill.compiled.cache_folder import cache_folder, is_private, is_whole, mode
from nospill.compiled.compile_worker import TAPES
from nospill.compiled.compilers import Places, compile_libraries, compiler_path, take
from nospill.compiled.interpreter import interpreted
from nospill.compiled.small_libraries import small_library
from nospill.compiled.tape import Tape
from nospill.compiled.tape_reading import read_tape

Functions = dict[str, Any]
"""CasADi functions by name."""
Shared = Mapping[str, Collection[int]]
"""By the name of a function the places of its inputs that are the same for all columns; -1 is the last."""
LAST = (-1,)
"""As functions for `batches.evaluate` have it."""

_P = ParamSpec("_P")
_T = TypeVar("_T")

_SOURCES = (
    "core",
    "paths",
    "native",
    "compiled",
    "robots",
    "scene",
    "potential_flow",
    "laws",
    "certification",
    "transcription",
    "motion",
)
"""Packages whose source is part of the key: those of which compiled functions are made."""

_FORMAT = "5"
_FLAGS = ("-O1", "-fexpensive-optimizations", "-ffp-contract=off", "-shared", "-fPIC")
"""-fexpensive-optimizations has GCC clear the upper halves of the vector registers before it calls sin or fmin, which
-O1 alone does not: a function with few other operations then takes three to five times as long.
"""
_LONG = 3000
"""Instructions of a part from which on its functions wait for the interpreter, the first time on a machine: 0.3 s."""


def functions(
    kind: str,
    structure: Hashable,
    build: Callable[[], tuple[Functions, Any]],
    *,
    of_columns: Shared = MappingProxyType({}),
    steps: int = 1,
) -> tuple[Functions, Any, bool]:
    """The functions of a kind and structure, compiled if they are on the disk.

    Otherwise they are built to be interpreted and, where there is a compiler, compiled later for the next time (or at
    once, if NOSPILL_COMPILE=wait).

    Args:
        kind: what the functions are for; part of the key, and the beginning of the names of the files.
        structure: what they were built from, a kind (see `kinds`); part of the key.
        build: makes the functions and the plain data (anything json can hold) that is kept with them.
        of_columns: those that are evaluated on many columns (`batches.over_columns`).
        steps: how often those run, one time after the other (`Tape`); once in CasADi's virtual machine.

    Returns:
        Functions, data, and whether they are machine code. Those in `of_columns` take four columns at once as machine
        code (`simd_source`), sixteen where they are interpreted.
    """
    ready = _load(kind, structure)
    if ready is None:
        made, data = build()
        compiler = compiler_path() if mode() != "off" else None
        if compiler is None and not (of_columns and small_library("interpreter", wait=False)):
            return made, data, False  # nobody takes a tape
        tapes = _tapes(made, of_columns, steps)
        if compiler is not None:
            _waiting.append(_Entry(*_places(kind, structure), compiler, made, data, tapes))
        if mode() == "wait":
            _compile_waiting(wait=True)
            ready = _load(kind, structure)
        if ready is None:
            return made | _interpret(tapes), data, False
    return *ready, True


def _tapes(made: Functions, of_columns: Shared, steps: int) -> dict[str, Tape]:
    """Of the functions that are evaluated on many columns, as far as they have one."""
    found = {name: read_tape(made[name], shared, steps) for name, shared in of_columns.items() if name in made}
    return {name: tape for name, tape in found.items() if tape is not None}


def _interpret(tapes: Mapping[str, Tape]) -> Functions:
    """The functions interpreted on many columns; none where the interpreter cannot be had, or not yet."""
    library = small_library("interpreter", wait=sum(tape.count for tape in tapes.values()) >= _LONG) if tapes else None
    if library is None:
        return {}
    try:
        return {name: interpreted(tape, library) for name, tape in tapes.items()}
    except (OSError, RuntimeError):  # no folder whose files may be executed
        return {}


def _load(kind: str, structure: Hashable) -> tuple[Functions, Any] | None:
    if mode() == "off":
        return None
    library, table_file = _places(kind, structure)
    if not is_private(library.parent):
        return None
    try:
        if not library.is_file():
            return None
        table = json.loads(table_file.read_text(encoding="utf-8"))
        if table["key"] != library.stem or not is_whole(library):
            raise ValueError("the files of the entry do not belong together")
        return {name: ca.external(name, str(library)) for name in table["functions"]}, table["data"]
    except (OSError, ValueError, KeyError, TypeError, RuntimeError):
        # A damaged entry is as good as none; it is built anew.
        with suppress(OSError):
            library.unlink()
        return None


@dataclass(frozen=True, slots=True)
class _Entry:
    """Functions that wait to be compiled.

    Attributes:
        library: where they will be.
        table_file: where the data is.
        compiler: that makes them.
        functions: as they were built.
        data: plain data that is kept with them.
        tapes: of those that are evaluated on many columns.
    """

    library: Path
    table_file: Path
    compiler: str
    functions: Functions
    data: Any
    tapes: Mapping[str, Tape]


_waiting: list[_Entry] = []


def compiles_afterwards(function: Callable[_P, _T]) -> Callable[_P, _T]:
    """The function, after which compilers are started for what it has used, however it ends."""

    @wraps(function)
    def called(*arguments: _P.args, **options: _P.kwargs) -> _T:
        try:
            return function(*arguments, **options)
        finally:
            start_compilers()

    return called


@atexit.register
def start_compilers() -> None:
    """Have compiled in the background what waits for it."""
    _compile_waiting(wait=False)


def _compile_waiting(*, wait: bool) -> None:
    by_compiler: dict[str, list[Places]] = {}
    while _waiting:
        entry = _waiting.pop()
        with suppress(OSError):
            entry.library.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            lock = entry.library.with_suffix(".lock")
            if is_private(entry.library.parent) and not entry.library.is_file() and take(lock):
                folder = tempfile.mkdtemp(dir=entry.library.parent, prefix="build-")
                table = {"key": entry.library.stem, "source": source_digest(), "functions": list(entry.functions)}
                _write_table(table | {"data": entry.data}, entry.table_file)
                _generate(entry.functions, entry.tapes, Path(folder))
                by_compiler.setdefault(entry.compiler, []).append((entry.library, lock, Path(folder)))
    for compiler, places in by_compiler.items():
        compile_libraries(places, (compiler, *_flags()), wait=wait)


def _places(kind: str, structure: Hashable) -> tuple[Path, Path]:
    digest = hashlib.sha256()
    for part in (_FORMAT, kind, source_digest(), ca.CasadiMeta.version(), " ".join(_flags()), repr(structure)):
        digest.update(part.encode())
        digest.update(b"\0")
    stem = cache_folder() / f"{kind}-{digest.hexdigest()[:32]}"
    return stem.with_suffix(".so"), stem.with_suffix(".json")


@lru_cache(maxsize=1)
def source_digest() -> str:
    """Of the source that decides what functions are built."""
    digest = hashlib.sha256()
    package = Path(__file__).parents[1]
    for file in sorted(file for folder in _SOURCES for file in (package / folder).rglob("*.py")):
        digest.update(file.relative_to(package).as_posix().encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()


def _flags() -> tuple[str, ...]:
    return (*_FLAGS, *simd_source.flags())


def _generate(made: Functions, tapes: Mapping[str, Tape], folder: Path) -> None:
    """What the worker compiles: C source, and tapes of which it writes C."""
    generator = ca.CodeGenerator("made.c", {"with_header": False, "main": False})
    for name, function in made.items():
        if name not in tapes:
            generator.add(function)
    (folder / "made.c").write_text(generator.dump(), encoding="utf-8")
    (folder / TAPES).write_bytes(pickle.dumps(list(tapes.values())))


def _write_table(table: dict[str, Any], path: Path) -> None:
    temporary = path.with_suffix(f".{os.getpid()}.tmp")
    temporary.write_text(json.dumps(table), encoding="utf-8")
    temporary.replace(path)
