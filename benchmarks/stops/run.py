"""Stops of bundled examples: the tables of docs/stopping.md, every stop judged anew from rest and played in MuJoCo.

    python -m benchmarks.stops.run --every 0.06 matrix-liquid-tilt mixed-tray

Prints of each example a row of the table of spill-free stops and one of that of the controller's own, then how many
stops break a limit as one motion with the plan before them, and in how many something moves in MuJoCo.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import nospill as ns
from benchmarks.stops.judging import played_joints, verdict_from_rest
from nospill.certification.wording import finding
from nospill.errors import NospillError
from nospill.plans.plan import Plan
from nospill.plans.stops import ControllerStop, Stops
from nospill.verify import verify

EXAMPLES = ("matrix-liquid", "matrix-rigid", "pp-two-cups", "matrix-liquid-soft-end", "coffee-to-go", "mixed-tray")


def row_of_stops(name: str, found: Stops, every: float, seconds: float) -> str:
    """The row of an example in the table of spill-free stops; `seconds` are of the processor, of all of them."""
    median = float(np.median([stop.duration for stop in found.stops]))
    cells = [f"`{name}`", f"{1e3 * every:.0f} ms", f"{len(found.stops)}", f"{100 * found.solved:.0f} %"]
    cells += [f"{value:.2f}" for value in (found.part_left, found.bound_of_left)] + [f"{found.over_bound:.1f}"]
    return f"| {' | '.join(cells)} | {median:.2f} s | {seconds / len(found.stops):.2f} s |"


def row_of_brakes(name: str, found: Stops) -> str:
    """The row of an example in the table of what a plain brake spills."""
    kinds = [[stop for stop in found.controller if stop.kind == kind] for kind in ("joints", "path")]
    holding = " and ".join(f"{sum(stop.certified for stop in kind)}" for kind in kinds)
    cells = [cell for kind in kinds for cell in (_highest(kind), f"{_most(kind, 'slip')}, {_most(kind, 'tip')}")]
    return f"| `{name}` | {' | '.join(cells)} | {holding} of {len(found.stops)} |"


def _highest(stops: list[ControllerStop]) -> str:
    beyond = [stop.spill for stop in stops if np.isinf(stop.spill)]
    highest = max((stop.spill for stop in stops if np.isfinite(stop.spill)), default=0.0)
    return f"{1e3 * highest:.0f} mm" + (f", {len(beyond)} beyond the slosh model" if beyond else "")


def _most(stops: list[ControllerStop], constraint: str) -> int:
    """Most objects that break a limit in one of some stops."""
    return max(sum(key.startswith(f"{constraint} | ") for key in stop.uses) for stop in stops)


def bad_stops(plan: Plan, found: Stops, *, one_of: int) -> tuple[int, int, int]:
    """How many stops break a limit as judged from rest, how many of those played something moves in, how many are."""
    broken = moved = played = 0
    for number, stop in enumerate(stop for stop in found.stops if stop.is_sooner):
        certificate = verdict_from_rest(plan, stop, found.residual)
        if not certificate.ok:
            broken += 1
            print(f"  stop from {stop.t:.3f} s: {finding(certificate)}", flush=True)
        if number % one_of == 0:
            played += 1
            report = verify(plan, joints=played_joints(plan, stop))
            if not report.ok:
                moved += 1
                print(f"  stop from {stop.t:.3f} s, {stop.origin}: {report.message}", flush=True)
    return broken, moved, played


def main() -> None:
    """Find and judge the stops of some examples."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("examples", nargs="*", default=EXAMPLES)
    parser.add_argument("--every", type=float, default=0.06, help="s, between the instants")
    parser.add_argument("--played", type=int, default=1, metavar="N", help="one of N stops is played in MuJoCo")
    options = parser.parse_args()
    total = np.zeros(3, dtype=int)
    for name in options.examples:
        try:
            plan = ns.plan(ns.load(name))
            began = time.process_time()
            found = ns.stops(plan, every=options.every)
        except NospillError as error:
            print(f"{name}: {error}", flush=True)
            continue
        spent = time.process_time() - began
        print(row_of_stops(name, found, options.every, spent), row_of_brakes(name, found), sep="\n", flush=True)
        total += bad_stops(plan, found, one_of=options.played)
    print(f"broken, moved, played: {', '.join(map(str, total))}")


if __name__ == "__main__":
    main()
