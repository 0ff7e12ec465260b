"""The problem of a seed: an arm, a tray with its objects, a cell of one family, start and goal that are clear.

A start or goal counts as clear where the arm can hold the level tray there with nothing in the way. Cells in which no
clear start and goal come up are drawn anew, and so are problems for which `existence` finds no motion; both are
counted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.carry.existence import LevelSearch
from benchmarks.carry.families import FAMILIES, Cell, Room
from nospill.errors import ScenarioError
from nospill.robots.description.catalog import load_robot
from nospill.scenario import scene_from_table

STREAM = 18_018
"""First word of every seed sequence."""

SHOULDERS = {"ur5e": 0.163, "franka-fr3": 0.333, "comau-smart-six": 0.45}
"""Arm -> height of its shoulder, m."""
_MODEL_REACH = 0.85
"""m; of the arm for which the families are written."""
_PLACES, CELLS = 30, 200
_ASIDE = 9.0
"""m; height at which nothing is in the way."""


@dataclass(frozen=True, slots=True)
class Problem:
    """One problem.

    Attributes:
        seed: which.
        family: of its cell.
        table: content of its scenario file.
        slow_s: what the motion takes that is known to exist, at a quarter of the joints' speeds.
        singular: whether that motion passes a singularity, so that the arm changes its branch.
        blocked: cells that were drawn before without a clear start and goal.
        pathless: problems that were drawn before for which no motion was found.
    """

    seed: int
    family: str
    table: dict[str, Any]
    slow_s: float
    singular: bool
    blocked: int
    pathless: int


def draw_problem(seed: int) -> Problem | None:
    """The problem of a seed, the same wherever the catalogue of robots is the same; None where none comes up."""
    random = np.random.default_rng([STREAM, seed])
    family = list(FAMILIES)[seed % len(FAMILIES)]
    model = list(SHOULDERS)[(seed // len(FAMILIES)) % len(SHOULDERS)]
    blocked = pathless = 0
    for _ in range(CELLS):
        table = _table(random, model, f"carry-{seed}")
        placed = _placed(random, table, FAMILIES[family](random), load_robot(model).reach or 1.0, SHOULDERS[model])
        if placed is None:
            blocked += 1
            continue
        found = LevelSearch(scene_from_table(placed, name=f"carry-{seed}"), random).slow_motion()
        if found is None:
            pathless += 1
            continue
        return Problem(seed, family, placed, found.duration, found.singular, blocked, pathless)
    return None


def _table(random: np.random.Generator, model: str, name: str) -> dict[str, Any]:
    """A scenario without its places and obstacles."""
    size = [_drawn(random, 0.16, 0.22), _drawn(random, 0.12, 0.18)]
    tilting = bool(random.integers(2))
    return {
        "name": name,
        "fidelity": "full",
        "robot": {"model": model},
        "tray": {"size": size, "friction": 0.45, "mass": 0.3, "offset": _drawn(random, 0.06, 0.12)},
        "cargo": _cargo(random, size, int(random.integers(1, 5))),
        "motion": {"tilt": "free" if tilting else "fixed"},
        "planning": {"slosh_modes": 1},
    }


def _cargo(random: np.random.Generator, size: list[float], count: int) -> list[dict[str, Any]]:
    """Cups of water, bottles and boxes, each in a field of the tray of its own."""
    columns, rows = (1, 1) if count == 1 else (2, 1) if count == 2 else (2, 2)
    width, depth = size[0] / columns, size[1] / rows
    room = min(0.42 * min(width, depth), 0.04)
    cargo: list[dict[str, Any]] = []
    for number in range(count):
        column, row = number % columns, number // columns
        at = [round((column + 0.5) * width - size[0] / 2, 4), round((row + 0.5) * depth - size[1] / 2, 4)]
        radius = _drawn(random, 0.6 * room, room)
        item: dict[str, Any] = {"name": f"c{number + 1}", "at": at}
        kind = "cup" if number == 0 else random.choice(["cup", "bottle", "box"])
        if kind == "box":
            side = _drawn(random, radius, 1.3 * radius)
            item |= {"shape": "box", "length": side, "width": side, "height": side, "mass": 0.2}
        else:
            height = _drawn(random, 2.2 * radius, 3.0 * radius)
            item |= {"shape": "cylinder", "radius": radius, "height": height}
            if kind == "cup":
                level = round(0.55 * height, 4)
                limit = round(0.3 * radius, 4)
                item |= {"liquid": "water", "liquid_height": level, "max_slosh_height": limit, "empty_mass": 0.03}
            else:
                item |= {"mass": 0.3, "centre_of_mass_height": round(0.45 * height, 4)}
        cargo.append(item)
    return cargo


def _placed(
    random: np.random.Generator, table: dict[str, Any], cell: Cell, reach: float, shoulder: float
) -> dict[str, Any] | None:
    """The table with the cell about the arm, and a clear start and goal in it; None where none comes up."""
    scale, turn = reach / _MODEL_REACH, float(random.uniform(-math.pi / 3, math.pi / 3))
    clearance = float(random.choice([0.005, 0.01]))
    solids = [_moved(item, scale, turn, shoulder) | {"clearance": clearance} for item in cell.solids]
    # obstacles are read with a path that is in nobody's way; which places are clear is looked at after that
    aside: list[dict[str, Any]] = [{"position": [x, 0.0, _ASIDE]} for x in (0.0, 1.0)]
    cell_alone = table | {"obstacle": solids, "path": {"type": "free", "start": aside[0], "goal": aside[1]}}
    try:
        search = LevelSearch(scene_from_table(cell_alone, name=table["name"]), random)
    except ScenarioError as error:
        if "swallows the foot" not in str(error):
            raise
        return None
    ends: list[dict[str, Any]] = []
    for room in (cell.start, cell.goal):
        tried = (_place(random, room, scale, turn, shoulder) for _ in range(_PLACES))
        found = next((end for end in tried if len(search.clear_at(np.array([*end["position"], end["yaw"]])))), None)
        if found is None:
            return None
        ends.append(found)
    return table | {"obstacle": solids, "path": {"type": "free", "start": ends[0], "goal": ends[1]}}


def _place(random: np.random.Generator, room: Room, scale: float, turn: float, shoulder: float) -> dict[str, Any]:
    x, y, z = scale * random.uniform(*np.sort([room.low, room.high], axis=0))
    yaw = room.yaw + turn + random.uniform(-0.3, 0.3)
    at = [math.cos(turn) * x - math.sin(turn) * y, math.sin(turn) * x + math.cos(turn) * y, z + shoulder]
    return {"position": [round(value, 4) for value in at], "yaw": round(yaw, 4)}


def _moved(item: dict[str, Any], scale: float, turn: float, shoulder: float) -> dict[str, Any]:
    """An obstacle made larger, turned about the arm and lifted to its shoulder."""
    x, y, z = (scale * value for value in item["at"])
    at = [math.cos(turn) * x - math.sin(turn) * y, math.sin(turn) * x + math.cos(turn) * y, z + shoulder]
    sizes = {
        key: [_metres(scale * side) for side in item[key]] if key == "size" else _metres(scale * item[key])
        for key in ("size", "radius", "height")
        if key in item
    }
    return item | sizes | {"at": [round(value, 4) for value in at], "yaw": round(turn, 4)}


def _drawn(random: np.random.Generator, low: float, high: float) -> float:
    return round(float(random.uniform(low, high)), 4)


def _metres(length: float) -> str:
    """With its unit: bare sizes above 2 m are refused."""
    return f"{length:.4f} m"
