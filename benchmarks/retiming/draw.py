"""Fifty joint paths by OMPL's RRT-Connect on three arms, past three random balls in the space of their joints.

    python -m benchmarks.retiming.draw      writes benchmarks/results/joint-paths.json; needs `pip install ompl`

The tray stays level along every path: four joints are free, the others follow from them.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import nospill as ns
from nospill.collisions.configurations import Configurations

# pyright: reportMissingImports=false, reportAttributeAccessIssue=false

PATHS = Path(__file__).parents[1] / "results" / "joint-paths.json"
COUNT, SEED = 50, 1
_SHORTEST, _LONGEST = 2.0, 6.0
"""rad, of a path."""
_BALL = 0.7
"""rad."""


@dataclass(frozen=True, slots=True)
class Arm:
    """An arm, and all its joints from four of them so that the tray is level.

    Attributes:
        model: in the catalogue.
        lift: from the four joints to all.
        ranges: of the four, rad.
        acceleration: of every joint, rad/s^2, where the catalogue has none.
    """

    model: str
    lift: Callable[[Sequence[float]], list[float]]
    ranges: tuple[tuple[float, float], ...]
    acceleration: float | None = None


ARMS = (
    Arm(
        "ur5e",
        lambda x: [x[0], x[1], x[2], np.pi / 2 - x[1] - x[2], -np.pi / 2, x[3]],
        ((-2.0, 2.0), (-2.6, -0.3), (0.3, 2.4), (-2.0, 2.0)),
        10.0,
    ),
    Arm(
        "franka-fr3",
        lambda x: [x[0], x[1], 0.0, x[2], 0.0, np.pi + x[1] - x[2], x[3]],
        ((-2.0, 2.0), (-1.5, 0.3), (-2.4, -0.3), (-2.0, 2.0)),
    ),
    Arm(
        "comau-smart-six",
        lambda x: [x[0], x[1], x[2], 0.0, -x[1] + x[2], x[3]],
        ((-2.0, 2.0), (-1.0, 1.3), (-2.2, -0.5), (-2.0, 2.0)),
    ),
)

CUP: dict[str, Any] = {
    "name": "cup",
    "shape": "cylinder",
    "radius": "35 mm",
    "height": "100 mm",
    "liquid": "water",
    "liquid_height": "60 mm",
    "max_slosh_height": "15 mm",
    "empty_mass": "50 g",
    "at": [0, 0],
}


def task(arm: Arm, points: list[list[float]], *, cup: bool) -> ns.Scene:
    """A path with an empty tray or a cup on it."""
    robot: dict[str, Any] = {"model": arm.model}
    if arm.acceleration is not None:
        robot["limits"] = {"acceleration": arm.acceleration}
    table: dict[str, Any] = {
        "robot": robot,
        "tray": {"size": ["200 mm", "150 mm"], "mass": "0.2 kg", "friction": 0.45, "offset": "100 mm"},
        "path": {"type": "joints", "points": points},
        "cargo": [CUP] if cup else [],
    }
    return ns.load(table)


def drawn(arm: Arm, random: np.random.Generator, *, shortened: bool) -> list[list[float]]:
    """One path, rad."""
    from ompl import base, geometric

    middle = [float(np.mean(ends)) for ends in arm.ranges]
    robot = task(arm, [arm.lift(middle), arm.lift([value + 0.1 for value in middle])], cup=False)
    clear = Configurations(robot)
    balls = [np.array([random.uniform(*ends) for ends in arm.ranges]) for _ in range(3)]

    def valid(x: np.ndarray) -> bool:
        q = np.array(arm.lift(x.tolist()))
        inside = np.all((q > robot.robot.lower + 0.02) & (q < robot.robot.upper - 0.02))
        return bool(inside and min(np.linalg.norm(x - ball) for ball in balls) > _BALL and clear.clear(q[None])[0])

    space, bounds = base.RealVectorStateSpace(len(arm.ranges)), base.RealVectorBounds(len(arm.ranges))
    for index, (low, high) in enumerate(arm.ranges):
        bounds.setLow(index, low)
        bounds.setHigh(index, high)
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    setup.setStateValidityChecker(lambda state: valid(np.array([state[i] for i in range(len(arm.ranges))])))
    while True:
        ends = [np.array([random.uniform(*at) for at in arm.ranges]) for _ in range(2)]
        if not all(map(valid, ends)):
            continue
        setup.clear()
        states = [space.allocState() for _ in ends]
        for state, values in zip(states, ends, strict=True):
            for index, value in enumerate(values.tolist()):
                state[index] = value
        setup.setStartAndGoalStates(*states)
        setup.setPlanner(geometric.RRTConnect(setup.getSpaceInformation()))
        if not setup.solve(2.0) or not setup.haveExactSolutionPath():
            continue
        if shortened:
            setup.simplifySolution()
        path = setup.getSolutionPath()
        places = [[path.getState(k)[i] for i in range(len(arm.ranges))] for k in range(path.getStateCount())]
        points = [arm.lift(place) for place in places]
        if _SHORTEST <= float(np.sum(np.linalg.norm(np.diff(points, axis=0), axis=1))) <= _LONGEST:
            return points


def main() -> None:
    """Draw them all; every other one is shortened, as a user of OMPL does."""
    from ompl import util

    util.setLogLevel(util.LOG_ERROR)
    util.RNG.setSeed(SEED)
    paths = []
    for number in range(COUNT):
        arm = ARMS[number % len(ARMS)]
        points = drawn(arm, np.random.default_rng(number), shortened=number % 2 == 0)
        paths.append({"number": number, "arm": arm.model, "points": np.round(points, 6).tolist()})
    PATHS.write_text(json.dumps(paths) + "\n", encoding="utf-8")
    print(f"{len(paths)} paths written to {PATHS}")


if __name__ == "__main__":
    main()
