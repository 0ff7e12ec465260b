"""A computation in a forked copy of this process, while the process goes on."""

from __future__ import annotations

import os
import pickle
import signal
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Generic, TypeVar

from nospill.core.batches import thread_count

Result = TypeVar("Result")


class Beside(Generic[Result]):
    """A computation that runs in a process of its own."""

    def __init__(self, process: int, answer: int) -> None:
        """Of a child process and the end of a pipe from which its pickled answer can be read."""
        self._process: int | None = process
        self._answer = answer

    def result(self) -> Result | None:
        """Wait for the result; None if there is none: the computation failed, or it was stopped or asked before."""
        if self._process is None:
            return None
        with open(self._answer, "rb", closefd=False) as file:
            data = file.read()
        self.stop()
        # A copy that died in the midst of writing leaves a part.
        with suppress(pickle.UnpicklingError, EOFError):
            return pickle.loads(data)  # type: ignore[no-any-return]
        return None

    def stop(self) -> None:
        """End the computation, whether it is done or not; nothing is left of it."""
        if self._process is None:
            return
        process, self._process = self._process, None
        os.close(self._answer)
        with suppress(ProcessLookupError):
            os.kill(process, signal.SIGKILL)
        with suppress(ChildProcessError):
            os.waitpid(process, 0)


@contextmanager
def beside(work: Callable[[], Result] | None) -> Iterator[Beside[Result] | None]:
    """Begin a computation in a copy of this process, made by fork(); it is stopped at the end of the context.

    A fork copies all that was imported, built and loaded in a few milliseconds, but of the threads only the one that
    calls: none of the others may hold a lock that `work` needs. That is for the owner of the process to know.

    Args:
        work: what to compute; its result can be pickled. None for nothing.

    Returns:
        The computation; None without `work`, where the system is not Linux (elsewhere forking harms system libraries)
        and where only one thread may work at once (`batches.thread_count`).
    """
    found = None
    if work is not None and sys.platform == "linux" and thread_count() > 1:
        with suppress(OSError):  # no room for another process: then there is none
            found = _started(work)
    try:
        yield found
    finally:
        if found is not None:
            found.stop()


def _started(work: Callable[[], Result]) -> Beside[Result]:
    answer, written = os.pipe()
    try:
        with warnings.catch_warnings():
            # Python 3.12 warns where there are threads; those of BLAS are always there, and know about forks.
            warnings.simplefilter("ignore", DeprecationWarning)
            process = os.fork()
    except OSError:
        os.close(answer)
        os.close(written)
        raise
    if process == 0:
        os.close(answer)  # else a copy whose reader has died would wait for itself
        _work_and_end(work, written)
    os.close(written)
    return Beside(process, answer)


def _work_and_end(work: Callable[[], object], written: int) -> None:
    """In the copy: hand the result over and end at once, without what the original does at its end."""
    code = 1
    try:
        with open(written, "wb") as file:
            pickle.dump(work(), file)
        code = 0
    except BaseException:  # whoever waits sees that there is no result
        pass
    finally:
        os._exit(code)
