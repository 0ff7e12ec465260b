"""Clock, counters and progress of one call of the planner: nothing but the time left decides what it does next."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from nospill.plans.records import PlanningReport, Starts
from nospill.transcription.solvers import Solution


@dataclass(frozen=True, slots=True)
class PlanningProgress:
    """Where planning stands.

    Attributes:
        phase: its name.
        iteration: of the solver, while it runs.
        duration_s: current end time, s, while the solver runs.
        violation: largest scaled violation, while the solver runs.
        stage: what is built or solved: "coarse", "fine" or "tighten"; empty otherwise.
        holds_from: of a motion just judged over a range of speeds, the part of the planned one from which on it holds.
    """

    phase: str
    iteration: int | None = None
    duration_s: float | None = None
    violation: float | None = None
    stage: str = ""
    holds_from: float | None = None


OnProgress = Callable[[PlanningProgress], None]


@dataclass(slots=True)
class Log:
    """What one call of the planner has spent.

    Attributes:
        progress: called with where planning stands.
        max_time: for the whole call, s.
        began: time of the clock at its start, s.
        phases: time by phase, s.
        solutions: of all solves.
        rounds: of tightening and constraint generation.
        starts: end time of the answer from each start, s; None where there was none.
        not_warm: why the motion was not planned from the earlier one that was given; empty where it was, or none was.
    """

    progress: OnProgress | None
    max_time: float
    began: float = field(default_factory=time.perf_counter)
    phases: dict[str, float] = field(default_factory=dict)
    solutions: list[Solution] = field(default_factory=list)
    rounds: int = 0
    starts: list[float | None] = field(default_factory=list)
    not_warm: str = ""

    @property
    def time_left(self) -> float:
        """Rest of the time for the search, s; negative when it is up."""
        return self.began + self.max_time - time.perf_counter()

    @property
    def out_of_time(self) -> bool:
        """Whether the time for the search is up."""
        return self.time_left < 0.0

    @contextmanager
    def phase(self, name: str, stage: str = "") -> Iterator[None]:
        """Account the time spent inside to a phase."""
        if self.progress is not None:
            self.progress(PlanningProgress(name, stage=stage))
        start = time.perf_counter()
        try:
            yield
        finally:
            self.phases[name] = self.phases.get(name, 0.0) + time.perf_counter() - start

    def iteration(self, stage: str, iteration: int, duration: float, violation: float) -> None:
        """Pass an iteration of the solver on."""
        if self.progress is not None:
            self.progress(PlanningProgress("solve", iteration, duration, violation, stage))

    def judged(self, holds_from: float | None) -> None:
        """Pass on how far down a range of speeds a motion holds, where one was asked for and it does."""
        if self.progress is not None and holds_from is not None:
            self.progress(PlanningProgress("certify", holds_from=holds_from))

    def passage_begins(self) -> None:
        """What the starts before led to is on another passage, and does not compare."""
        self.starts = [None] * len(self.starts)

    def report(self, last: str, **found: Any) -> PlanningReport:
        """What was spent.

        Args:
            last: status of the last solve.
            found: the other fields of the report, about the motion.
        """
        return PlanningReport(
            plan_time=time.perf_counter() - self.began,
            solve_time=sum(solution.solve_time_s for solution in self.solutions),
            iterations=sum(solution.iterations for solution in self.solutions),
            rounds=self.rounds,
            starts=Starts.of(self.starts),
            phases=self.phases,
            solver_status=last,
            ran_out=self.out_of_time,
            not_warm=self.not_warm,
            linear_solvers=tuple(solution.linear_solver for solution in self.solutions),
            **found,
        )
