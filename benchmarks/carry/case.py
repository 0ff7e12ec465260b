"""One problem in a process of its own: plans it, looks at the motion from outside, prints one line of JSON.

    python -m benchmarks.carry.case SEED --given < scenario.json

The motion is judged by its certificate, by coal at 20 kHz and by MuJoCo (`nospill verify`); then the same planner
plans the way that it was found about, as a path that is given.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import sys
import time
from typing import Any

import numpy as np

from benchmarks.campaign.case import PLANNED, REFUSED, UNCERTIFIED, failure_of
from nospill.certification.wording import describe
from nospill.collisions.configurations import Configurations
from nospill.errors import NospillError
from nospill.planning import planner
from nospill.plans.plan import Plan
from nospill.scenario import scene_from_table
from nospill.verify import verify

FINE_RATE = 20_000.0
"""Hz; of coal's looks."""
_LOOKS = 1000
_SEARCHING = 0.5
"""Part of a process's time that is for the search."""


def run(table: dict[str, Any], name: str, *, longest: float) -> dict[str, Any]:
    """The figures of a problem.

    Args:
        table: the scenario.
        name: what it is called.
        longest: time to look for a motion, s.
    """
    try:
        scene = scene_from_table(table, name=name)
        scene = scene.changed({"planning.max_plan_time": longest})
    except NospillError as error:
        return {"kind": REFUSED, "reason": str(error)}
    began, at = processor_time(), time.perf_counter()

    def spent() -> dict[str, float]:
        return {"plan_processor_s": processor_time() - began, "plan_s": time.perf_counter() - at}

    try:
        plan = planner.plan(scene)
    except NospillError as error:
        failure, figures = failure_of(error, scene), spent()
        return {"kind": failure.kind, "reason": failure.reason, "blamed": failure.blamed} | figures
    figures = spent()
    return figures | looked_at(plan) | {"on_way_s": on_way(plan, longest)}


def processor_time() -> float:
    """Of this process and those that it started and that have ended, s."""
    return sum(os.times()[:4])


def looked_at(plan: Plan) -> dict[str, Any]:
    """What a plan is worth: its certificate, what coal sees at 20 kHz, and the simulation."""
    worst = plan.certificate.worst
    line: dict[str, Any] = {
        "kind": PLANNED if plan.certificate.ok else UNCERTIFIED,
        "reason": None if plan.certificate.ok else describe(worst),
        "duration_s": plan.duration,
        "phases_s": plan.report.phases,
        "binding": f"{worst.constraint} of {worst.subject}",
        "touching": touching_samples(plan),
    }
    try:
        report = verify(plan)
        line["verify"] = {"ok": report.ok, "message": report.message}
    except NospillError as error:
        line["verify"] = {"ok": False, "message": str(error)}
    return line


def touching_samples(plan: Plan) -> int:
    """Samples at 20 kHz, both ends with them, at which coal finds a pair of bodies nearer than it must be."""
    t = np.arange(0.0, plan.duration, 1.0 / FINE_RATE)
    q = plan.trajectory.motion(np.append(t, plan.duration))
    configurations = Configurations(plan.scene)
    parts = np.array_split(q, max(1, len(q) // _LOOKS))
    return sum(int(np.sum(~configurations.clear(part))) for part in parts)


def on_way(plan: Plan, longest: float) -> float | None:
    """Duration on the way that the motion was found about, as a given path, s; None where that is not certified."""
    source: dict[str, Any] = plan.scene.source
    path = source["path"]
    given: dict[str, Any] = {"type": "waypoints", "points": path.get("way"), "smoothing": 0.0}
    if "way" not in path:
        given = {"type": "line", "start": path["start"]["position"], "end": path["goal"]["position"]}
    if "way_yaw" in path:
        given["yaw_at_points"] = path["way_yaw"]
    else:
        given["yaw"] = [path[end].get("yaw", 0.0) for end in ("start", "goal")]
    try:
        scene = scene_from_table(source | {"path": given}, name=plan.scene.name)
        found = planner.plan(scene.changed({"planning.max_plan_time": longest}))
    except NospillError:
        return None
    return found.duration if found.certificate.ok else None


def main() -> None:
    """Run one problem."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("seed", type=int)
    parser.add_argument("--processor-time", type=int, default=600, metavar="SECONDS", help="longest")
    parser.add_argument("--given", action="store_true", help="read the scenario from the standard input (always so)")
    arguments = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_CPU, (arguments.processor_time, arguments.processor_time + 5))
    line = run(json.load(sys.stdin), f"carry-{arguments.seed}", longest=_SEARCHING * arguments.processor_time)
    print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
