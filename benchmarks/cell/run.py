"""A loop in a cell, planned cold and from the motion before; prints a line of JSON for each plan, and a table.

    python -m benchmarks.cell.run goals poles [--seeds 0 1] [--count 10] [--only warm]

Every series is a process of its own. In it the cell as it stands is planned first; its time is not counted, and the
functions it needs are at hand for the others. *Cold* series search for every plan.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from typing import Any

import numpy as np
import scipy.interpolate  # noqa: F401 - the package imports it at its first use, which would be within the time taken

from benchmarks.cell.scenes import cell, moved_goals, moved_poles
from nospill.errors import NospillError
from nospill.planning.planner import Planner, plan
from nospill.scene.scene import Scene

_SERIES = {"goals": moved_goals, "poles": moved_poles}


def series(what: str, how: str, seed: int, count: int) -> list[dict[str, Any]]:
    """Figures of the plans of one series."""
    planner = Planner()
    first = planner.plan(cell())
    print(json.dumps({"first": first.duration, "processor": first.report.plan_time}), file=sys.stderr)
    return [_figures(planner, scene, how) for scene in _SERIES[what](seed, count)]


def _figures(planner: Planner, scene: Scene, how: str) -> dict[str, Any]:
    began = time.process_time()
    try:
        found = planner.plan(scene) if how == "warm" else plan(scene)
    except NospillError as error:
        return {"processor": time.process_time() - began, "error": str(error)}
    report = found.report
    return {
        "processor": time.process_time() - began,
        "duration": found.duration,
        "certified": found.certificate.ok,
        "warm": report.warm,
        "not_warm": report.not_warm,
        "iterations": report.iterations,
        "rounds": report.rounds,
        "phases": dict(report.phases),
    }


def _table(lines: dict[str, list[dict[str, Any]]]) -> str:
    """Medians of warm and cold plans, and by how much the warm motions are longer."""
    found = []
    for how, own in lines.items():
        seconds = np.array([line["processor"] for line in own])
        certified = sum(line.get("certified", False) for line in own)
        warm = sum(line.get("warm", False) for line in own)
        text = f"{how}: {len(own)} plans, {certified} certified, {warm} warm; processor time median"
        found.append(f"{text} {np.median(seconds):.2f} s, {seconds.min():.2f} to {seconds.max():.2f} s")
    if len(lines) == 2:
        pairs = zip(*lines.values(), strict=True)
        longer = [b["duration"] / a["duration"] - 1.0 for a, b in pairs if "duration" in a and "duration" in b]
        found.append(
            f"warm motions last {100 * min(longer):.2f} to {100 * max(longer):.2f} % longer, "
            f"{100 * float(np.median(longer)):.2f} % in the median; {sum(one > 0.01 for one in longer)} over 1 %"
        )
    return "\n".join(found)


def main() -> None:
    """Run the series that the command line names, each in a process of its own."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("what", nargs="+", choices=_SERIES)
    parser.add_argument("--seeds", type=int, nargs="+", default=[0])
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--only", choices=("cold", "warm"))
    parser.add_argument("--here", action="store_true", help="in this process: one series")
    asked = parser.parse_args()
    if asked.here:
        for line in series(asked.what[0], asked.only, asked.seeds[0], asked.count):
            print(json.dumps(line))
        return
    for what in asked.what:
        lines: dict[str, list[dict[str, Any]]] = {}
        for how in ("cold", "warm") if asked.only is None else (asked.only,):
            for seed in asked.seeds:
                command = [sys.executable, "-m", "benchmarks.cell.run", what, "--here", "--only", how]
                command += ["--seeds", str(seed), "--count", str(asked.count)]
                output = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
                own = [json.loads(line) for line in output.splitlines()]
                lines.setdefault(how, []).extend(own)
                for line in own:
                    print(json.dumps({"series": what, "how": how, "seed": seed} | line), flush=True)
        print(f"{what}\n{_table(lines)}")


if __name__ == "__main__":
    main()
