"""Python inside a call of a solver: progress at every iteration, and Ctrl-C."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import Any

import casadi as ca
import numpy as np

from nospill.transcription.problem import Problem
from nospill.transcription.solvers.options import IterationCallback
from nospill.transcription.solvers.solution import violation


class _Watcher(ca.Callback):
    """Turns the solver's iterations into progress calls; an error raised there stops it and is kept in `raised`."""

    def __init__(self, problem: Problem, progress: IterationCallback) -> None:
        ca.Callback.__init__(self)
        self._problem, self._progress, self._iteration = problem, progress, 0
        self.raised: BaseException | None = None
        transcription = problem.transcription
        self._sizes = {
            "x": transcription.variables,
            "f": 1,
            "g": len(transcription.lower),
            "lam_x": transcription.variables,
            "lam_g": len(transcription.lower),
            "lam_p": len(problem.parameters),
        }
        self.construct("watcher", {})

    def get_n_in(self) -> int:
        return ca.nlpsol_n_out()

    def get_n_out(self) -> int:
        return 1

    def get_name_in(self, i: int) -> str:
        return ca.nlpsol_out(i)

    def get_name_out(self, i: int) -> str:
        return "ret"

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        return ca.Sparsity.dense(self._sizes[ca.nlpsol_out(i)], 1)

    def has_eval_buffer(self) -> bool:
        return True

    def eval_buffer(self, arg: Sequence[memoryview], res: Sequence[memoryview]) -> int:
        # The numbers as they lie in memory: CasADi's matrices would copy all of them first, at every iteration.
        try:
            x, _, g = (np.frombuffer(part, dtype=float) for part in arg[:3])
            self._progress(self._iteration, self._problem.duration(x), violation(self._problem, g))
            self._iteration += 1
        except BaseException as error:
            # CasADi would print all its numbers; the solver is stopped instead, and `watched` raises the error again.
            self.raised = error
        np.frombuffer(res[0], dtype=float)[:] = self.raised is not None
        return 0


@contextmanager
def watched(problem: Problem, progress: IterationCallback | None) -> Iterator[dict[str, Any]]:
    """Settings of `casadi.nlpsol` under which it calls `progress` at every iteration; none where that is None.

    An error raised by `progress` stops the solver and is raised again at the end of the context.
    """
    if progress is None:
        yield {}
        return
    watcher = _Watcher(problem, progress)
    yield {"iteration_callback": watcher}
    if watcher.raised is not None:
        raise watcher.raised


@contextmanager
def interruptible() -> Iterator[None]:
    """Raise KeyboardInterrupt after a call into CasADi during which one came.

    CasADi stops at it and returns an answer, of which Python makes a SystemError, since an error is set. Outside the
    main thread, where no signal arrives, this does nothing.
    """
    came = False

    def note(number: int, frame: FrameType | None) -> None:
        nonlocal came
        came = True
        raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, note)
    try:
        yield
    except SystemError:
        if not came:
            raise
    finally:
        signal.signal(signal.SIGINT, before)
    if came:
        raise KeyboardInterrupt
