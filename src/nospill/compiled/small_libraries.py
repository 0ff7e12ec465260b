"""The libraries in C: prebuilt in a wheel, or compiled at their first use and kept as compiled functions are."""

from __future__ import annotations

import tempfile
from contextlib import suppress
from pathlib import Path

from nospill.compiled.cache_folder import cache_folder, is_private, is_whole, mode
from nospill.compiled.compilers import await_release, compile_libraries, compiler_path, take
from nospill.native import libraries


def small_library(name: str, *, wait: bool) -> Path | None:
    """A compiled library of `native.libraries.LIBRARIES`.

    Args:
        name: of the library.
        wait: until it is compiled, as with NOSPILL_COMPILE=wait; otherwise that is done in the background.

    Returns:
        The library, or None where it cannot be had, or not yet.
    """
    file_name = libraries.file_name(name)
    prebuilt = libraries.PREBUILT / file_name
    if prebuilt.is_file():
        return prebuilt
    if mode() == "off":
        return None
    library = cache_folder() / file_name
    with suppress(OSError):
        library.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        if not is_private(library.parent):
            return None
        if is_whole(library):
            return library
        lock, compiler = library.with_suffix(".lock"), compiler_path()
        if compiler is not None and take(lock):
            folder = Path(tempfile.mkdtemp(dir=library.parent, prefix="build-"))
            (folder / "made.c").write_text(libraries.source(name), encoding="utf-8")
            compile_libraries(
                [(library, lock, folder)], (compiler, *libraries.flags(name)), wait=wait or mode() == "wait"
            )
        elif compiler is not None and wait:
            await_release(lock)
        if is_whole(library):
            return library
    return None
