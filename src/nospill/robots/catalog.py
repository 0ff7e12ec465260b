"""The arms nospill knows: one URDF and one TOML file each in `robots/data`, and one line in the table below."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Sequence
from importlib import resources

import numpy as np

from nospill.errors import ScenarioError
from nospill.robots.robot import Robot

ROBOTS: dict[str, str] = {
    "comau-smart-six": "comau-smart-six",
}
"""Name in a scenario -> stem of the two data files."""


def load_robot(name: str) -> Robot:
    """Return an arm of the catalogue.

    Args:
        name: a key of `ROBOTS`.

    Returns:
        The arm; its arrays are read-only.

    Raises:
        ScenarioError: no arm has that name; the message lists the names and the nearest one.
    """
    if name not in ROBOTS:
        near = difflib.get_close_matches(name, ROBOTS, n=1, cutoff=0.5)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise ScenarioError(f"robot model {name!r} is not in the catalogue (known: {', '.join(sorted(ROBOTS))}){hint}")
    folder = resources.files("nospill.robots") / "data"
    facts = tomllib.loads((folder / f"{ROBOTS[name]}.toml").read_text(encoding="utf-8"))
    acceleration = facts.get("max_acceleration_rad_s2")
    return Robot(
        name=name,
        title=facts["title"],
        urdf=(folder / f"{ROBOTS[name]}.urdf").read_text(encoding="utf-8"),
        joints=tuple(facts["joints"]),
        tip=facts["tip"],
        lower=_constant(np.radians(facts["lower_deg"])),
        upper=_constant(np.radians(facts["upper_deg"])),
        max_speed=_constant(np.radians(facts["max_speed_deg_s"])),
        max_acceleration=None if acceleration is None else _constant(acceleration),
        payload=facts.get("payload_kg"),
        reach=facts.get("reach_m"),
        sources=dict(facts["sources"]),
        not_known=tuple(facts["not_known"]),
    )


def robot_table() -> list[dict[str, object]]:
    """Return one plain (JSON-ready) row per arm of the catalogue, for `nospill robots`.

    Returns:
        Rows with the keys name, title, joints (names), reach_m, payload_kg, lower_deg, upper_deg, max_speed_deg_s,
        max_acceleration_rad_s2 (None where nobody states it), sources, not_known.
    """
    return [_row(load_robot(name)) for name in ROBOTS]


def _row(robot: Robot) -> dict[str, object]:
    acceleration = robot.max_acceleration
    return {
        "name": robot.name,
        "title": robot.title,
        "joints": list(robot.joints),
        "reach_m": robot.reach,
        "payload_kg": robot.payload,
        "lower_deg": _degrees(robot.lower),
        "upper_deg": _degrees(robot.upper),
        "max_speed_deg_s": _degrees(robot.max_speed),
        "max_acceleration_rad_s2": None if acceleration is None else acceleration.tolist(),
        "sources": dict(robot.sources),
        "not_known": list(robot.not_known),
    }


def _degrees(radians: np.ndarray) -> list[float]:
    # twelve digits hide the rounding of deg -> rad -> deg
    return [float(f"{value:.12g}") for value in np.degrees(radians)]


def _constant(values: Sequence[float] | np.ndarray) -> np.ndarray:
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array
