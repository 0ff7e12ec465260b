"""A progress line on stderr and a Ctrl-C that no solver swallows."""

from __future__ import annotations

import signal
import threading
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Self

from nospill.cli.tables import say

if TYPE_CHECKING:
    from rich.progress import Progress

    from nospill.planning.planner import PlanningProgress

PLANNING_STEPS = (
    "load the optimiser",
    "joint paths",
    "search on the coarse grid",
    "solve on the fine grid",
    "certificate",
    "files and figures",
)
"""Steps of the command `plan`."""
LOADING, JOINT_PATHS, COARSE, FINE, CERTIFICATE, FILES = PLANNING_STEPS

_STEP_OF = {
    "base yaw": JOINT_PATHS,
    "yaw of the ends": JOINT_PATHS,
    "way": JOINT_PATHS,
    "ends": JOINT_PATHS,
    "kinematics": JOINT_PATHS,
    "export": CERTIFICATE,
    "certify": CERTIFICATE,
    "approach": CERTIFICATE,
}
"""Step of a phase of the planner that has one stage."""


class ProgressLine:
    """Where a command stands, on stderr: one moving line on a terminal, elsewhere one line for each phase.

    A solver takes the KeyboardInterrupt raised inside it for a failed step and goes on, so Ctrl-C is kept here too and
    raised again by the next report.
    """

    def __init__(self, steps: Sequence[str] = ()) -> None:
        """Nothing is shown yet; phases that are among the steps are numbered."""
        from rich.console import Console

        console = Console(stderr=True)
        self._line: Progress | None = None
        if console.is_terminal:
            from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

            self._line = Progress(
                SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn(), console=console, transient=True
            )
        self._task = self._line.add_task("", total=None) if self._line is not None else None
        self._steps = steps
        self._said: set[str] = set()
        self._holds_from: float | None = None
        self._stopped = False
        self._usual: Any = None

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            self._usual = signal.signal(signal.SIGINT, self._stop)
        if self._line is not None:
            self._line.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self._usual is not None:
            signal.signal(signal.SIGINT, self._usual)
        if self._line is not None:
            self._line.stop()
        if self._stopped and kind is not None:  # whatever the libraries made of it
            raise KeyboardInterrupt

    def _stop(self, *_: object) -> None:
        self._stopped = True
        raise KeyboardInterrupt

    def show(self, report: PlanningProgress) -> None:
        """Say what the planner reports; called once an iteration."""
        self._holds_from = report.holds_from or self._holds_from
        step = _STEP_OF.get(report.phase) or (COARSE if report.stage == "coarse" else FINE)
        details = [
            "tighten" if report.stage == "tighten" else "",
            f"iteration {report.iteration}" if report.iteration is not None else "",
            f"motion {report.duration_s:.3f} s" if report.duration_s is not None else "",
            f"last one holds from {100 * self._holds_from:.0f} % of the speed on" if self._holds_from else "",
        ]
        self.say(step, ", ".join(filter(None, details)))

    def drawn(self, done: int, of: int) -> None:
        """Say how many figures are drawn."""
        self.say(FILES, f"figures drawn {done}/{of}")

    def say(self, phase: str, details: str = "") -> None:
        """Say a phase and, where the line can move, its details.

        Raises:
            KeyboardInterrupt: Ctrl-C came since the last report and was swallowed.
        """
        if self._stopped:
            raise KeyboardInterrupt
        step = f"{self._steps.index(phase) + 1} of {len(self._steps)}: " if phase in self._steps else ""
        if self._line is not None and self._task is not None:
            self._line.update(self._task, description=f"{step}{phase}{', ' if details else ''}{details}")
        elif phase not in self._said:
            say(f"{step}{phase} ...")
        self._said.add(phase)
