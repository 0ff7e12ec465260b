"""One thread for the products of matrices: those here are small, and OpenBLAS has its threads wait busily.

Beside other work such a wait takes several times as long as the product. A number that the user has set stays.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from importlib import import_module
from typing import Any

SETTINGS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")
"""Variables that OpenBLAS reads when it is loaded."""
_NAMES = ("scipy_openblas_{}_num_threads64_", "scipy_openblas_{}_num_threads", "openblas_{}_num_threads")
"""In NumPy's own wheels since 2.0, in those with 32-bit indices, and in a build against a library of the system."""


def one_thread_by_default() -> None:
    """Have a NumPy that is not loaded yet, and child processes, begin with one thread."""
    if not any(name in os.environ for name in SETTINGS):
        os.environ[SETTINGS[0]] = "1"


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """One thread inside, as many as before outside; nothing where NumPy has another library, as Apple's."""
    found = None if any(name in os.environ for name in SETTINGS) else _functions()
    if found is None:
        yield
        return
    get, put = found
    before = int(get())
    put(1)
    try:
        yield
    finally:
        put(before)


@lru_cache(maxsize=1)
def _functions() -> tuple[Any, Any] | None:
    """How the number of threads of NumPy's library is read and set; None where it has none."""
    try:  # an extension module gives its own symbols and those of what it is linked with
        module = import_module("numpy._core._multiarray_umath")
        library = ctypes.CDLL(str(module.__file__))
    except (ImportError, OSError):
        return None
    for name in _NAMES:
        if hasattr(library, name.format("get")):
            return getattr(library, name.format("get")), getattr(library, name.format("set"))
    return None
