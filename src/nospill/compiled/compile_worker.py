"""Compile generated C code and put the libraries in their places: a program of its own, which outlives its parent.

It is run by its file name in an isolated interpreter (see `codegen`), so it imports nothing but the standard library
and what writes C of tapes:

    python -I compile_worker.py AT_ONCE COUNT [LIBRARY LOCK FOLDER]... COMPILER FLAG...

of COUNT libraries, AT_ONCE at a time. FOLDER holds made.c, and the tapes of which C is written here and not beside a
plan, which it would make 0.2 s longer; it is removed at the end, as LOCK is. A library comes last, after its hash
beside it: whoever finds a library finds all that belongs to it.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import shutil
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

LONGEST_COMPILATION = 600.0
"""s; a compiler that takes longer is stopped."""

TAPES = "tapes.pickle"
"""The file of the tapes, in the folder of an entry; to read it takes the same trust as to run made.c."""

_NICENESS = 19


def compile_library(library: Path, lock: Path, folder: Path, command: Sequence[str]) -> None:
    """Compile made.c in `folder`, and the tapes there, by `command` (compiler and flags) into `library`.

    Nothing is left where that fails.
    """
    made, digest = folder / "made.so", folder / "made.sum"
    try:
        with suppress(OSError, subprocess.SubprocessError):
            if (folder / TAPES).is_file():
                _append_tapes(folder)
            subprocess.run(
                [*command, "-o", str(made), str(folder / "made.c"), "-lm"],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                timeout=LONGEST_COMPILATION,
                check=True,
            )
            digest.write_text(hashlib.sha256(made.read_bytes()).hexdigest(), encoding="utf-8")
            digest.replace(library.with_suffix(".sum"))
            made.replace(library)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        lock.unlink(missing_ok=True)


def _append_tapes(folder: Path) -> None:
    from nospill.compiled import simd_source

    tapes = pickle.loads((folder / TAPES).read_bytes())
    with (folder / "made.c").open("a", encoding="utf-8") as file:
        file.write("\n".join([simd_source.HEADER, *(simd_source.source(tape) for tape in tapes)]))


def _main(at_once: str, count: str, *words: str) -> None:
    if os.fork():
        return  # the parent goes on at once; the copy belongs to nobody and ends when it is done
    from concurrent.futures import ThreadPoolExecutor  # which no planning process needs

    os.nice(_NICENESS)
    behind = 3 * int(count)
    libraries, locks, folders = ([Path(word) for word in words[first:behind:3]] for first in range(3))
    with ThreadPoolExecutor(int(at_once)) as pool:
        for library, lock, folder in zip(libraries, locks, folders, strict=True):
            pool.submit(compile_library, library, lock, folder, words[behind:])


if __name__ == "__main__":
    sys.path.append(str(Path(__file__).parents[2]))
    _main(*sys.argv[1:])
