"""One measurement in a process of its own; prints a line of JSON. `run.py` starts these.

    python -m benchmarks.planning.tasks baseline liquid
    python -m benchmarks.planning.tasks cold matrix-liquid [--intervals 200] [--modes 20]
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
    return asdict(found) | {"seconds": found.build_time + found.solve_time}


def cold(scene: Scene) -> dict[str, Any]:
    """The first plan of a process, certificate included."""
    began = time.perf_counter()
    found = plan(scene)
    return _outcome(found, time.perf_counter() - began)


def warm(name: str) -> dict[str, Any]:
    """Plans again after each change, as the planner of the unchanged scene does; then once more, everything built."""
    cell = Planner()
    base = cell.plan(scenes.example(name))
    changes = {change: scenes.changed(name, change) for change in (*scenes.CHANGES, *scenes.LARGER_CHANGES)}
    passes = []
    for _ in range(2):
        figures = {}
        for change, scene in changes.items():
            planner = copy.copy(cell)  # with what it remembers
            began = time.perf_counter()
            found = planner.plan(scene)
            figures[change] = _outcome(found, time.perf_counter() - began)
        passes.append(figures)
    return {"duration": base.duration, "first": passes[0], "again": passes[1]}


def level_toppra(name: str) -> dict[str, Any]:
    """TOPP-RA on the level tray with rigid objects; `missing` where toppra is not installed."""
    try:
        from benchmarks.planning.toppra_waiter import solve
    except ImportError as error:
        return {"missing": str(error)}
    scene = scenes.example(name)
    solve(scene)  # its own imports and first calls
    began = time.perf_counter()
    duration = solve(scene)
    return {"seconds": time.perf_counter() - began, "duration": duration}


def _outcome(found: Plan, seconds: float) -> dict[str, Any]:
    report = found.report
    return {
        "seconds": seconds,
        "duration": found.duration,
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
        return warm(what)
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
    return cold(scenes.example(what, intervals=arguments.intervals, modes=arguments.modes))


def main() -> None:
    """Measure what the command line asks for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("task", choices=("baseline", "cold", "cups", "different", "wells", "unseen", "warm", "toppra"))
    parser.add_argument("what")
    parser.add_argument("--intervals", type=int)
    parser.add_argument("--modes", type=int, default=1)
    found = _measured(parser.parse_args())
    # Linux counts ru_maxrss in KiB, macOS in bytes.
    unit = 1 if sys.platform == "darwin" else 1024
    found["peak_memory_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6
    print(json.dumps(found))


if __name__ == "__main__":
    main()
