"""One thread for the products of matrices: those here are small, and OpenBLAS has its threads wait busily.

Beside other work such a wait takes several times as long as the product. A number that the user has set stays.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

SETTINGS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables that say how many threads the libraries have."""


def one_thread_by_default() -> None:
    """Have a NumPy that is not loaded yet, and child processes, begin with one thread."""
    if not any(name in os.environ for name in SETTINGS):
        os.environ[SETTINGS[0]] = "1"


class _Limit:
    """One thread while anybody needs it.

    The number is the process's: of callers in threads of their own the first sets it and the last puts it back.
    """

    def __init__(self) -> None:
        self._lock, self._inside, self._held = threading.Lock(), 0, ExitStack()

    def enter(self) -> None:
        with self._lock:
            if self._inside == 0:
                self._held.enter_context(_controller().limit(limits=1, user_api="blas"))
            self._inside += 1

    def leave(self) -> None:
        with self._lock:
            self._inside -= 1
            if self._inside == 0:
                self._held.close()


_LIMIT = _Limit()


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """One thread inside, as many as before outside, by whatever threads it is entered and left."""
    if any(name in os.environ for name in SETTINGS):
        yield
        return
    _LIMIT.enter()
    try:
        yield
    finally:
        _LIMIT.leave()


@lru_cache(maxsize=1)
def _controller() -> ThreadpoolController:
    import numpy  # noqa: F401  # loaded before the controller looks for its library; the command line sets it before that
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
