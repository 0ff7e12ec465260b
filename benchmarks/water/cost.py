"""Processor time of planning and judging with heights of second order over that with linear ones, in turns.

    python -m benchmarks.water.cost [--seeds 20]

The bundled examples with full physics in which the second order is known, and as many of the random plans of
`benchmarks.water.random_plans` (its kept lines); each is planned once with either order, the one and the other first in
turns, and its motion judged three times with both. Prints a line for each, and the medians.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.water.random_plans import scene_of
from nospill import load
from nospill.certification.certificate import judge_motion
from nospill.planning.planner import plan
from nospill.scene.scene import Scene
from nospill.sweeps.lines import read_lines

EXAMPLES = (
    "matrix-liquid",
    "matrix-liquid-tilt",
    "matrix-liquid-tilt-all-limits",
    "matrix-liquid-corridor",
    "matrix-liquid-point-to-point",
    "mixed-tray",
    "shelf-to-table",
    "cups-past-a-column",
    "pp-two-cups",
)
LINES = Path(__file__).parents[1] / "results" / "water.jsonl.gz"
ORDERS = ("linear", "second order")


def scenes(seeds: int) -> Iterator[tuple[str, Scene]]:
    """Names and scenes, heights of second order as far as that is known."""
    for name in EXAMPLES:
        yield name, load(name).changed({"fidelity": "full"})
    certified = [line["seed"] for line in read_lines(LINES) if line["ok"] and line["residual"] == "linear"]
    for seed in certified[:seeds]:
        scene = scene_of(seed, "linear", 60.0)
        if scene is not None:
            yield str(seed), scene


def seconds(work: Callable[[], object]) -> float:
    """Processor time, s."""
    begun = time.process_time()
    work()
    return time.process_time() - begun


def compared(scene: Scene, orders: tuple[str, ...]) -> tuple[dict[str, float], dict[str, float]]:
    """Processor time, s, of planning and of judging one motion by order, planned in this order."""
    asked = {"linear": scene.changed({"motion.slosh_height": "linear"}), "second order": scene}
    trajectory = plan(asked["linear"]).trajectory  # what is compiled is compiled now
    planning = {order: seconds(partial(plan, asked[order])) for order in orders}
    judging: dict[str, float] = dict.fromkeys(ORDERS, np.inf)
    for order in (*ORDERS, *ORDERS, *ORDERS):
        judging[order] = min(judging[order], seconds(partial(judge_motion, trajectory, asked[order])))
    return planning, judging


def main() -> None:
    """Print the lines and the medians of both ratios."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=20)
    ratios = []
    for number, (name, scene) in enumerate(scenes(parser.parse_args().seeds)):
        planning, judging = compared(scene, ORDERS if number % 2 else ORDERS[::-1])
        ratios.append([times["second order"] / times["linear"] for times in (planning, judging)])
        figures = " | ".join(f"{ratio:.2f}" for ratio in ratios[-1])
        print(f"| {name} | {planning['linear']:.1f}, {planning['second order']:.1f} s | {figures} |", flush=True)
    for what, values in zip(("planning", "judging"), np.array(ratios).T, strict=True):
        print(f"{what}: median {np.median(values):.2f} times, from {values.min():.2f} to {values.max():.2f}")


if __name__ == "__main__":
    main()
