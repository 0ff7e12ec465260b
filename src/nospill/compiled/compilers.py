"""The C compiler: where it is, and how libraries are compiled at once or in the background."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from nospill.compiled import compile_worker
from nospill.compiled.compile_worker import LONGEST_COMPILATION, compile_library
from nospill.core.batches import thread_count

Places = tuple[Path, Path, Path]
"""Of a library, its lock and the folder with its source."""
_PATIENCE = 60.0
"""s"""


def compiler_path() -> str | None:
    """The C compiler, None where there is none."""
    return shutil.which(os.environ.get("CC", "cc"))


def take(lock: Path) -> bool:
    """Whether this process may compile this entry: one at a time, unless the last one died long ago."""
    try:
        lock.touch(exist_ok=False)
    except FileExistsError:
        if time.time() - lock.stat().st_mtime < LONGEST_COMPILATION:
            return False
        lock.touch()
    return True


def await_release(lock: Path) -> None:
    """Return when another process has compiled a small entry, or a minute is over: it may have died."""
    began = time.monotonic()
    while lock.exists() and time.monotonic() - began < _PATIENCE:
        time.sleep(0.05)


def compile_libraries(libraries: Sequence[Places], command: Sequence[str], *, wait: bool) -> None:
    """Compile libraries whose locks are taken.

    Args:
        libraries: of each its places.
        command: compiler and flags.
        wait: until they are there; otherwise a process of its own compiles them, `NOSPILL_THREADS` at a time.
    """
    if wait:
        for places in libraries:
            compile_library(*places, command)
        return
    words = [str(thread_count()), str(len(libraries)), *(str(place) for places in libraries for place in places)]
    with suppress(OSError):
        subprocess.run(
            [sys.executable, "-I", compile_worker.__file__, *words, *command],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            check=False,
        )
