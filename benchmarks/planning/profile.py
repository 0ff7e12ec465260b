"""Where the time of a cold plan with the whole physics goes: phases, and in the solves functions and linear algebra.

    python -m benchmarks.planning.profile matrix-liquid-tilt mixed-tray

IPOPT's own count of what its function calls took is asked for; the rest of a solve is the linear solver, the line
search and CasADi's setting up of the solver.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import casadi as ca

from benchmarks.planning import scenes
from nospill.planning.planner import plan


class Recorder:
    """Stands in for `casadi.nlpsol` and keeps the statistics of every solve."""

    def __init__(self) -> None:
        """Nothing recorded yet."""
        self.create = ca.nlpsol
        self.functions = 0.0
        self.setting_up = 0.0
        self.running = 0.0
        self.solves: list[tuple[int, int, int, float]] = []

    def __call__(self, name: str, solver: str, problem: dict[str, Any], options: dict[str, Any]) -> Recorder:
        """Make the solver with its clock on."""
        began = time.perf_counter()
        self._solver = self.create(name, solver, problem, options | {"record_time": True})
        self.setting_up += time.perf_counter() - began
        self._size = (problem["x"].numel(), problem["g"].numel())
        return _Recorded(self, self._solver)  # type: ignore[return-value]


class _Recorded:
    """A solver whose evaluations are recorded; otherwise the solver itself."""

    def __init__(self, recorder: Recorder, solver: Any) -> None:
        self._recorder, self._solver, self._size = recorder, solver, recorder._size

    def buffer(self) -> tuple[Any, Callable[[], None]]:
        """The solver's buffer, and its evaluation with a clock about it."""
        buffer, evaluate_now = self._solver.buffer()

        def timed() -> None:
            began = time.perf_counter()
            evaluate_now()
            seconds = time.perf_counter() - began
            stats, recorder = buffer.stats(), self._recorder
            recorder.running += seconds
            recorder.functions += sum(
                value for key, value in stats.items() if key.startswith("t_wall_nlp_") or key == "t_wall_callback_fun"
            )
            recorder.solves.append((*self._size, int(stats["iter_count"]), seconds))

        return buffer, timed

    def __getattr__(self, name: str) -> Any:
        return getattr(self._solver, name)


def profile(name: str) -> None:
    """Plan once and print."""
    scene = scenes.whole_example(name)
    recorder = Recorder()
    ca.nlpsol = recorder  # type: ignore[assignment]
    began = time.perf_counter()
    try:
        found = plan(scene)
    finally:
        ca.nlpsol = recorder.create
    whole = time.perf_counter() - began
    phases = found.report.phases
    algebra = recorder.running - recorder.functions
    parts = {phase: seconds for phase, seconds in phases.items() if phase != "solve"}
    parts |= {
        "solver set-up": recorder.setting_up,
        "problem functions": recorder.functions,
        "IPOPT and its linear solver": algebra,
        "rest": whole - sum(parts.values()) - recorder.setting_up - recorder.running,
    }
    print(f"\n{name}: {whole:.3f} s. Solves:")
    for variables, constraints, iterations, seconds in recorder.solves:
        print(f"{variables} variables, {constraints} constraints: {iterations} iterations, {seconds:.3f} s")
    print()
    print("| part | s | share |\n|---|---:|---:|")
    for part, seconds in parts.items():
        print(f"| {part} | {seconds:.3f} | {100 * seconds / whole:.0f} % |")


if __name__ == "__main__":
    for example in sys.argv[1:] or ("matrix-liquid-tilt", "mixed-tray"):
        profile(example)
