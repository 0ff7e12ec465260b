"""Thirty tasks that cannot be planned, each for one known reason: a task that can be planned, spoiled in one place."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

from nospill.errors import MOTION, NOT_CONVERGED, REST, ROBOT

Table = dict[str, Any]


def _task(robot: Table, path: Table, cargo: list[Table], motion: Table, **tray: Any) -> Table:
    return {
        "robot": robot,
        "tray": {"size": ["335 mm", "250 mm"], "friction": 0.45, "offset": "50 mm"} | tray,
        "cargo": cargo,
        "path": path,
        "motion": motion,
    }


def _cup(name: str, x: str, y: str, **changes: Any) -> Table:
    return {
        "name": name,
        "at": [x, y],
        "shape": "cylinder",
        "radius": "35 mm",
        "height": "99.1 mm",
        "liquid": "water",
        "liquid_height": "49 mm",
        "max_slosh_height": "15 mm",
        "empty_mass": "30 g",
    } | changes


def _can(name: str, x: str, y: str, **changes: Any) -> Table:
    return {
        "name": name,
        "at": [x, y],
        "shape": "cylinder",
        "radius": "33 mm",
        "height": "115 mm",
        "mass": "0.35 kg",
    } | changes


def _line(start: tuple[float, float, float], end: tuple[float, float, float], yaw: tuple[str, str]) -> Table:
    return {"type": "line", "start": list(start), "end": list(end), "yaw": list(yaw)}


_LEVEL = ("0 deg", "0 deg")
_TURN = ("0 deg", "90 deg")

_SMALL: Table = {"size": ["200 mm", "200 mm"]}

BASES: dict[str, Table] = {
    "ur10e cups": _task(
        {"model": "ur10e"},
        _line((0.6, -0.4, 0.5), (0.6, 0.4, 0.5), _TURN),
        [_cup("c1", "-80 mm", "0 mm"), _cup("c2", "80 mm", "0 mm")],
        {"end": "residual", "max_duration": "1.3 s"},
    ),
    "ur10e cans": _task(
        {"model": "ur10e"},
        _line((0.6, -0.4, 0.5), (0.6, 0.4, 0.5), _TURN),
        [_can("can", "-80 mm", "0 mm"), _can("jar", "80 mm", "0 mm", radius="45 mm", mass="0.6 kg", friction=0.5)],
        {"max_duration": "1.2 s"},
    ),
    "comau cans tilting": _task(
        {"model": "comau-smart-six", "limits_applied": "position and speed"},
        _line((0.8, -0.4, 0.95), (0.8, 0.4, 0.95), _LEVEL),
        [_can("can", "-80 mm", "0 mm"), _can("jar", "80 mm", "0 mm", radius="45 mm", mass="0.6 kg")],
        {"tilt": "free", "max_duration": "1.7 s"},
        friction=0.01,
    ),
    "fr3 cup": _task(
        {"model": "franka-fr3"},
        _line((0.45, -0.25, 0.4), (0.45, 0.25, 0.4), _TURN),
        [_cup("c1", "0 mm", "0 mm")],
        {"end": "residual", "max_duration": "1 s"},
        **_SMALL,
    ),
    "fr3 can": _task(
        {"model": "franka-fr3"},
        _line((0.45, -0.25, 0.4), (0.45, 0.25, 0.4), _TURN),
        [_can("can", "0 mm", "0 mm", mass="1.5 kg")],
        {"max_duration": "1 s"},
        **_SMALL,
    ),
    "ur5e can": _task(
        {"model": "ur5e"},
        _line((0.45, -0.3, 0.4), (0.45, 0.3, 0.4), _LEVEL),
        [_can("can", "0 mm", "0 mm")],
        {"max_duration": "1 s"},
        **_SMALL,
    ),
    "ur5e bottle": _task(
        {"model": "ur5e"},
        _line((0.45, -0.3, 0.4), (0.45, 0.3, 0.4), _LEVEL),
        [_can("bottle", "0 mm", "0 mm", radius="40 mm", height="240 mm", mass="0.8 kg", centre_of_mass_height="80 mm")],
        {"max_duration": "1 s"},
        **_SMALL,
    ),
    "ur5e lopsided": _task(
        {"model": "ur5e"},
        _line((0.45, -0.3, 0.4), (0.45, 0.3, 0.4), _LEVEL),
        [_can("can", "0 mm", "0 mm", radius="40 mm", mass="0.8 kg", centre_of_mass=["25 mm", "0 mm", "50 mm"])],
        {"max_duration": "3 s"},
        **_SMALL,
    ),
    "kuka plate": _task(
        {"model": "kuka-kr6-r900"},
        _line((0.6, -0.004, 0.9), (0.6, 0.004, 0.9), ("0 deg", "180 deg")),
        [_can("plate", "0 mm", "0 mm", radius="90 mm", height="30 mm", mass="0.5 kg")],
        {"max_duration": "1 s"},
        **_SMALL,
    )
    | {"fidelity": "deliverable"},
    "kuka can": _task(
        {"model": "kuka-kr6-r900"},
        _line((0.6, -0.3, 0.9), (0.6, 0.3, 0.9), _TURN),
        [_can("can", "0 mm", "0 mm")],
        {"max_duration": "2 s"},
        **_SMALL,
    ),
    "abb bowl": _task(
        {"model": "abb-irb1200-5-90"},
        _line((0.6, -0.05, 0.9), (0.6, 0.05, 0.9), _LEVEL),
        [
            _cup("cup", "-85 mm", "0 mm", radius="30 mm", max_slosh_height="12 mm"),
            _cup(
                "bowl",
                "60 mm",
                "0 mm",
                radius="75 mm",
                height="120 mm",
                liquid_height="40 mm",
                max_slosh_height="30 mm",
            ),
        ],
        {"end": "residual", "residual_fraction": 1.0, "max_duration": "0.68 s", "path_jerk_limit": 1000},
        size=["300 mm", "200 mm"],
    )
    | {"planning": {"path_jerk_weight": 1e-5}},  # else 0.44 s, and the end costs too little to be in the way
    "racer can": _task(
        {"model": "comau-racer-5-080"},
        _line((0.5, -0.25, 0.9), (0.5, 0.25, 0.9), _TURN),
        [_can("can", "0 mm", "0 mm")],
        {"max_duration": "2 s"},
        **_SMALL,
    ),
    "ur5e approach": _task(
        {"model": "ur5e"},
        _line((0.45, -0.3, 0.4), (0.45, 0.3, 0.4), _LEVEL),
        [_can("can", "0 mm", "0 mm")],
        {"max_duration": "3 s"},
        **_SMALL,
    )
    | {
        "approach": {
            "from": ["0 deg", "-100 deg", "90 deg", "-80 deg", "90 deg", "0 deg"],
            "tray": "empty",
            "acceleration": "5 rad/s^2",
        }
    },
}
"""Tasks that can be planned."""


@dataclass(frozen=True, slots=True)
class Case:
    """One task that cannot be planned.

    Attributes:
        name: what is wrong, for people. base: key of `BASES`.
        spoiled: place in the scenario (objects by their number) -> value: one of them makes it impossible, others
            only give time or keep the length of the path.
        kind, constraint: the reason that was built in.
        subjects: any of these may be named; no matter which where empty.
        between: path parameters between which it is in the way; anywhere where None.
    """

    name: str
    base: str
    spoiled: Table
    kind: str
    constraint: str
    subjects: tuple[str, ...] = ()
    between: tuple[float, float] | None = None


CASES: tuple[Case, ...] = (
    # standing still: the first two are refused on reading
    Case("liquid above the rim", "ur10e cups", {"cargo.1.liquid_height": "105 mm"}, REST, "fill", ("c2",)),
    Case("over the tray's edge", "ur10e cans", {"cargo.0.at": ["-150 mm", "0 mm"]}, REST, "layout", ("can",)),
    Case(
        "shoulder too weak",
        "ur5e can",
        {"robot.limits.torque": [150, 30, 150, 28, 28, 28]},
        REST,
        "joint torque",
        ("shoulder_lift_joint",),
    ),
    Case(
        "weak elbow of seven joints",
        "fr3 can",
        {"robot.limits.torque": [87, 87, 87, 6, 12, 12, 12]},
        REST,
        "joint torque",
        ("fr3_joint4",),
    ),
    Case("centre near the edge", "ur5e lopsided", {"cargo.0.footprint_reserve": 0.5}, REST, "tip", ("can",)),
    # impossible for the robot
    Case(
        "starts out of reach",
        "ur5e can",
        {"path.start": [0.45, -0.9, 0.4], "path.end": [0.45, -0.3, 0.4]},
        ROBOT,
        "reach",
        ("ur5e",),
        (0.0, 0.0),
    ),
    Case(
        "bulges out of reach",
        "ur10e cups",
        {
            "path": {"type": "arc", "start": [0.7, -0.7, 0.5], "through": [1.35, 0.0, 0.5], "end": [0.7, 0.7, 0.5]},
            "motion.max_duration": "4 s",
        },
        ROBOT,
        "reach",
        ("ur10e",),
        (0.1, 0.5),
    ),
    Case("tray mounted too high", "ur5e can", {"tray.offset": "1200 mm"}, ROBOT, "reach", ("ur5e",)),
    Case(
        "seven joints out of reach",
        "fr3 can",
        {"path.start": [0.45, 0.45, 0.4], "path.end": [0.45, 0.95, 0.4]},
        ROBOT,
        "reach",
        ("franka-fr3",),
        (0.2, 0.99),
    ),
    Case(
        "no turn of the base helps",
        "ur10e cans",
        {"robot.base_yaw": "free", "path.start": [1.4, -0.4, 0.5], "path.end": [1.4, 0.4, 0.5]},
        ROBOT,
        "reach",
        ("ur10e",),
    ),
    Case(
        "turn beyond the wrist",
        "kuka can",
        {"path.yaw": ["0 deg", "900 deg"]},
        ROBOT,
        "joint position",
        ("joint_a6",),
    ),
    Case(
        "first joint fenced in",
        "racer can",
        {"robot.limits.upper": ["10 deg", "64 deg", "85 deg", "200 deg", "105 deg", "2700 deg"]},
        ROBOT,
        "joint position",
        ("joint_1",),
        (0.1, 0.99),
    ),
    Case(
        "wrist of a tilting arm fenced in",
        "comau cans tilting",
        {
            "robot.limits.lower": ["-170 deg", "-85 deg", "-170 deg", "-210 deg", "-112 deg", "-2700 deg"],
            "robot.limits.upper": ["170 deg", "155 deg", "0 deg", "210 deg", "112 deg", "2700 deg"],
        },
        ROBOT,
        "joint position",
        ("joint_5",),
    ),
    Case(
        "too near to the arm's own axis",
        "ur5e can",
        {"path.start": [-0.4, 0.0, 0.6], "path.end": [0.4, 0.0, 0.6], "motion.max_duration": "4 s"},
        ROBOT,
        "reach",
        ("ur5e",),
        (0.2, 0.5),
    ),
    Case(
        "approach from outside the limits",
        "ur5e approach",
        {"approach.from": ["0 deg", "-100 deg", "190 deg", "-80 deg", "90 deg", "0 deg"]},
        ROBOT,
        "joint position",
        ("elbow_joint",),
    ),
    # no motion within the time
    Case("slippery tray", "ur10e cans", {"tray.friction": 0.12}, MOTION, "slip", ("can",)),
    Case("slosh limit too small", "ur10e cups", {"cargo.1.max_slosh_height": "2 mm"}, MOTION, "slosh height", ("c2",)),
    Case(
        "residual too small",
        "abb bowl",
        {"motion.residual_fraction": 0.02},
        MOTION,
        "residual height",
        ("bowl",),
    ),
    Case("bowl still too soon", "abb bowl", {"motion.end": "still"}, MOTION, "still at the end", ("bowl",)),
    Case("slow joints", "ur10e cans", {"robot.limits.speed_scale": 0.4}, MOTION, "joint speed"),
    Case(
        "slow to gather speed",
        "ur5e can",
        {"robot.limits.acceleration": "2 rad/s^2"},
        MOTION,
        "joint acceleration",
    ),
    Case("gentle joints", "fr3 can", {"robot.limits.jerk_scale": 0.004}, MOTION, "joint jerk"),
    Case(
        "weak first joint",
        "ur10e cans",
        {"robot.limits.torque": [12, 330, 150, 54, 54, 54]},
        MOTION,
        "joint torque",
        ("shoulder_pan_joint",),
    ),
    Case(
        "gentle path",
        "kuka can",
        {"motion.path_jerk_limit": 20, "motion.max_duration": "1.1 s"},
        MOTION,
        "path jerk",
        ("path",),
    ),
    Case("no tilt to speak of", "comau cans tilting", {"motion.max_tilt": "2 deg"}, MOTION, "tilt"),
    Case(
        "gentle tilt",
        "comau cans tilting",
        {"motion.tilt_jerk_limit": 2, "motion.max_duration": "2.5 s"},
        MOTION,
        "tilt jerk",
    ),
    Case(
        "top-heavy bottle",
        "ur5e bottle",
        {"cargo.0.centre_of_mass_height": "235 mm"},
        MOTION,
        "tip",
        ("bottle",),
    ),
    Case("plate that turns on the spot", "kuka plate", {"tray.friction": 0.06}, MOTION, "twist", ("plate",)),
    Case(
        "loaded approach",
        "ur5e approach",
        {
            "approach.tray": "loaded",
            "approach.from": ["0 deg", "-60 deg", "60 deg", "-30 deg", "60 deg", "0 deg"],
        },
        MOTION,
        "approach slip",
        ("can",),
    ),
    # not found
    Case(
        "no time to solve",
        "ur10e cups",
        {"planning.max_solve_time": "2 ms"},
        NOT_CONVERGED,
        "planning",
        ("max_solve_time",),
    ),
)
"""Thirty of them; each base can be planned, so that the spoiled place is the reason."""


def spoiled_table(case: Case) -> Table:
    """The scenario of a case."""
    table = copy.deepcopy(BASES[case.base])
    for place, value in case.spoiled.items():
        *parents, key = place.split(".")
        entry: Any = table
        for parent in parents:
            entry = entry[int(parent)] if isinstance(entry, list) else entry.setdefault(parent, {})
        entry[key] = value
    return table
