"""Where the time of a cold plan goes: phases, and inside the solves functions against linear algebra.

    python -m benchmarks.planning.profile matrix-liquid matrix-rigid matrix-liquid-tilt

IPOPT's own count of what its function calls took is asked for; the rest of a solve is the linear solver, the line
search and CasADi's setting up of the solver.
"""

from __future__ import annotations

import sys
import time
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
    def __init__(self, recorder: Recorder, solver: Any) -> None:
        self._recorder, self._solver, self._size = recorder, solver, recorder._size

    def __call__(self, **arguments: Any) -> Any:
        began = time.perf_counter()
        result = self._solver(**arguments)
        seconds = time.perf_counter() - began
        self._recorder.running += seconds
        stats = self._solver.stats()
        self._recorder.functions += sum(
            value for key, value in stats.items() if key.startswith("t_wall_nlp_") or key == "t_wall_callback_fun"
        )
        self._recorder.solves.append((*self._size, int(stats["iter_count"]), seconds))
        return result

    def stats(self) -> Any:
        return self._solver.stats()


def profile(name: str) -> None:
    """Plan once and print."""
    scene = scenes.example(name)
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
    for example in sys.argv[1:] or ("matrix-liquid", "matrix-rigid", "matrix-liquid-tilt"):
        profile(example)
