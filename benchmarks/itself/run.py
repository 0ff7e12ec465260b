"""Random scenarios on four arms with a tray of 400 x 300 mm, each plan judged by coal alone at 20 kHz.

    python -m benchmarks.itself.run --count 100

Prints a line for each scenario, and at the end how many certified plans touch and whose distances are overstated.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter

import numpy as np

import nospill as ns
from benchmarks.itself.independent import least_rooms
from nospill.errors import NospillError
from nospill.plans.plan import Plan
from nospill.scenario.scenes import scene_from_table
from nospill.scene.scene import Scene

ARMS = ("ur10e", "ur5e", "kuka-kr6-r900", "franka-fr3")
RATE = 20_000.0
RESOLUTION = 2e-4
"""m; by which a distance that coal sees may lie below the certificate's: cups are polyhedra there, cylinders here."""


def random_scene(number: int) -> Scene:
    """Two mugs and a bottle at random yaws on a tray near one of the arms."""
    random = np.random.default_rng(number)
    arm = ARMS[number % len(ARMS)]
    far = {"ur10e": 0.9, "ur5e": 0.6, "kuka-kr6-r900": 0.6, "franka-fr3": 0.55}[arm]
    radius, angle, height = random.uniform(0.35, 1.0) * far, random.uniform(-1.2, 1.2), random.uniform(0.1, 0.7)
    start = np.array([radius * np.cos(angle), radius * np.sin(angle), height])
    ends = [start.tolist(), (start + random.uniform(-0.25, 0.25, 3)).tolist()]
    yaw = random.uniform(-np.pi, np.pi) + np.array([0.0, random.uniform(-0.7, 0.7)])
    mug = {"shape": "cylinder", "radius": 0.04, "height": 0.095, "liquid": "water", "liquid_height": 0.06}
    table = {
        "robot": {"model": arm},
        "tray": {"size": [0.4, 0.3], "friction": 0.4, "offset": float(random.choice([0.06, 0.1, 0.15])), "mass": 0.5},
        "path": {"type": "line", "start": ends[0], "end": ends[1], "yaw": [f"{value} rad" for value in yaw.tolist()]},
        "motion": {"tilt": str(random.choice(["fixed", "free"]))},
        "planning": {"slosh_modes": 1},
        "cargo": [
            {"name": "left", **mug, "empty_mass": 0.3, "at": [-0.12, 0.05]},
            {"name": "right", **mug, "empty_mass": 0.3, "at": [0.1, -0.05], "yaw": float(random.uniform(-3, 3))},
            {"name": "bottle", "shape": "cylinder", "radius": 0.036, "height": 0.25, "mass": 0.8, "at": [0.02, 0.08]},
        ],
    }
    return scene_from_table(table, name=f"itself-{number}")


def touches(plan: Plan) -> tuple[float, float]:
    """Least room that coal sees, m, and by how much the certificate says more than it, m."""
    scene, end = plan.scene, plan.trajectory.t[-1]
    q = plan.trajectory.motion(np.linspace(0.0, end, round(end * RATE) + 1))
    rows = {row.subject: row for row in plan.certificate.rows if row.constraint == "clearance"}
    assert plan.certificate.self_collision is not None
    left_out = {tuple(pair.split(" to ")) for pair, _ in plan.certificate.self_collision.unjudged}
    last = scene.robot.capsules[-1].link
    links = list(dict.fromkeys(item.link for item in scene.robot.capsules))
    load = ["tray", *(item.name for item in scene.cargo)]
    pairs = {(second, first) for index, first in enumerate(links) for second in links[index + 1 :]} - left_out
    pairs |= {(item, link) for item in load for link in links if link != last}
    rooms = least_rooms(scene, q, pairs)
    over = 0.0
    for (first, second), room in rooms.items():
        row = rows.get(f"{first} to {second}", rows.get("all other pairs of arm, tray and cargo"))
        if row is not None and f"{first} to {second}" in rows:
            over = max(over, row.worst_margin - room)
    return min(rooms.values()), over


def main() -> None:
    """Run and report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    options = parser.parse_args()
    ends: Counter[str] = Counter()
    for number in range(options.first, options.first + options.count):
        began = time.process_time()
        try:
            plan = ns.plan(random_scene(number))
        except NospillError as error:
            ends[type(error).__name__] += 1
            print(
                f"{number} {time.process_time() - began:.1f} s {type(error).__name__}: {str(error)[:150]}", flush=True
            )
            continue
        room, over = touches(plan) if plan.certificate.ok else (np.nan, np.nan)
        word = "not certified" if not plan.certificate.ok else "TOUCHES" if room < 0.0 else "free"
        if over > RESOLUTION:
            word += ", OVERSTATED"
        ends[word] += 1
        print(
            f"{number} {time.process_time() - began:.1f} s {word} {1e3 * room:.2f} mm, {1e3 * over:.3f} mm", flush=True
        )
    print(dict(ends))


if __name__ == "__main__":
    main()
