"""Scenarios with several features at once: three drawn of those that touch the certificate, put on one random task.

The certificate of every pair of features follows one law, or the reader refuses the pair in one sentence; the campaign
looks whether both are so. `docs/reliability.md` has the table.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from benchmarks.campaign.distributions import COMBINED, FIRST_WITH_NEWER, Choice, Distributions, Spread
from nospill.scene.scene import Scene

Table = dict[str, Any]

FEATURES_EACH = 3
_STREAM = 3
_SHARE = Spread(0.02, 0.15, "of the number")
_TIME = Spread(0.0, 0.03, "s")
_BESIDE = Spread(0.0, 0.2, "m")
_RADIUS = Spread(0.03, 0.12, "m")


def features_of(seed: int) -> tuple[str, ...]:
    """The features of a seed, in the order in which they are put on its task."""
    random = np.random.default_rng([_STREAM, seed])
    if seed < FIRST_WITH_NEWER:
        chosen = random.choice(list(FEATURES), FEATURES_EACH, replace=False).tolist()
    else:
        chosen = [str(random.choice(list(NEWER)))]
        others = [name for name in (*FEATURES, *NEWER) if name not in chosen]
        chosen += random.choice(others, FEATURES_EACH - 1, replace=False).tolist()
    return tuple(name for name in (*FEATURES, *NEWER) if name in chosen)


def combined_distributions(seed: int) -> Distributions:
    """What the task of a seed is drawn from: its objects are of the shapes that its features name."""
    kinds = [kind for name in features_of(seed) for kind in _KINDS.get(name, ())]
    known = COMBINED if not kinds else replace(COMBINED, kind=Choice(("cup", "bottle", *kinds)))
    return replace(known, yaw_change=Spread(90.0, 180.0, "deg")) if "turning box" in features_of(seed) else known


def combined_table(table: Table, scene: Scene, seed: int) -> Table:
    """A task with its features.

    Args:
        table: of the task, in reach.
        scene: the same, as the reader has it.
        seed: that draws the features and their numbers.
    """
    random = np.random.default_rng([_STREAM, seed, 1])
    every = {**FEATURES, **NEWER}
    for name in features_of(seed):
        table = every[name](table, scene, random)
    return table


def _as_drawn(table: Table, scene: Scene, random: np.random.Generator) -> Table:
    """A feature that the distributions have drawn already: the shapes of objects."""
    return table


def _tolerances(table: Table, scene: Scene, random: np.random.Generator) -> Table:
    known = {
        "friction": _SHARE.draw(random),
        "mass": _SHARE.draw(random),
        "position": round(0.05 * _SHARE.draw(random), 5),
        "liquid_height": round(0.02 * _SHARE.draw(random), 5),
        "damping": [round(random.uniform(0.5, 1.0), 3), round(random.uniform(1.0, 2.0), 3)],
    }
    chosen = random.choice(list(known), 2, replace=False).tolist()
    return table | {"tolerance": {key: known[key] for key in chosen}}


def _controller(table: Table, scene: Scene, random: np.random.Generator) -> Table:
    joints = len(scene.robot.joints)
    times = {key: [_TIME.draw(random) for _ in range(joints)] for key in ("delay", "lag")}
    return table | {"controller": times | {"compensate": bool(random.uniform() < 0.7)}}


def _speed_range(table: Table, scene: Scene, random: np.random.Generator) -> Table:
    return _motion(table, speed_range=[round(random.uniform(0.6, 0.95), 2), 1.0])


def _duration(table: Table, scene: Scene, random: np.random.Generator) -> Table:
    return _motion(table, duration=round(2.0 + 2.0 * scene.path.length, 2))


def _motion(table: Table, **keys: Any) -> Table:
    return table | {"motion": table["motion"] | keys}


def _corridor(table: Table, scene: Scene, random: np.random.Generator) -> Table:
    return table | {"path": table["path"] | {"corridor": round(random.uniform(0.01, 0.06), 4)}}


def _free_path(table: Table, scene: Scene, random: np.random.Generator) -> Table:
    start, goal = scene.path.at(np.array([0.0, 1.0]))
    ends = {
        name: {"position": pose[:3].tolist(), "yaw": float(pose[3])}
        for name, pose in (("start", start), ("goal", goal))
    }
    kept = {key: table["path"][key] for key in ("corridor",) if key in table["path"]}
    return table | {"path": {"type": "free", **ends, **kept}}


def _obstacle(table: Table, scene: Scene, random: np.random.Generator) -> Table:
    """A ball to one side of the path, which tray and cargo pass at a drawn distance."""
    at = scene.path.at(np.array([random.uniform(0.3, 0.7)]))[0, :3]
    around, radius = random.uniform(-math.pi, math.pi), _RADIUS.draw(random)
    away = math.hypot(*scene.tray.size) / 2 + radius + 0.01 + _BESIDE.draw(random)
    place = at + away * np.array([math.cos(around), math.sin(around), 0.0])
    return table | {
        "obstacle": [{"name": "ball", "shape": "sphere", "at": np.round(place, 4).tolist(), "radius": radius}]
    }


def _swing(table: Table, scene: Scene, random: np.random.Generator) -> Table:
    """One of the liquids that stand on the tray itself swings when the motion begins."""
    able = [item.name for item in scene.cargo if item.filling is not None and item.carrier is None]
    if not able:
        return table
    name, share = str(random.choice(able)), random.uniform(-0.2, 0.2, 2)
    cargo = []
    for item in table["cargo"]:
        if name == item["name"] and "array" not in item:
            place = (share * item["max_slosh_height"]).tolist()
            item = item | {"initial_swing": {"displacement": [place], "velocity": [[0.0, 0.0]]}}
        cargo.append(item)
    return table | {"cargo": cargo}


def _approach(table: Table, scene: Scene, random: np.random.Generator) -> Table:
    """From the arm's home; mostly with an empty tray, since a straight line in joint space leans a loaded one."""
    joints, tray = len(scene.robot.joints), "loaded" if random.uniform() < 0.2 else "empty"
    return table | {"approach": {"from": "home", "tray": tray, "acceleration": [2.0] * joints}}


def _row(table: Table, scene: Scene, random: np.random.Generator) -> Table:
    """Back along the path after a wait, begun with what swings then; the key is the campaign's own."""
    return table | {BACK_AFTER: round(random.uniform(0.0, 0.3), 3)}


def _late_joints(table: Table, scene: Scene, random: np.random.Generator) -> Table:
    band = {"delay": round(random.uniform(0.0, 0.004), 5), "lag": round(random.uniform(0.0, 0.003), 5)}
    return _tolerance(table, tracking=band)


def _frequency(table: Table, scene: Scene, random: np.random.Generator) -> Table:
    return _tolerance(table, frequency=round(random.uniform(0.002, 0.02), 4))


def _tolerance(table: Table, **keys: Any) -> Table:
    return table | {"tolerance": table.get("tolerance", {}) | keys}


def _second_order(table: Table, scene: Scene, random: np.random.Generator) -> Table:
    return _motion(table, slosh_height="second order")


def _lid(table: Table, scene: Scene, random: np.random.Generator) -> Table:
    able = [item.name for item in scene.cargo if item.filling is not None]
    table = _on_one(table, able, random, "lid")
    without = {"max_slosh_height", "residual_fraction", "initial_swing"}  # nothing spills
    cargo = [
        {key: value for key, value in item.items() if key not in without} if item.get("lid") else item
        for item in table["cargo"]
    ]
    return table | {"cargo": cargo}


def _fixed(table: Table, scene: Scene, random: np.random.Generator) -> Table:
    return _on_one(table, [item.name for item in scene.cargo], random, "fixed")


def _on_one(table: Table, able: list[str], random: np.random.Generator, key: str) -> Table:
    """One object of those that are able, as the file names it, has a key set."""
    written = [item["name"] for item in table["cargo"] if item["name"] in able and "array" not in item]
    if not written:
        return table
    chosen = str(random.choice(written))
    return table | {"cargo": [item | {key: True} if item["name"] == chosen else item for item in table["cargo"]]}


def _in_motion(table: Table, scene: Scene, random: np.random.Generator) -> Table:
    """From the midst of the plan on along the same path, or to a stop; the key is the campaign's own."""
    share = round(random.uniform(0.2, 0.8), 3)
    return table | {ON_FROM: {"share": share, "stop": bool(random.uniform() < 0.5)}}


ON_FROM = "on_from"
"""Key of a drawn table: the part of the duration after which a motion of its own goes on, and whether to a stop."""

BACK_AFTER = "back_after"
"""Key of a drawn table: s between the motion and the one back along its path, which is planned and judged too."""

FEATURES: Mapping[str, Callable[[Table, Scene, np.random.Generator], Table]] = MappingProxyType(
    {
        "vessel": _as_drawn,
        "carrier": _as_drawn,
        "turning box": _as_drawn,
        "tolerances": _tolerances,
        "controller": _controller,
        "speed range": _speed_range,
        "duration": _duration,
        "corridor": _corridor,
        "free path": _free_path,
        "obstacle": _obstacle,
        "initial swing": _swing,
        "approach": _approach,
        "motions in a row": _row,
    }
)
"""By name, in the order in which they are put on a task."""

NEWER: Mapping[str, Callable[[Table, Scene, np.random.Generator], Table]] = MappingProxyType(
    {
        "late joints": _late_joints,
        "frequency": _frequency,
        "second order": _second_order,
        "lid": _lid,
        "fixed": _fixed,
        "begun in motion": _in_motion,
    }
)
"""Features that came later: one at least of every seed from `FIRST_WITH_NEWER` on, after those of `FEATURES`."""


def way_back(table: Table) -> Table:
    """The scenario of the motion back along the path of another; nothing comes before it but that motion."""
    path, ends = dict(table["path"]), ("start", "goal" if table["path"]["type"] == "free" else "end")
    if "points" in path:
        path["points"] = path["points"][::-1]
    else:
        path |= {ends[0]: path[ends[1]], ends[1]: path[ends[0]]}
    if "yaw" in path:
        path["yaw"] = path["yaw"][::-1]
    cargo = [{key: value for key, value in item.items() if key != "initial_swing"} for item in table["cargo"]]
    kept = {key: value for key, value in table.items() if key not in ("approach", BACK_AFTER, ON_FROM)}
    return kept | {"path": path, "cargo": cargo}


_KINDS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"vessel": ("vessel", "vessel"), "carrier": ("rack", "rack"), "turning box": ("box of liquid", "box of liquid")}
)
