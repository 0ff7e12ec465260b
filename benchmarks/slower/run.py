"""How far half-speed motions are from the plans that they rehearse: bundled examples, and free paths among obstacles.

    python -m benchmarks.slower.run --plans FOLDER                      examples, planned into FOLDER where they are not
    python -m benchmarks.slower.run --plans FOLDER --free 0 12          free paths of these seeds of `benchmarks.carry`

A line for each plan, and at the end how many keep the way. What is said instead is printed as it is.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from pathlib import Path

import numpy as np

import nospill as ns
from benchmarks.carry.draw import PROBLEMS, read_problems
from nospill.errors import NospillError
from nospill.planning.slower import apart, slower
from nospill.plans.plan import Plan
from nospill.scenario import scene_from_table
from nospill.scenario.examples import EXAMPLES
from nospill.scene.scene import Scene

SPEED = 0.5
_LONGEST = 120.0
"""s; to plan one of the free paths."""


def planned(scene: Scene, folder: Path) -> Plan:
    """The plan in a folder, made where there is none."""
    if not folder.is_dir():
        ns.plan(scene).save(folder)
    return ns.load_plan(folder)


def slowed(plan: Plan) -> tuple[str, str]:
    """What becomes of a plan at half its speed, in a word, and its figures or what is said."""
    try:
        slow = slower(plan, SPEED)
    except NospillError as error:
        return "said", str(error)
    gap = apart(plan, slow)
    percent = 100.0 * plan.duration / slow.duration
    figures = f"{percent:.1f} % of the speed, {1e3 * gap.distance:.3f} mm, {np.degrees(gap.angle):.4f} deg apart"
    return ("same way" if gap.is_same and slow.certificate.ok else "WRONG"), figures


def main() -> None:
    """Run and report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="of the examples; all where none is given")
    parser.add_argument("--plans", type=Path, required=True, help="folder of plan folders")
    parser.add_argument("--free", type=int, nargs=2, metavar=("FIRST", "LAST"), help="seeds of free paths instead")
    options = parser.parse_args()
    if options.free:
        problems = read_problems(PROBLEMS)
        chosen = [(f"free-{seed}", problems[seed]["table"]) for seed in range(*options.free) if seed in problems]
        scenes = [
            (name, scene_from_table(table, name=name).changed({"planning.max_plan_time": _LONGEST}))
            for name, table in chosen
        ]
    else:
        scenes = [(name, ns.load(name)) for name in options.names or EXAMPLES]
    words: Counter[str] = Counter()
    for name, scene in scenes:
        began = time.process_time()
        try:
            plan = planned(scene, options.plans / name)
        except NospillError as error:
            words["not planned"] += 1
            print(f"{name}: not planned: {str(error)[:120]}", flush=True)
            continue
        if not plan.certificate.ok:
            words["not planned"] += 1
            continue
        word, figures = slowed(plan)
        words[word] += 1
        print(f"{name}, {plan.duration:.3f} s: {word} ({time.process_time() - began:.0f} s): {figures}", flush=True)
    print(dict(words))


if __name__ == "__main__":
    main()
