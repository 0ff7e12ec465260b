"""Motions that go on from random states in the midst of plans: planned, judged at 8 kHz, and played in MuJoCo.

    python -m benchmarks.stops.states --count 60 --seed 0 -o states.jsonl

Of each example in turn a state is drawn, evenly over its motion, and what is planned from there: on to the end as the
scenario has it ("same"), to another goal, 50 to 300 mm from that end and turned by up to 30 degrees ("goal"), on to a
calmer end ("calmer", 10 % of the limits may swing on), or a stop ("stop"). In every other draw of "stop" a liquid is
bumped, by up to twice its limit: then the stop is `ns.recover`'s. A line is written for each, and lines that are there
already are not drawn again. MuJoCo plays the plan until the state and the new motion
after it; motions from bumped liquids are not played, since the bump has no motion.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import nospill as ns
from nospill.certification.certificate import judge_motion
from nospill.certification.joining import JOINS
from nospill.errors import NospillError
from nospill.motion.interpolation import QUINTIC_SPLINE, JointSamples
from nospill.motion.trajectory import Trajectory
from nospill.plans.plan import Plan
from nospill.plans.state import MotionState
from nospill.stopping.solving import stopping_scene
from nospill.verify import verify
from nospill.verify.tray_motion import replay_joints

EXAMPLES = ("matrix-liquid", "matrix-rigid", "pp-two-cups", "matrix-liquid-soft-end", "matrix-liquid-tilt")
KINDS = ("goal", "same", "calmer", "stop")
FINE = 8000.0
"""Hz, of the second verdict."""
_MARGIN = 0.1
"""s, before the end of a plan no state is drawn."""


def draws(
    count: int, seed: int, examples: tuple[str, ...], kinds: tuple[str, ...]
) -> Iterator[tuple[int, str, str, float, float, float]]:
    """Number, example, kind, place in the motion (0 to 1), bump over the limit and its direction, rad."""
    for number in range(count):
        random = np.random.default_rng([seed, number])
        place, bump, direction = random.uniform(), random.uniform(0.5, 2.0), random.uniform(0.0, 2.0 * np.pi)
        kind = kinds[number // len(examples) % len(kinds)]
        bumped = kind == "stop" and number // (len(examples) * len(kinds)) % 2 == 1
        yield number, examples[number % len(examples)], kind, place, bump if bumped else 0.0, direction


def result(plan: Plan, kind: str, place: float, bump: float, direction: float, seed: list[int]) -> dict[str, Any]:
    """What became of a state; `seed` is of what else is drawn."""
    state = plan.state_at(0.02 + place * (plan.duration - _MARGIN - 0.02))
    left = plan.duration - state.t
    began, text = time.process_time(), ""
    if bump and state.swings:
        found = ns.recover(plan, _bumped(plan, state, bump, direction))
        record, scene, text = found.stop.trajectory, stopping_scene(plan.scene, state), found.text
        certified, duration = found.certificate.ok, found.stop.duration
    else:
        bump = 0.0
        asked = plan.scene
        if kind == "calmer":
            asked = asked.changed({"motion.end": "residual", "motion.residual_fraction": 0.1})
        if kind == "goal":
            asked = asked.changed({"path": _elsewhere(plan, np.random.default_rng([*seed, 1]))})
        made = ns.plan(asked, start=state, stop=kind == "stop")
        record, scene, certified, duration = made.trajectory, made.scene, made.certificate.ok, made.duration
    line: dict[str, Any] = {"t": state.t, "left": left, "duration": duration, "certified": certified, "text": text}
    line["cpu"] = time.process_time() - began
    if not bump:
        fine = judge_motion(record, scene, rate=FINE).certificate
        joins = [row for row in fine.rows if row.constraint == "joins on"]
        line |= {"fine": fine.ok, "joins": len(joins) == len(JOINS) and all(row.ok for row in joins)}
        line["moved"] = _moved(plan, state, record)
    return line


def _elsewhere(plan: Plan, random: np.random.Generator) -> dict[str, Any]:
    """A free path to a goal beside the plan's; it begins where the tray is."""
    first, last = plan.scene.path.at([0.0, 1.0])
    way = random.normal(size=3)
    goal = last[:3] + random.uniform(0.05, 0.3) * way / np.linalg.norm(way)
    yaw = float(last[3] + random.uniform(-1.0, 1.0) * np.radians(30.0))
    start = {"position": first[:3].tolist(), "yaw": float(first[3])}
    return {"type": "free", "start": start, "goal": {"position": goal.tolist(), "yaw": yaw}}


def _bumped(plan: Plan, state: MotionState, bump: float, direction: float) -> MotionState:
    """The state with the first liquid's slowest mode at a height over its limit."""
    cargo = next(item for item in plan.scene.cargo if item.filling is not None)
    assert cargo.filling is not None
    size = bump * cargo.filling.max_slosh_height / cargo.oscillators[0].surface_gain
    swing = replace(
        state.swings[cargo.name],
        displacement=((size * float(np.cos(direction)), size * float(np.sin(direction))),),
        velocity=((0.0, 0.0),),
    )
    return replace(state, swings={**state.swings, cargo.name: swing})


def _moved(plan: Plan, state: MotionState, record: Trajectory) -> bool:
    """Whether an object moves in MuJoCo while the plan is played until the state and the record after it."""
    rows = round((state.t - plan.trajectory.t[0]) * plan.trajectory.rate)
    q = np.concatenate([plan.trajectory.joint_position[:rows], record.joint_position])
    samples = JointSamples(np.arange(len(q)) / plan.trajectory.rate, q)
    joints = replay_joints(samples, plan.scene, interpolation=QUINTIC_SPLINE, source="plan and what follows")
    return not verify(plan, joints=joints).ok


def main() -> None:
    """Draw states and write what became of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("examples", nargs="*", default=EXAMPLES)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--plans", type=Path, help="folder of plan folders by the examples' names; planned without")
    parser.add_argument("-o", "--output", type=Path, default=Path("states.jsonl"))
    options = parser.parse_args()
    lines = options.output.read_text().splitlines() if options.output.is_file() else []
    done = {json.loads(line)["number"] for line in lines}
    plans: dict[str, Plan] = {}
    drawn = draws(options.count, options.seed, tuple(options.examples), tuple(options.kinds))
    for number, name, kind, place, bump, direction in drawn:
        if number in done:
            continue
        if name not in plans:
            plans[name] = ns.load_plan(options.plans / name) if options.plans else ns.plan(ns.load(name))
        line: dict[str, Any] = {"number": number, "example": name, "kind": kind, "bump": bump}
        try:
            line |= result(plans[name], kind, place, bump, direction, [options.seed, number])
        except NospillError as error:
            line |= {"error": str(error)}
        with options.output.open("a") as file:
            file.write(json.dumps(line) + "\n")
        print(json.dumps(line), flush=True)
    told = [json.loads(line) for line in options.output.read_text().splitlines()]
    print(Counter(_outcome(line) for line in told))


def _outcome(line: dict[str, Any]) -> str:
    if "error" in line:
        return "no motion"
    if not line["certified"]:
        recovering = "recovering, an object moves" if line["text"].endswith("moves") else "recovering"
        return recovering if line["text"].startswith("recovering") else "not certified"
    rejected = not line.get("fine", True) or not line.get("joins", True)
    return "rejected" if rejected else "moved" if line.get("moved") else "certified"


if __name__ == "__main__":
    main()
