"""Compiling the usual parts, several at a time."""

from __future__ import annotations

import time
from collections.abc import Callable

from nospill.compiled.cache_folder import cache_folder, compiles, is_private
from nospill.compiled.codegen import start_compilers
from nospill.compiled.compilers import compiler_path
from nospill.compiled.entries import compiling
from nospill.core.batches import thread_count
from nospill.errors import ScenarioError
from nospill.warmup.usual import Part, usual_parts

_LOOK = 0.05
"""Time between two looks at the compilers, s."""


def warm_cache(parts: tuple[Part, ...] | None = None, *, progress: Callable[[str, str], None]) -> None:
    """Have parts compiled that are not yet, `NOSPILL_THREADS` of them at a time.

    What is compiled stays when it is interrupted; compilers at work end by themselves.

    Args:
        parts: which; the usual ones where None.
        progress: called with what is being done and how far it is.

    Raises:
        ScenarioError: nothing is compiled here: it is switched off, or there is no compiler or no folder.
    """
    _require_compiler()
    chosen = tuple(usual_parts()) if parts is None else parts
    for index, part in enumerate(chosen):
        progress(f"{index + 1} of {len(chosen)}", part.label)
        while compiling() >= thread_count():
            time.sleep(_LOOK)
        part.make()
        start_compilers()
    while compiling():
        progress(f"{len(chosen)} of {len(chosen)}", "waiting for the compilers")
        time.sleep(_LOOK)


def _require_compiler() -> None:
    if compiler_path() is None:
        raise ScenarioError("nospill cache --warm: there is no C compiler; install one, or name it by CC")
    if not compiles():
        raise ScenarioError("nospill cache --warm: NOSPILL_COMPILE=off switches compilation off; unset it")
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    except OSError as error:
        raise ScenarioError(
            f"nospill cache --warm: the folder {folder} cannot be made ({error.strerror}); name another one "
            "by NOSPILL_CACHE"
        ) from error
    if not is_private(folder):
        raise ScenarioError(
            f"nospill cache --warm: others may write to {folder}; make it yours alone (chmod go-w) or name another one "
            "by NOSPILL_CACHE"
        )
