"""Planning in parallel to the studio: a planner in a thread of its own, where it stands, and how it is stopped.

CasADi lets other threads run while it solves, and IPOPT locks its linear solver, so sessions plan at the same time;
more than there are cores would only hold each other up, so the others wait, and say so.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

from nospill.errors import NospillError
from nospill.planning.planner import Planner, PlanningProgress
from nospill.plans.plan import Plan
from nospill.scene.scene import Scene

Stage = Literal["idle", "waiting", "planning", "stopping", "planned", "failed", "stopped"]
BUSY: tuple[Stage, ...] = ("waiting", "planning", "stopping")

_LOOK_EVERY = 0.05
"""s between two looks of one who waits at whether it was stopped."""


@dataclass(frozen=True, slots=True)
class PlanningState:
    """Where planning stands.

    Attributes:
        stage: in a word.
        seconds: since the start of planning.
        phase: of the planner; with iteration, duration in s and largest scaled violation while it solves.
        plan: the answer of stage "planned".
        message: why there is none.
    """

    stage: Stage = "idle"
    seconds: float = 0.0
    phase: str = ""
    iteration: int | None = None
    duration_s: float | None = None
    violation: float | None = None
    plan: Plan | None = None
    message: str = ""


class PlanningStoppedError(Exception):
    """Raised inside the planner by the user's stop; it never leaves this module."""


class PlanningSlots:
    """How many plans may be made at once in this process."""

    def __init__(self, count: int | None = None) -> None:
        """As many as there are cores, when not given."""
        self._free = threading.Semaphore(count or os.cpu_count() or 1)

    def take(self, stopped: threading.Event, *, waiting: Callable[[], None]) -> bool:
        """Take a seat, or say that it is waited for and wait; False where it was stopped before."""
        if self._free.acquire(blocking=False):
            return True
        waiting()
        while not stopped.is_set():
            if self._free.acquire(timeout=_LOOK_EVERY):
                return True
        return False

    def leave(self) -> None:
        """Give the seat back."""
        self._free.release()


class PlanningDesk:
    """One session's planner: plans one scene at a time, each from the answer before where that helps."""

    def __init__(self, seats: PlanningSlots, *, report: Callable[[], None]) -> None:
        """Nothing is planned yet.

        Args:
            seats: shared by all sessions.
            report: called after every change of `state`, from the thread that made it.
        """
        self._seats, self._report = seats, report
        self._planner = Planner()
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._began = 0.0
        self.state = PlanningState()

    @property
    def busy(self) -> bool:
        """Whether a plan is being made."""
        return self.state.stage in BUSY

    def start(self, scene: Scene, *, warm: bool = True) -> bool:
        """Plan a scene in the background; False where one is being planned already.

        Args:
            scene: the task.
            warm: start from the last answer, where it is of the same structure.
        """
        with self._lock:
            if self.busy:
                return False
            if not warm:
                self._planner = Planner()
            self._stop = threading.Event()
            self._began = time.monotonic()
            self.state = PlanningState("planning", phase="start")
            self._thread = threading.Thread(target=self._run, args=(scene, self._stop), daemon=True)
        self._report()
        self._thread.start()
        return True

    def stop(self) -> None:
        """Stop at the planner's next report, which comes with every iteration."""
        with self._lock:
            if not self.busy:
                return
            self._stop.set()
            self.state = replace(self.state, stage="stopping")
        self._report()

    def wait(self, timeout: float | None = None) -> None:
        """Wait until the thread has ended, at most so many s."""
        if self._thread is not None:
            self._thread.join(timeout)

    def _run(self, scene: Scene, stopped: threading.Event) -> None:
        if not self._seats.take(stopped, waiting=lambda: self._say(PlanningState("waiting"))):
            self._say(PlanningState("stopped", message="Stopped before it began."))
            return
        try:
            self._say(PlanningState("planning", phase="start"))
            plan = self._planner.plan(scene, progress=lambda progress: self._heard(progress, stopped))
            ended = PlanningState("planned", plan=plan)
        except PlanningStoppedError:
            ended = PlanningState("stopped", message="Stopped; the last plan is kept.")
        except NospillError as error:
            ended = PlanningState("failed", message=" ".join(str(error).split()))
        except Exception as error:  # the session must not hang in "planning" for a fault of ours
            ended = PlanningState("failed", message=f"Internal error: {type(error).__name__}: {error}")
        finally:
            self._seats.leave()
        self._say(ended)

    def _heard(self, progress: PlanningProgress, stopped: threading.Event) -> None:
        if stopped.is_set():
            raise PlanningStoppedError
        kept = self.state if progress.iteration is None else PlanningState()
        self._say(
            PlanningState(
                "planning",
                phase=progress.phase,
                iteration=progress.iteration,
                duration_s=progress.duration_s if progress.duration_s is not None else kept.duration_s,
                violation=progress.violation if progress.violation is not None else kept.violation,
            )
        )

    def _say(self, state: PlanningState) -> None:
        with self._lock:
            self.state = replace(state, seconds=time.monotonic() - self._began)
        self._report()
