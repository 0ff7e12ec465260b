"""Functions as machine code, kept on the disk by content.

An entry holds the functions of one part of a scene (see `kinds`). Its key is a hash of what the functions are for, the
kind, the source of the laws and the problem and of the versions of CasADi and of the file format; so a changed law
never meets old code. An entry is a shared library, its own hash and a
table of plain data, which names the key; the library is put in place last. Half a library would end the process that
loads it, so its hash is looked at first. Where there is no compiler nothing happens and the virtual machine serves.

A library is executed as it is, and its hash is no seal: who can write the one can write the other. A folder that
belongs to another user, or to which group or others may write, is therefore neither read nor written; a warning says
so, and the virtual machine serves.

NOSPILL_COMPILE = background (default) | wait | off; NOSPILL_CACHE = folder, else the user's cache folder. In the
background functions are compiled when a plan is there (`compiles_afterwards`) or the process ends: beside a plan the
compilers made its virtual machine twice as slow.
"""

from __future__ import annotations

import atexit
import hashlib
import json
import os
import stat
import tempfile
import warnings
from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache, wraps
from pathlib import Path
from types import MappingProxyType
from typing import Any, ParamSpec, TypeVar

import casadi as ca

from nospill.compiled import simd_source
from nospill.compiled.compilers import Places, await_release, compile_libraries, compiler_path, take

Functions = dict[str, Any]
"""CasADi functions by name."""
Shared = Mapping[str, Collection[int]]
"""By the name of a function the places of its inputs that are the same for all columns; -1 is the last."""
LAST = (-1,)
"""As functions for `batches.evaluate` have it."""

_P = ParamSpec("_P")
_T = TypeVar("_T")

_SOURCES = ("core", "compiled", "robots", "scene", "laws", "judge", "transcription", "motion")
"""Packages whose source is part of the key: those of which compiled functions are made."""

_FORMAT = "5"
_FLAGS = ("-O1", "-ffp-contract=off", "-shared", "-fPIC")
_FLAGS_OF_SOURCES = ("-O3", "-std=c99", "-shared", "-fPIC")


def functions(
    kind: str,
    structure: Hashable,
    build: Callable[[], tuple[Functions, Any]],
    *,
    of_columns: Shared = MappingProxyType({}),
) -> tuple[Functions, Any, bool]:
    """The functions of a kind and structure, compiled if they are on the disk.

    Otherwise they are built for CasADi's virtual machine and, where there is a compiler, compiled later for the next
    time (or at once, if NOSPILL_COMPILE=wait).

    Args:
        kind: what the functions are for; part of the key, and the beginning of the names of the files.
        structure: what they were built from, a kind (see `kinds`); part of the key.
        build: makes the functions and the plain data (anything json can hold) that is kept with them.
        of_columns: those that are evaluated on many columns (`batches.over_columns`).

    Returns:
        Functions, data, and whether they are machine code. Machine code of those in `of_columns` takes four columns at
        once (`simd_source`).
    """
    ready = _load(kind, structure)
    if ready is None:
        made, data = build()
        compiler = compiler_path()
        if _mode() != "off" and compiler is not None:
            _waiting.append(_Entry(*_places(kind, structure), compiler, made, data, of_columns))
        if _mode() == "wait":
            _compile_waiting(wait=True)
            ready = _load(kind, structure)
        if ready is None:
            return made, data, False
    return *ready, True


def compiled_library(kind: str, sources: Sequence[Path], *, wait: bool) -> Path | None:
    """C files of the package as a shared library, compiled at once where it is not on the disk; for small files.

    Args:
        kind: what it is for, first part of its name.
        sources: the files, compiled as one.
        wait: until it is there, as with NOSPILL_COMPILE=wait; otherwise it is compiled in the background.

    Returns:
        The library, or None where it cannot be had, or not yet.
    """
    if _mode() == "off":
        return None
    text = b"\n".join(source.read_bytes() for source in sources)
    digest = hashlib.sha256("\0".join((_FORMAT, *_FLAGS_OF_SOURCES)).encode() + text)
    library = cache_folder() / f"{kind}-{digest.hexdigest()[:32]}.so"
    with suppress(OSError):
        library.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        if not is_private(library.parent):
            return None
        if _is_whole(library):
            return library
        lock, compiler = library.with_suffix(".lock"), compiler_path()
        if compiler is not None and take(lock):
            folder = Path(tempfile.mkdtemp(dir=library.parent, prefix="build-"))
            (folder / "made.c").write_bytes(text)
            compile_libraries([(library, lock, folder)], (compiler, *_FLAGS_OF_SOURCES), wait=wait or _mode() == "wait")
        elif compiler is not None and wait:
            await_release(lock)
        if _is_whole(library):
            return library
    return None


def _is_whole(library: Path) -> bool:
    """Whether a library is there with its own hash beside it."""
    try:
        stored = library.with_suffix(".sum").read_text(encoding="utf-8")
        return stored == hashlib.sha256(library.read_bytes()).hexdigest()
    except (OSError, ValueError):
        return False


def _load(kind: str, structure: Hashable) -> tuple[Functions, Any] | None:
    if _mode() == "off":
        return None
    library, table_file = _places(kind, structure)
    if not is_private(library.parent):
        return None
    try:
        if not library.is_file():
            return None
        table = json.loads(table_file.read_text(encoding="utf-8"))
        if table["key"] != library.stem or not _is_whole(library):
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
        functions: for the virtual machine.
        data: plain data that is kept with them.
        of_columns: those that are evaluated on many columns.
    """

    library: Path
    table_file: Path
    compiler: str
    functions: Functions
    data: Any
    of_columns: Shared


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
                _generate(entry.functions, entry.of_columns, Path(folder) / "made.c")
                by_compiler.setdefault(entry.compiler, []).append((entry.library, lock, Path(folder)))
    for compiler, places in by_compiler.items():
        compile_libraries(places, (compiler, *_flags()), wait=wait)


def cache_folder() -> Path:
    """Where compiled functions are kept."""
    own = os.environ.get("NOSPILL_CACHE")
    if own:
        return Path(own)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "nospill"


def is_private(folder: Path) -> bool:
    """Whether a folder is there and only this user can put libraries into it; warns where others can."""
    try:
        found = folder.stat()
    except OSError:
        return False
    if found.st_uid == os.getuid() and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return True
    warnings.warn(
        f"NOSPILL_CACHE = {folder}: compiled functions are not used, planning is slower: the folder belongs to another "
        "user or others may write to it; make it yours alone (chmod go-w) or name another one",
        RuntimeWarning,
        stacklevel=1,
    )
    return False


def compiles() -> bool:
    """Whether functions are compiled here: not switched off, and a compiler and a folder for them are at hand."""
    return _mode() != "off" and compiler_path() is not None


def _mode() -> str:
    mode = os.environ.get("NOSPILL_COMPILE", "background") if os.name == "posix" else "off"
    return mode if mode in ("wait", "off") else "background"


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
    for file in sorted(file for room in _SOURCES for file in (package / room).rglob("*.py")):
        digest.update(file.relative_to(package).as_posix().encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()


def _flags() -> tuple[str, ...]:
    return (*_FLAGS, *simd_source.flags())


def _generate(made: Functions, of_columns: Shared, place: Path) -> None:
    generator = ca.CodeGenerator(place.name, {"with_header": False, "main": False})
    of_four = [simd_source.HEADER]
    for name, function in made.items():
        if name in of_columns and simd_source.is_possible(function):
            shared = {place % function.n_in() for place in of_columns[name]}
            of_four.append(simd_source.source(function, shared))
        else:
            generator.add(function)
    place.write_text(generator.dump() + "\n".join(of_four), encoding="utf-8")


def _write_table(table: dict[str, Any], path: Path) -> None:
    temporary = path.with_suffix(f".{os.getpid()}.tmp")
    temporary.write_text(json.dumps(table), encoding="utf-8")
    temporary.replace(path)
