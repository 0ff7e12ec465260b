"""One measurement in a process of its own; prints a line of JSON. `run.py` starts these.

    python -m benchmarks.planning.tasks baseline liquid
    python -m benchmarks.planning.tasks whole mixed-tray
    python -m benchmarks.planning.tasks whole-warm mixed-tray
    python -m benchmarks.planning.tasks cold matrix-liquid [--intervals 200]
    python -m benchmarks.planning.tasks cups 8
    python -m benchmarks.planning.tasks different 64
    python -m benchmarks.planning.tasks wells 132
    python -m benchmarks.planning.tasks unseen "three cups"
    python -m benchmarks.planning.tasks warm matrix-liquid
    python -m benchmarks.planning.tasks toppra matrix-rigid

Times are of the work alone: the interpreter's start, imports and the reading of the scenario come before the clock.
"""

from __future__ import annotations

import argparse
import copy
import json
import resource
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

import scipy.interpolate  # noqa: F401 - the package imports it at its first use, which would be within the time taken

from benchmarks.planning import scenes
from nospill.planning.planner import Planner, plan
from nospill.plans.plan import Plan
from nospill.scene.scene import Scene


def baseline(name: str) -> dict[str, Any]:
    """The published transcription: `liquid` or `rigid`."""
    from benchmarks.planning.baseline import SOLVE

    found = SOLVE[name]()
    return asdict(found) | {"seconds": found.build_time + found.solve_time, "processor": found.processor_time}


def cold(scene: Scene) -> dict[str, Any]:
    """The first plan of a process, certificate included."""
    return _timed(lambda: plan(scene))


def warm(scene: Scene, changes: Mapping[str, Scene]) -> dict[str, Any]:
    """Plans again after each change, as the planner of the unchanged scene does, the first time in its process."""
    cell = Planner()
    base = cell.plan(scene)
    # each by a planner with what that one remembers
    figures = {change: _timed(lambda other=other: copy.copy(cell).plan(other)) for change, other in changes.items()}
    return {"duration": base.duration, "changes": figures}


def level_toppra(name: str) -> dict[str, Any]:
    """TOPP-RA on the level tray with rigid objects; `missing` where toppra is not installed."""
    try:
        from benchmarks.planning.toppra_waiter import solve
    except ImportError as error:
        return {"missing": str(error)}
    scene = scenes.example(name)
    solve(scene)  # its own imports and first calls
    began = time.perf_counter(), time.process_time()
    duration = solve(scene)
    return _since(*began) | {"duration": duration}


def _since(clock: float, processor: float) -> dict[str, float]:
    return {"seconds": time.perf_counter() - clock, "processor": time.process_time() - processor}


def _timed(planned: Callable[[], Plan]) -> dict[str, Any]:
    began = time.perf_counter(), time.process_time()
    found = planned()
    times, report = _since(*began), found.report
    return times | {
        "duration": found.duration,
        "warm": report.warm,
        "certified": found.certificate.ok,
        "iterations": report.iterations,
        "rounds": report.rounds,
        "solve_seconds": report.solve_time,
        "phases": report.phases,
    }


def _measured(arguments: argparse.Namespace) -> dict[str, Any]:
    what = arguments.what
    if arguments.task == "baseline":
        return baseline(what)
    if arguments.task == "warm":
        changes = (*scenes.CHANGES, *scenes.LARGER_CHANGES)
        return warm(scenes.example(what), {change: scenes.changed(what, change) for change in changes})
    if arguments.task == "whole":
        return cold(scenes.whole_example(what))
    if arguments.task == "whole-warm":
        changed = {change: scenes.whole_changed(what, change) for change in scenes.CHANGES}
        return warm(scenes.whole_example(what), changed)
    if arguments.task == "toppra":
        return level_toppra(what)
    if arguments.task == "cups":
        return cold(scenes.tray_of_cups(int(what)))
    if arguments.task == "different":
        return cold(scenes.different_cups(int(what)))
    if arguments.task == "wells":
        return cold(scenes.wells_and_vials(int(what)))
    if arguments.task == "unseen":
        return cold(scenes.unseen(what))
    return cold(scenes.example(what, intervals=arguments.intervals))


def main() -> None:
    """Measure what the command line asks for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    tasks = ("baseline", "cold", "cups", "different", "wells", "unseen", "warm", "whole", "whole-warm", "toppra")
    parser.add_argument("task", choices=tasks)
    parser.add_argument("what")
    parser.add_argument("--intervals", type=int)
    found = _measured(parser.parse_args())
    # Linux counts ru_maxrss in KiB, macOS in bytes.
    unit = 1 if sys.platform == "darwin" else 1024
    found["peak_memory_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6
    print(json.dumps(found))


if __name__ == "__main__":
    main()
