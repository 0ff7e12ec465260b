"""What the cache of compiled functions holds: listed, counted, removed."""

from __future__ import annotations

import json
import re
import shutil
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from nospill.compiled.cache_folder import cache_folder
from nospill.compiled.codegen import source_digest
from nospill.compiled.compile_worker import LONGEST_COMPILATION

_ENTRY = re.compile(r"(?P<kind>[a-z-]+)-[0-9a-f]{32}")
_ENDINGS = (".so", ".sum", ".json", ".lock")


@dataclass(frozen=True, slots=True)
class CacheEntry:
    """Compiled functions of one kind.

    Attributes:
        kind: what they are for.
        size: of their files, bytes.
        current: whether this version of nospill uses them.
    """

    kind: str
    size: int
    current: bool


def cache_entries() -> tuple[CacheEntry, ...]:
    """Every entry whose library is there."""
    found = []
    for library in sorted(_files(".so")):
        files = [library.with_suffix(ending) for ending in _ENDINGS]
        size = sum(file.stat().st_size for file in files if file.is_file())
        found.append(CacheEntry(_kind(library), size, _is_current(library)))
    return tuple(found)


def current_files() -> list[Path]:
    """Files of the entries that this version of nospill uses, their locks apart."""
    found = []
    for library in sorted(_files(".so")):
        if _is_current(library):
            files = [library.with_suffix(ending) for ending in (".sum", ".json", ".so")]
            found += [file for file in files if file.is_file()]
    return found


def compiling() -> int:
    """How many entries are being compiled, by this process or another."""
    return sum(1 for lock in _files(".lock") if _is_held(lock))


def clear_cache() -> int:
    """Remove every entry, but those that are being compiled; the number of files that were removed."""
    held = {lock.stem for lock in _files(".lock") if _is_held(lock)}
    removed = 0
    for ending in _ENDINGS:
        for file in list(_files(ending)):
            if file.stem not in held:
                file.unlink(missing_ok=True)
                removed += 1
    if not held:
        for folder in cache_folder().glob("build-*"):
            shutil.rmtree(folder, ignore_errors=True)
    return removed


def _files(ending: str) -> Iterator[Path]:
    for file in cache_folder().glob(f"*{ending}"):
        if _ENTRY.fullmatch(file.stem):
            yield file


def _kind(file: Path) -> str:
    found = _ENTRY.fullmatch(file.stem)
    assert found is not None
    return found["kind"]


def _is_current(library: Path) -> bool:
    """Whether the source is the one it was made of; what has no table is named by its own source."""
    table = library.with_suffix(".json")
    if not table.exists():
        return True
    with suppress(OSError, ValueError, AttributeError):
        return bool(json.loads(table.read_text(encoding="utf-8")).get("source") == source_digest())
    return False


def _is_held(lock: Path) -> bool:
    """Whether a compiler is at work there: one that ended without a word leaves a lock behind."""
    with suppress(OSError):
        return time.time() - lock.stat().st_mtime < LONGEST_COMPILATION
    return False
