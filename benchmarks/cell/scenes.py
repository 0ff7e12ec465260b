"""A cell with an arm of six joints: two mugs and a bottle leave a shelf of two boards for a table, past a pole.

Goals lie 15 cm from each other, drawn above the table; the pole is drawn about its place. A goal or a pole that the arm
cannot reach, or that something is in the way of, is drawn anew.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from copy import deepcopy
from typing import Any

import numpy as np

from nospill.errors import NospillError
from nospill.path_search.branches import require_free_ends
from nospill.path_search.standing import require_standing_room
from nospill.scenario import scene_from_table
from nospill.scene.scene import Scene

STREAM = 58_058
"""First word of every seed sequence."""
STEP, TURN, ASIDE = 0.15, 0.26, 0.06
"""m from each goal to the next one; rad, by which its yaw differs at most; m, from the pole's first place at most."""
_LOW, _HIGH = np.array([0.50, -0.75, 0.36]), np.array([1.0, -0.15, 0.56])
"""m; of the room above the table in which goals are drawn."""
_GOAL, _POLE = np.array([0.75, -0.45, 0.42]), np.array([0.80, 0.10, 0.60])
_TABLE: dict[str, Any] = {
    "fidelity": "full",
    "robot": {"model": "ur10e"},
    "tray": {"size": [0.30, 0.22], "friction": 0.45, "mass": 0.5, "offset": 0.08},
    "cargo": [
        {
            "name": f"mug{number}",
            "at": [at, -0.04],
            "shape": "cylinder",
            "radius": 0.04,
            "height": 0.095,
            "liquid": "water",
            "liquid_height": 0.06,
            "empty_mass": 0.30,
            "max_slosh_height": 0.012,
        }
        for number, at in ((1, -0.07), (2, 0.07))
    ]
    + [
        {
            "name": "bottle",
            "at": [0.0, 0.05],
            "shape": "cylinder",
            "radius": 0.035,
            "height": 0.20,
            "mass": 0.6,
            "centre_of_mass_height": 0.085,
        }
    ],
    "motion": {"tilt": "free"},
}
_SOLIDS: list[dict[str, Any]] = [
    {"name": "upper-board", "shape": "box", "at": [0.55, 0.75, 0.95], "size": [0.4, 0.8, 0.02], "yaw": 0.9},
    {"name": "lower-board", "shape": "box", "at": [0.55, 0.75, 0.25], "size": [0.4, 0.8, 0.02], "yaw": 0.9},
    {"name": "table", "shape": "box", "at": [0.80, -0.45, 0.10], "size": [0.8, 0.9, 0.04]},
]


def cell(goal: np.ndarray = _GOAL, yaw: float = -0.5, pole: np.ndarray = _POLE) -> Scene:
    """The cell with one goal and one place of the pole, m, and the yaw there, rad."""
    table = deepcopy(_TABLE)
    start = {"position": [0.52, 0.62, 0.58], "yaw": 0.9}
    table["path"] = {"type": "free", "start": start, "goal": {"position": goal.tolist(), "yaw": yaw}}
    post = {"name": "pole", "shape": "cylinder", "at": pole.tolist(), "radius": 0.03, "height": 1.2}
    table["obstacle"] = [*deepcopy(_SOLIDS), post]
    return scene_from_table(table, name="cell")


def moved_goals(seed: int, count: int) -> list[Scene]:
    """The cell with goal after goal, each `STEP` from the one before."""
    random, goal, found = np.random.default_rng([STREAM, 0, seed]), _GOAL, list[Scene]()
    while len(found) < count:
        way = random.normal(size=3) * np.array([1.0, 1.0, 0.5])
        there, yaw = goal + STEP * way / np.linalg.norm(way), -0.5 + float(random.uniform(-TURN, TURN))
        if np.all(there > _LOW) and np.all(there < _HIGH):
            for scene in _standing(there, yaw, _POLE):
                found.append(scene)
                goal = there
    return found


def moved_poles(seed: int, count: int) -> list[Scene]:
    """The cell with the pole in place after place, within `ASIDE` of its first one."""
    random, found = np.random.default_rng([STREAM, 1, seed]), list[Scene]()
    while len(found) < count:
        angle, far = random.uniform(0.0, 2.0 * math.pi), ASIDE * math.sqrt(random.uniform())
        found += _standing(_GOAL, -0.5, _POLE + far * np.array([math.cos(angle), math.sin(angle), 0.0]))
    return found


def _standing(goal: np.ndarray, yaw: float, pole: np.ndarray) -> Iterator[Scene]:
    """The cell, where the arm can stand at both ends; else nothing."""
    try:
        scene = cell(goal.round(4), round(yaw, 4), pole.round(4))
        require_free_ends(scene)
        require_standing_room(scene)
    except NospillError:
        return
    yield scene
