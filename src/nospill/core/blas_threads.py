"""One thread for the products of matrices: those here are small, and OpenBLAS has its threads wait busily.

Beside other work such a wait takes several times as long as the product. CasADi brings an OpenBLAS of its own, by which
IPOPT adds its vectors up; threadpoolctl does not know its name. A number that the user has set stays.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import lru_cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

SETTINGS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables that say how many threads the libraries have."""
_LOADERS = ("casadi", "scipy.linalg")
"""Modules with which libraries come, beside NumPy."""


def one_thread_by_default() -> None:
    """Have a NumPy that is not loaded yet, and child processes, begin with one thread."""
    if not any(name in os.environ for name in SETTINGS):
        os.environ[SETTINGS[0]] = "1"


class _Limit:
    """One thread while anybody needs it.

    The number is the process's: of callers in threads of their own the first sets it and the last puts it back.
    Libraries that are loaded in between keep theirs.
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


def _controller() -> ThreadpoolController:
    return _controller_of(tuple(name in sys.modules for name in _LOADERS))


@lru_cache(maxsize=8)
def _controller_of(loaded: tuple[bool, ...]) -> ThreadpoolController:
    """Of the libraries that the loaded modules bring; it finds only what is there when it is made."""
    import numpy  # noqa: F401  # loaded before the controller looks for its library; the command line sets it before that
    from threadpoolctl import LibController, ThreadpoolController, register

    class CasadiBlas(LibController):
        """The OpenBLAS of CasADi's wheels."""

        user_api = "blas"
        internal_api = "casadi_openblas"
        filename_prefixes = ("libcasadi-tp-openblas",)
        check_symbols = ("openblas_get_num_threads", "openblas_set_num_threads")

        def get_num_threads(self) -> Any:
            return self.dynlib.openblas_get_num_threads()

        def set_num_threads(self, num_threads: int) -> None:
            self.dynlib.openblas_set_num_threads(num_threads)

        def get_version(self) -> None:
            return None

    if dict(zip(_LOADERS, loaded, strict=True))["casadi"]:
        import casadi

        casadi.has_nlpsol("ipopt")  # looks for the solver by loading it, with its OpenBLAS; loaded twice, CasADi warns
    register(CasadiBlas)
    return ThreadpoolController()
