"""A progress line on stderr and a Ctrl-C that no solver swallows."""

from __future__ import annotations

import signal
import threading
from typing import TYPE_CHECKING, Any, Self

from nospill.cli.reporting import say

if TYPE_CHECKING:
    from nospill.planning.planner import PlanningProgress


class ProgressLine:
    """Where planning stands, on stderr: one moving line on a terminal, elsewhere one line for each phase.

    A solver takes the KeyboardInterrupt raised inside it for a failed step and goes on, so Ctrl-C is kept here too and
    raised again by the next report.
    """

    def __init__(self) -> None:
        from rich.console import Console

        console = Console(stderr=True)
        self._status = console.status("") if console.is_terminal else None
        self._last = ""
        self._stopped = False
        self._usual: Any = None

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            self._usual = signal.signal(signal.SIGINT, self._stop)
        if self._status is not None:
            self._status.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self._usual is not None:
            signal.signal(signal.SIGINT, self._usual)
        if self._status is not None:
            self._status.stop()
        if self._stopped and kind is not None:  # whatever the libraries made of it
            raise KeyboardInterrupt

    def _stop(self, *_: object) -> None:
        self._stopped = True
        raise KeyboardInterrupt

    def show(self, report: PlanningProgress) -> None:
        """Say what the planner reports; called once an iteration."""
        details = [
            f"iteration {report.iteration}" if report.iteration is not None else "",
            f"{report.duration_s:.3f} s" if report.duration_s is not None else "",
            f"violation {report.violation:.1e}" if report.violation is not None else "",
        ]
        phase = f"{report.phase} ({report.stage})" if report.stage else report.phase
        self.say(phase, ", ".join(filter(None, details)))

    def say(self, phase: str, details: str = "") -> None:
        """Say a phase and, where the line can move, its details.

        Raises:
            KeyboardInterrupt: Ctrl-C came since the last report and was swallowed.
        """
        if self._stopped:
            raise KeyboardInterrupt
        if self._status is not None:
            self._status.update(f"{phase} {details}")
        elif phase != self._last:
            say(f"{phase} ...")
        self._last = phase
