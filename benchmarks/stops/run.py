"""Stops of bundled examples simulated in MuJoCo, each with the plan before it, from rest to rest.

    python -m benchmarks.stops.run --every 0.04 matrix-liquid pp-two-cups

Prints a line for each example, and at the end how many stops were simulated and in how many an object moved.
"""

from __future__ import annotations

import argparse
import time

import nospill as ns
from nospill.errors import NospillError
from nospill.motion.interpolation import QUINTIC_SPLINE
from nospill.plans.stops import stopped
from nospill.verify import verify
from nospill.verify.tray_motion import replay_joints

EXAMPLES = ("matrix-liquid", "matrix-rigid", "pp-two-cups", "matrix-liquid-soft-end", "coffee-to-go", "mixed-tray")


def moved(name: str, every: float) -> tuple[int, int]:
    """How many stops of an example were simulated, and in how many of them something moved."""
    plan = ns.plan(ns.load(name))
    stops, count = ns.stops(plan, every=every).stops, 0
    for stop in stops:
        samples = stopped(plan.trajectory, stop)
        source = f"stop from {stop.t:.3f} s"
        joints = replay_joints(samples, plan.scene, interpolation=QUINTIC_SPLINE, source=source)
        report = verify(plan, joints=joints)
        if not report.ok:
            count += 1
            print(f"  {name}, {source}, {stop.origin}: {report.message}", flush=True)
    return len(stops), count


def main() -> None:
    """Simulate the stops of some examples."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("examples", nargs="*", default=EXAMPLES)
    parser.add_argument("--every", type=float, default=0.04, help="s, between the instants")
    options = parser.parse_args()
    total = bad = 0
    for name in options.examples:
        began = time.perf_counter()
        try:
            simulated, count = moved(name, options.every)
        except NospillError as error:
            print(f"{name}: {error}", flush=True)
            continue
        total, bad = total + simulated, bad + count
        print(f"{name}: {simulated} stops, {count} moved, {time.perf_counter() - began:.0f} s", flush=True)
    print(f"{total} stops, in {bad} of them something moved")


if __name__ == "__main__":
    main()
